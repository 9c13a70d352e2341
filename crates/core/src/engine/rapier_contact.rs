//! Impulses of rapier's own contact, for scenes that select it in place of the contact laws.

use super::candidates::{self, ContactCandidate};
use super::coordinate::{Row, Twist};
use super::plan::{Plan, PlannedDrive};
use super::world::World;
use crate::scene::Response;

/// Impulses of a contact of rapier in one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RapierContact {
    /// Element index among the stops and contacts of the plan.
    pub index: usize,
    pub normal: f64,
    /// Impulse on the body of the contact along the tangent; it opposes the slip.
    pub tangential: f64,
    /// Closing rate before the step.
    pub closing_rate: f64,
}

/// Reads the impulses of rapier's own contact in the last step from its manifolds; returns their work on all bodies and
/// on the driven bodies. `candidates` are those at the start of the step.
pub(super) fn read_rapier_impulses(
    world: &World,
    plan: &Plan,
    candidates: &[ContactCandidate],
    before: &[Twist],
    after: &[Twist],
    out: &mut Vec<RapierContact>,
) -> (f64, f64) {
    out.clear();
    let Response::Rapier { .. } = world.response else { return (0.0, 0.0) };
    let (mut work, mut on_driven) = (0.0, 0.0);
    for (contact, [collider, other]) in world.contacts.iter().enumerate() {
        let Some(pair) = world.physics.narrow_phase.contact_pair(*collider, *other) else { continue };
        let index = plan.stops.len() + contact;
        let Some(candidate) = candidates::find(candidates, index) else { continue };
        let points = pair.manifolds().iter().flat_map(|manifold| &manifold.points);
        let (mut normal, mut tangential) = (0.0, 0.0);
        for point in points {
            normal += point.data.impulse;
            tangential += point.data.tangent_impulse[0].abs();
        }
        let slip = candidate.slip_row.rate(after);
        let tangential = -tangential.copysign(slip);
        // The work of a rigid impulse uses the mean of the rates before and after it.
        let mean = |row: &Row| 0.5 * (row.rate(before) + row.rate(after));
        work += normal * mean(&candidate.normal_row) + tangential * mean(&candidate.slip_row);
        for PlannedDrive { body, .. } in &plan.drives {
            let mean = |row: &Row| 0.5 * (row.rate_of(*body, &before[*body]) + row.rate_of(*body, &after[*body]));
            on_driven += normal * mean(&candidate.normal_row) + tangential * mean(&candidate.slip_row);
        }
        out.push(RapierContact { index, normal, tangential, closing_rate: -candidate.normal_row.rate(before) });
    }
    (work, on_driven)
}
