//! Motors of a plan, and a differential as wheels.

use super::finger::{L11, base};
use super::plan::{Plan, PlannedBody, PlannedGear, PlannedHold, PlannedMotor, PlannedRotor};
use crate::gripper::Body;
use crate::scene::{Differential, Motor, Side};

pub(super) fn planned(motor: &Motor, on: Vec<(usize, f64)>) -> PlannedMotor {
    PlannedMotor { on, actuation: motor.actuation.clone(), no_load_speed_rad_s: motor.no_load_speed_rad_s }
}

pub(super) fn add_rotor(plan: &mut Plan, body: usize, inertia_kg_m2: f64) {
    if inertia_kg_m2 > 0.0 {
        plan.rotors.push(PlannedRotor { body, inertia_kg_m2 });
    }
}

/// Half of the input's torque goes to each finger; what has inertia is a wheel, geared to both driven links: the input turns by the mean of
/// their closing angles, the seesaw by half of their difference.
pub(super) fn add_differential(plan: &mut Plan, differential: &Differential) {
    let Differential { motor, seesaw_inertia_kg_m2 } = differential;
    let [right, left] = Side::BOTH.map(|side| base(side) + L11);
    plan.motors.push(planned(motor, vec![(right, 0.5), (left, -0.5)]));
    let (on, against) = ((right, 0.5), Some((left, -0.5)));
    plan.holds.extend(motor.brake.map(|brake| PlannedHold { on, against, brake }));
    let inertias = [motor.inertia_kg_m2, *seesaw_inertia_kg_m2];
    if inertias == [0.0; 2] {
        return;
    }
    let first = plan.bodies.len();
    let palm = plan.palm().map(|(body, _)| body);
    (0..2).for_each(|index| add_rotor(plan, first + index, inertias[index]));
    // A wheel without inertia would follow for nothing: one that nothing drives stands in for it.
    let geared = inertias.map(|inertia| if inertia > 0.0 { 1.0 } else { 0.0 });
    plan.bodies.extend(inertias.map(|inertia| PlannedBody {
        body: Body { mass_kg: 0.0, com_m: [0.0; 2], inertia_kg_m2: if inertia > 0.0 { inertia } else { 1.0 } },
        origin_m: [0.0; 2],
        angle_rad: 0.0,
        velocity_m_s: [0.0; 2],
        rate_rad_s: 0.0,
        shape: None,
    }));
    let rates = [right, left].map(|body| plan.bodies[body].rate_rad_s);
    plan.bodies[first].rate_rad_s = geared[0] * 0.5 * (rates[0] - rates[1]);
    plan.bodies[first + 1].rate_rad_s = geared[1] * 0.5 * (rates[0] + rates[1]);
    let mut wheels = vec![
        (first, [1.0, 0.0]),
        (first + 1, [0.0, 1.0]),
        (right, [-0.5 * geared[0], -0.5 * geared[1]]),
        (left, [0.5 * geared[0], -0.5 * geared[1]]),
    ];
    // The palm's own turning cancels in the mean of both closing angles, and counts in what wheels turn against it.
    wheels.extend(palm.map(|palm| (palm, [-geared[0], 0.0])));
    plan.gears.push(PlannedGear { wheels });
}

/// Torque of the brakes on the driven link of a finger, N·m, counted as closing it; `torque` is that of a hold.
pub fn brake_torque(plan: &Plan, side: Side, torque: impl Fn(usize) -> f64) -> f64 {
    let driven = base(side) + L11;
    let part = |hold: &PlannedHold| {
        let on = std::iter::once(hold.on).chain(hold.against).find(|(body, _)| *body == driven);
        on.map_or(0.0, |(_, part)| side.mirror() * part)
    };
    plan.holds.iter().enumerate().map(|(index, hold)| part(hold) * torque(index)).sum()
}
