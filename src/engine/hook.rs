//! Takes contact out of rapier's hands.

use rapier2d_f64::prelude::*;

/// rapier finds the pairs that carry this hook, and answers them with nothing: the contact laws answer instead.
pub struct Governed;

impl PhysicsHooks for Governed {
    fn filter_contact_pair(&self, _: &PairFilterContext) -> Option<SolverFlags> {
        Some(SolverFlags::empty())
    }
}
