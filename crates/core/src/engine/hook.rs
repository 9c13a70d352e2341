//! Hook that disables rapier's contact response.

use rapier2d_f64::prelude::*;

/// Disables solver contacts and response for the pairs that carry this hook; the contact laws replace them, and
/// rapier's broad phase still finds the pairs. `None` rather than empty solver flags, so that rapier skips the unused
/// contact geometry.
pub struct LawContactHook;

impl PhysicsHooks for LawContactHook {
    fn filter_contact_pair(&self, _: &PairFilterContext) -> Option<SolverFlags> {
        None
    }
}
