//! The plots of fingers and what they grasp.

use super::develop::{Curve, Plan, Scale, plan};
use super::panels::{Quantity, curves, energies, gaps, named, of_contacts};
use crate::numeric::plane::turned;
use crate::scene::{Place, Side, System};
use crate::trace::{BodyState, FingerState, Sample, Site};

/// Of fingers and what they grasp; `contacts` are those that are shown, by their names and indices.
pub(super) fn of_fingers(system: &System, contacts: &[(String, usize)]) -> Vec<Plan<'static>> {
    let rubs = |place: &Place| system.law(*place).is_some_and(|law| law.friction.is_some());
    let friction = match system.places().iter().any(rubs) {
        true => of_contacts(contacts, |contact| contact.tangential_n),
        false => Vec::new(),
    };
    let fingers: Vec<(usize, String)> = system.sided().map(|(side, _)| (side as usize, prefix(system, side))).collect();
    let joints = |quantities: &[Quantity<FingerState>]| curves(&fingers, quantities, |sample| &sample.fingers);
    let mut angles = joints(&[
        ("q11", |finger| turned(finger.q11_rad), Some(|finger| finger.qd11_rad_s)),
        ("q21", |finger| turned(finger.q21_rad), Some(|finger| finger.qd21_rad_s)),
        ("q22", |finger| turned(finger.q22_rad), Some(|finger| finger.qd22_rad_s)),
    ]);
    let mut torques = joints(&[("motor", |finger| finger.motor_torque_n_m, None)]);
    for (side, _) in system.sided().filter(|(_, finger)| finger.limit.is_some()) {
        let index = Place::Finger(side, Site::Limit).index();
        if system.fingers.len() == 1 {
            let to_limit = Curve::new("to limit", move |sample: &Sample| sample.contacts[index].gap_m);
            angles.push(to_limit.with_rate(move |sample| sample.contacts[index].gap_rate_m_s));
        }
        let limit = move |sample: &Sample| sample.contacts[index].normal_n;
        torques.push(Curve::new(named(&prefix(system, side), "limit"), limit));
    }
    let object = |curves: Vec<Curve<'static>>| match system.moving_object() {
        Some(_) => curves,
        None => Vec::new(),
    };
    vec![
        plan("Normal force", "N", Scale::Logarithmic, of_contacts(contacts, |contact| contact.normal_n)),
        plan("Friction force", "N", Scale::Logarithmic, friction),
        plan("Gap", "m", Scale::Logarithmic, gaps(contacts)),
        plan(
            "Object",
            "m",
            Scale::Linear,
            object(vec![
                body("x", |body| body.centre_m[0]).with_rate(|sample| sample.bodies[0].velocity_m_s[0]),
                body("y", |body| body.centre_m[1]).with_rate(|sample| sample.bodies[0].velocity_m_s[1]),
            ]),
        ),
        plan(
            "Object velocity",
            "m/s",
            Scale::Linear,
            object(vec![body("vx", |body| body.velocity_m_s[0]), body("vy", |body| body.velocity_m_s[1])]),
        ),
        plan(
            "Object angle",
            "rad",
            Scale::Linear,
            object(vec![body("angle", |body| body.angle_rad).with_rate(|sample| sample.bodies[0].spin_rad_s)]),
        ),
        plan("Joint angle", "rad", Scale::Linear, angles),
        plan(
            "Joint rate",
            "rad/s",
            Scale::Linear,
            joints(&[
                ("qd11", |finger| finger.qd11_rad_s, None),
                ("qd21", |finger| finger.qd21_rad_s, None),
                ("qd22", |finger| finger.qd22_rad_s, None),
            ]),
        ),
        energies(),
        plan("Torque", "N·m", Scale::Linear, torques),
    ]
}

/// What stands before quantities of a finger; one that is alone needs no side.
fn prefix(system: &System, side: Side) -> String {
    if system.fingers.len() == 1 { String::new() } else { side.word().to_string() }
}

fn body(name: &str, value: fn(&BodyState) -> f64) -> Curve<'static> {
    Curve::new(name, move |sample: &Sample| value(&sample.bodies[0]))
}
