//! rapier's own rigid contact, for scenes that ask for it: what it did, read from its contact manifolds.

use super::linkage::Twist;
use super::plan::{Plan, PlannedDrive};
use super::touch::{Row, Touch};
use super::world::World;
use crate::scene::Response;

/// Impulses of one contact in one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Native {
    /// Index among the stops and contacts of the plan.
    pub index: usize,
    pub normal: f64,
    /// Along the tangent, on the body of the contact; it opposes the slip.
    pub tangential: f64,
    /// Closing rate before the step.
    pub closing: f64,
}

/// Reads the impulses of the last step, and returns their work on all bodies, and on those that are driven. `touches` are those of the step's start.
pub fn read(
    world: &World,
    plan: &Plan,
    touches: &[Touch],
    before: &[Twist],
    after: &[Twist],
    out: &mut Vec<Native>,
) -> (f64, f64) {
    out.clear();
    let Response::Rapier { .. } = world.response else { return (0.0, 0.0) };
    let (mut work, mut on_driven) = (0.0, 0.0);
    for (contact, [own, other]) in world.contacts.iter().enumerate() {
        let Some(pair) = world.physics.narrow_phase.contact_pair(*own, *other) else { continue };
        let index = plan.stops.len() + contact;
        let Some(touch) = touches.iter().find(|touch| touch.index == index) else { continue };
        let points = pair.manifolds().iter().flat_map(|manifold| &manifold.points);
        let (mut normal, mut tangential) = (0.0, 0.0);
        for point in points {
            normal += point.data.impulse;
            tangential += point.data.tangent_impulse[0].abs();
        }
        let slip = touch.slip_row.rate(after);
        let tangential = -tangential.copysign(slip);
        // A rigid impulse does the work of the mean of the rates before and after it.
        let mean = |row: &Row| 0.5 * (row.rate(before) + row.rate(after));
        work += normal * mean(&touch.normal_row) + tangential * mean(&touch.slip_row);
        for PlannedDrive { body, .. } in &plan.drives {
            let mean = |row: &Row| 0.5 * (row.rate_of(*body, &before[*body]) + row.rate_of(*body, &after[*body]));
            on_driven += normal * mean(&touch.normal_row) + tangential * mean(&touch.slip_row);
        }
        out.push(Native { index, normal, tangential, closing: -touch.normal_row.rate(before) });
    }
    (work, on_driven)
}
