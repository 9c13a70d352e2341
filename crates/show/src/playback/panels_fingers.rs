//! Plots of fingers and the object they grasp.

use super::build::{Curve, PanelPlan, Scale, panel_plan};
use super::panels::{Quantity, contact_curves, curve_name, curves, energy_panel, gap_curves};
use crate::numeric::plane::wrap_angle;
use crate::scene::{GripperContact, Side, System};
use crate::trace::{BodyState, FingerContact, FingerState, Sample};

/// Panels of fingers and their object; `contacts` are the names and indices of the contacts that are shown.
pub(super) fn finger_panels(system: &System, contacts: &[(String, usize)]) -> Vec<PanelPlan<'static>> {
    let has_friction = |place: &GripperContact| system.law(*place).is_some_and(|law| law.friction.is_some());
    let friction = match system.gripper_contacts().iter().any(has_friction) {
        true => contact_curves(contacts, |contact| contact.tangential_n),
        false => Vec::new(),
    };
    let fingers: Vec<(usize, String)> =
        system.fingers_by_side().map(|(side, _)| (side as usize, prefix(system, side))).collect();
    let joints = |quantities: &[Quantity<FingerState>]| curves(&fingers, quantities, |sample| &sample.fingers);
    let mut angles = joints(&[
        ("q11", |finger| wrap_angle(finger.q11_rad), Some(|finger| finger.qd11_rad_s)),
        ("q21", |finger| wrap_angle(finger.q21_rad), Some(|finger| finger.qd21_rad_s)),
        ("q22", |finger| wrap_angle(finger.q22_rad), Some(|finger| finger.qd22_rad_s)),
    ]);
    let mut torques = joints(&[("motor", |finger| finger.motor_torque_n_m, None)]);
    for (side, _) in system.fingers_by_side().filter(|(_, finger)| finger.limit.is_some()) {
        let index = GripperContact::Finger(side, FingerContact::Limit).index();
        if system.fingers.len() == 1 {
            let to_limit = Curve::new("to limit", move |sample: &Sample| sample.contacts[index].gap_m);
            angles.push(to_limit.with_rate(move |sample| sample.contacts[index].gap_rate_m_s));
        }
        let limit = move |sample: &Sample| sample.contacts[index].normal_n;
        torques.push(Curve::new(curve_name(&prefix(system, side), "limit"), limit));
    }
    let object = |curves: Vec<Curve<'static>>| match system.moving_object() {
        Some(_) => curves,
        None => Vec::new(),
    };
    vec![
        panel_plan("Normal force", "N", Scale::Logarithmic, contact_curves(contacts, |contact| contact.normal_n)),
        panel_plan("Friction force", "N", Scale::Logarithmic, friction),
        panel_plan("Gap", "m", Scale::Logarithmic, gap_curves(contacts)),
        panel_plan(
            "Object",
            "m",
            Scale::Linear,
            object(vec![
                body("x", |body| body.centre_m[0]).with_rate(|sample| sample.bodies[0].velocity_m_s[0]),
                body("y", |body| body.centre_m[1]).with_rate(|sample| sample.bodies[0].velocity_m_s[1]),
            ]),
        ),
        panel_plan(
            "Object velocity",
            "m/s",
            Scale::Linear,
            object(vec![body("vx", |body| body.velocity_m_s[0]), body("vy", |body| body.velocity_m_s[1])]),
        ),
        panel_plan(
            "Object angle",
            "rad",
            Scale::Linear,
            object(vec![body("angle", |body| body.angle_rad).with_rate(|sample| sample.bodies[0].spin_rad_s)]),
        ),
        panel_plan("Joint angle", "rad", Scale::Linear, angles),
        panel_plan(
            "Joint rate",
            "rad/s",
            Scale::Linear,
            joints(&[
                ("qd11", |finger| finger.qd11_rad_s, None),
                ("qd21", |finger| finger.qd21_rad_s, None),
                ("qd22", |finger| finger.qd22_rad_s, None),
            ]),
        ),
        energy_panel(),
        panel_plan("Torque", "N·m", Scale::Linear, torques),
    ]
}

/// Prefix of the quantities of a finger: its side, or nothing for a single finger.
fn prefix(system: &System, side: Side) -> String {
    if system.fingers.len() == 1 { String::new() } else { side.name().to_string() }
}

fn body(name: &str, value: fn(&BodyState) -> f64) -> Curve<'static> {
    Curve::new(name, move |sample: &Sample| value(&sample.bodies[0]))
}
