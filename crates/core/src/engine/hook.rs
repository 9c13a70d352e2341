//! Takes contact out of rapier's hands.

use rapier2d_f64::prelude::*;

/// rapier's broad phase finds the pairs that carry this hook; they get no solver contacts and no response, for the contact
/// laws answer instead. `None` rather than empty solver flags: rapier then does not compute the geometry it has no use for.
pub struct Governed;

impl PhysicsHooks for Governed {
    fn filter_contact_pair(&self, _: &PairFilterContext) -> Option<SolverFlags> {
        None
    }
}
