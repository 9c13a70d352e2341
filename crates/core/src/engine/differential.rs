//! Adds motors to a plan, and models a differential as gear wheels.

use super::finger::{L11, first_link};
use super::plan::{Plan, PlannedBody, PlannedBrake, PlannedGear, PlannedMotor, PlannedRotor};
use crate::gripper::Body;
use crate::scene::{Differential, Motor, Side};

pub(super) fn plan_motor(motor: &Motor, on: Vec<(usize, f64)>) -> PlannedMotor {
    PlannedMotor { on, actuation: motor.actuation.clone(), no_load_speed_rad_s: motor.no_load_speed_rad_s }
}

pub(super) fn add_rotor(plan: &mut Plan, body: usize, inertia_kg_m2: f64) {
    if inertia_kg_m2 > 0.0 {
        plan.rotors.push(PlannedRotor { body, inertia_kg_m2 });
    }
}

/// Adds a differential: each finger gets half of the input torque. Components with inertia are wheels geared to both
/// driven links: the input turns by the mean of their closing angles, the seesaw by half of their difference.
pub(super) fn add_differential(plan: &mut Plan, differential: &Differential) {
    let Differential { motor, seesaw_inertia_kg_m2 } = differential;
    let [right, left] = Side::BOTH.map(|side| first_link(side) + L11);
    plan.motors.push(plan_motor(motor, vec![(right, 0.5), (left, -0.5)]));
    let (on, against) = ((right, 0.5), Some((left, -0.5)));
    plan.brakes.extend(motor.brake.map(|brake| PlannedBrake { on, against, brake }));
    let inertias = [motor.inertia_kg_m2, *seesaw_inertia_kg_m2];
    if inertias == [0.0; 2] {
        return;
    }
    let first = plan.bodies.len();
    let palm = plan.palm().map(|(body, _)| body);
    (0..2).for_each(|index| add_rotor(plan, first + index, inertias[index]));
    // A wheel without inertia has no effect; a decoupled dummy wheel replaces it.
    let is_geared = inertias.map(|inertia| if inertia > 0.0 { 1.0 } else { 0.0 });
    plan.bodies.extend(inertias.map(|inertia| PlannedBody {
        body: Body { mass_kg: 0.0, com_m: [0.0; 2], inertia_kg_m2: if inertia > 0.0 { inertia } else { 1.0 } },
        origin_m: [0.0; 2],
        angle_rad: 0.0,
        velocity_m_s: [0.0; 2],
        rate_rad_s: 0.0,
        shape: None,
    }));
    let rates = [right, left].map(|body| plan.bodies[body].rate_rad_s);
    plan.bodies[first].rate_rad_s = is_geared[0] * 0.5 * (rates[0] - rates[1]);
    plan.bodies[first + 1].rate_rad_s = is_geared[1] * 0.5 * (rates[0] + rates[1]);
    let mut wheels = vec![
        (first, [1.0, 0.0]),
        (first + 1, [0.0, 1.0]),
        (right, [-0.5 * is_geared[0], -0.5 * is_geared[1]]),
        (left, [0.5 * is_geared[0], -0.5 * is_geared[1]]),
    ];
    // The rotation of the palm cancels in the mean of both closing angles, but counts for wheels that turn relative to
    // it.
    wheels.extend(palm.map(|palm| (palm, [-is_geared[0], 0.0])));
    plan.gears.push(PlannedGear { wheels });
}

/// Torque of the brakes on the driven link of a finger, N·m, positive in closing; `torque` returns the torque of a
/// brake by its index.
pub fn driven_link_brake_torque(plan: &Plan, side: Side, torque: impl Fn(usize) -> f64) -> f64 {
    let driven = first_link(side) + L11;
    let ratio = |brake: &PlannedBrake| {
        let on = std::iter::once(brake.on).chain(brake.against).find(|(body, _)| *body == driven);
        on.map_or(0.0, |(_, ratio)| side.mirror() * ratio)
    };
    plan.brakes.iter().enumerate().map(|(index, brake)| ratio(brake) * torque(index)).sum()
}
