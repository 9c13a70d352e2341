//! Forces in the joints of a finger, from the Newton–Euler equations of its links. The equations of motion in q_a do not
//! contain them; here they follow from a known motion and known loads.

use super::kinematics::Directions;
use crate::gripper::{Body, Finger};
use crate::numeric::plane::{Vector, add, cross, perp, rotate, scale_by, sub};

/// Absolute angular rates and accelerations of l11, l21, l12 and l22.
#[derive(Clone, Copy, Debug)]
pub struct LinkMotion {
    pub rates: [f64; 4],
    pub accelerations: [f64; 4],
}

/// Loads on the links besides the joint forces.
#[derive(Clone, Copy, Debug, Default)]
pub struct LinkLoads {
    pub gravity_m_s2: [f64; 2],
    /// Sum of the contact forces on l21, N.
    pub proximal_n: [f64; 2],
    /// Sum of the contact forces on l22, N.
    pub distal_n: [f64; 2],
    /// Sum of the moments of these forces about the joint of l22 with l21, N·m.
    pub distal_moment_n_m: f64,
    /// Torques of the springs and the joint limit on l12 and on l22, N·m.
    pub torques_n_m: [f64; 2],
}

/// Returns the forces in the five pins, N: those of q11 on l11, q21 on l21, q12 on l12, q22 on l22, and q13 on l22. The
/// pin q13 closes the loop. The forces are not finite where l12 and l22 are in line.
///
/// The moments of l12 about its joint with l11, and of l22 about its joint with l21, determine the force in q13.
pub fn joint_forces(finger: &Finger, pose: &Directions<f64>, motion: &LinkMotion, loads: &LinkLoads) -> [[f64; 2]; 5] {
    let (lengths, bodies) = (&finger.lengths, &finger.bodies);
    let still = [0.0; 2];
    let [one, two, three, four] = [0, 1, 2, 3].map(|k| (motion.rates[k], motion.accelerations[k]));
    let first_end = accelerated(still, scale_by(pose.e1, lengths.l11_m), one);
    let second_end = accelerated(still, scale_by(pose.e2, lengths.l21_m), two);
    let inertial = |body: &Body, joint: [f64; 2], direction: Vector<f64>, rate: (f64, f64)| {
        let arm = rotate(direction, body.com_m);
        let force = scale_by(sub(loads.gravity_m_s2, accelerated(joint, arm, rate)), body.mass_kg);
        (force, cross(arm, force) - body.inertia_kg_m2 * rate.1)
    };
    let (f11, _) = inertial(&bodies.l11, still, pose.e1, one);
    let (f21, _) = inertial(&bodies.l21, still, pose.e2, two);
    let (f12, moment12) = inertial(&bodies.l12, first_end, pose.e3, three);
    let (f22, moment22) = inertial(&bodies.l22, second_end, pose.e4, four);
    // With the force F in q13 on l22: l12 e3 × F = moment12 + torque, and l22 e4 × F = −(moment22 + contacts + torque).
    let sine = cross(pose.e3, pose.e4);
    let along4 = (moment12 + loads.torques_n_m[0]) / (lengths.l12_m * sine);
    let along3 = (moment22 + loads.distal_moment_n_m + loads.torques_n_m[1]) / (lengths.l22_m * sine);
    let q13 = add(scale_by(pose.e3, along3), scale_by(pose.e4, along4));
    let q12 = sub(q13, f12);
    let q22 = scale_by(add(add(q13, f22), loads.distal_n), -1.0);
    [sub(q12, f11), sub(sub(q22, f21), loads.proximal_n), q12, q22, q13]
}

/// Acceleration of the end of an arm that rotates with a rate and an angular acceleration, from that of its start.
fn accelerated(start: [f64; 2], arm: Vector<f64>, (rate, acceleration): (f64, f64)) -> [f64; 2] {
    add(start, sub(scale_by(perp(arm), acceleration), scale_by(arm, rate * rate)))
}
