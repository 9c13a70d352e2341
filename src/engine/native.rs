//! rapier's own rigid contact, for scenes that ask for it: what it did, read from its contact manifolds.

use super::linkage::Twist;
use super::plan::Plan;
use super::touch::Touch;
use super::world::World;
use crate::gripper::Site;
use crate::scene::Response;

/// Impulses of one contact in one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Native {
    pub site: Site,
    pub normal: f64,
    /// Along the tangent, on the phalanx; it opposes the slip.
    pub tangential: f64,
    /// Closing rate before the step.
    pub closing: f64,
}

/// Reads the impulses of the last step, and returns their work on the bodies. `touches` are those of the step's start.
pub fn read(
    world: &World,
    plan: &Plan,
    touches: &[Touch],
    before: &[Twist],
    after: &[Twist],
    out: &mut Vec<Native>,
) -> f64 {
    out.clear();
    let (Response::Rapier { .. }, Some(object)) = (world.response, world.object) else { return 0.0 };
    let mut work = 0.0;
    for (index, contact) in plan.contacts.iter().enumerate() {
        let Some(pair) = world.physics.narrow_phase.contact_pair(world.phalanges[index], object) else { continue };
        let Some(touch) = touches.iter().find(|touch| touch.site == contact.site) else { continue };
        let points = pair.manifolds().iter().flat_map(|manifold| &manifold.points);
        let (mut normal, mut tangential) = (0.0, 0.0);
        for point in points {
            normal += point.data.impulse;
            tangential += point.data.tangent_impulse[0].abs();
        }
        let slip = touch.slip_row.rate(after);
        let tangential = -tangential.copysign(slip);
        // A rigid impulse does the work of the mean of the rates before and after it.
        let mean = |row: &super::touch::Row| 0.5 * (row.rate(before) + row.rate(after));
        work += normal * mean(&touch.normal_row) + tangential * mean(&touch.slip_row);
        out.push(Native { site: contact.site, normal, tangential, closing: -touch.normal_row.rate(before) });
    }
    work
}
