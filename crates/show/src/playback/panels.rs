//! The plots of a run: the same quantities of several contacts, bodies or fingers over time.

use super::build::Scale;
use crate::numeric::plane::wrap_angle;
use crate::scene::{GripperContact, Side, System};
use crate::trace::{BodyState, ContactSample, Energy, FingerContact, FingerState, Sample};

/// Function that extracts a number from a sample.
pub(super) type Value = Box<dyn Fn(&Sample) -> f64>;

/// A curve before evaluation: the functions that extract its value and, optionally, its rate from a sample.
pub(super) struct Curve {
    pub name: String,
    pub value: Value,
    pub rate: Option<Value>,
}

/// A panel before evaluation.
pub(super) struct PanelPlan {
    pub title: &'static str,
    /// SI unit of its values.
    pub unit: &'static str,
    pub scale: Scale,
    pub curves: Vec<Curve>,
}

/// Name of a quantity, and functions for its value and, optionally, its rate.
type Quantity<T> = (&'static str, fn(&T) -> f64, Option<fn(&T) -> f64>);
/// Index of a contact, body or finger in a sample, and its name, which may be empty.
type Item = (usize, String);

/// Curves of the same quantities for several items.
fn curves<T: 'static>(items: &[Item], quantities: &[Quantity<T>], states: fn(&Sample) -> &[T]) -> Vec<Curve> {
    let curve = |(index, item): &Item, &(quantity, value, rate): &Quantity<T>| {
        let index = *index;
        let of_item =
            move |quantity: fn(&T) -> f64| -> Value { Box::new(move |sample| quantity(&states(sample)[index])) };
        let name = format!("{item} {quantity}").trim().to_string();
        Curve { name, value: of_item(value), rate: rate.map(of_item) }
    };
    items.iter().flat_map(|item| quantities.iter().map(move |quantity| curve(item, quantity))).collect()
}

/// Returns the panels of a scene; `contacts` are the contacts that are shown.
pub(super) fn panels(system: &System, contacts: &[Item]) -> Vec<PanelPlan> {
    let has_fingers = !system.fingers.is_empty();
    let contact = |title, unit, quantity: Quantity<ContactSample>| PanelPlan {
        scale: if has_fingers { Scale::Logarithmic } else { Scale::Linear },
        ..panel(title, unit, curves(contacts, &[quantity], |sample| &sample.contacts))
    };
    let bodies = moving_bodies(system);
    let body = |title, unit, quantities: &[Quantity<BodyState>]| {
        panel(title, unit, curves(&bodies, quantities, |sample| &sample.bodies))
    };
    let [position, velocity] = if has_fingers { ["Object", "Object velocity"] } else { ["Position", "Velocity"] };
    let mut panels = vec![
        contact("Normal force", "N", ("", |contact| contact.normal_n, None)),
        contact("Friction force", "N", ("", |contact| contact.tangential_n, None)),
        contact("Gap", "m", ("", |contact| contact.gap_m, Some(|contact| contact.gap_rate_m_s))),
        body(
            position,
            "m",
            &[
                ("x", |body| body.centre_m[0], Some(|body| body.velocity_m_s[0])),
                ("y", |body| body.centre_m[1], Some(|body| body.velocity_m_s[1])),
            ],
        ),
        body(velocity, "m/s", &[("vx", |body| body.velocity_m_s[0], None), ("vy", |body| body.velocity_m_s[1], None)]),
        match has_fingers {
            true => body("Object angle", "rad", &[("angle", |body| body.angle_rad, Some(|body| body.spin_rad_s))]),
            false => body("Spin", "rad/s", &[("spin", |body| body.spin_rad_s, None)]),
        },
        energy_panel(has_fingers),
    ];
    if !has_friction(system) {
        panels.remove(1);
    }
    if has_fingers {
        let [angles, rates, torques] = finger_panels(system);
        let energy = panels.pop();
        panels.extend([angles, rates].into_iter().chain(energy).chain([torques]));
    }
    panels.retain(|panel| !panel.curves.is_empty());
    panels
}

fn panel(title: &'static str, unit: &'static str, curves: Vec<Curve>) -> PanelPlan {
    PanelPlan { title, unit, scale: Scale::Linear, curves }
}

/// The moving discs, or the moving object of fingers, which has no name.
fn moving_bodies(system: &System) -> Vec<Item> {
    if !system.fingers.is_empty() {
        return system.moving_object().iter().map(|_| (0, String::new())).collect();
    }
    let moving = system.discs.iter().enumerate().filter(|(_, disc)| disc.motion.moves());
    moving.map(|(index, disc)| (index, disc.name.clone())).collect()
}

fn has_friction(system: &System) -> bool {
    let gripper = |place: &GripperContact| system.law(*place).is_some_and(|law| law.friction.is_some());
    match system.fingers.is_empty() {
        true => system.between_discs.is_some_and(|law| law.friction.is_some()),
        false => system.gripper_contacts().iter().any(gripper),
    }
}

fn energy_panel(has_fingers: bool) -> PanelPlan {
    let mut quantities: Vec<Quantity<Energy>> = vec![
        ("kinetic", |energy| energy.kinetic_j, None),
        (if has_fingers { "motor work" } else { "drive work" }, |energy| energy.motor_work_j, None),
        ("dissipated", |energy| energy.dissipated_j, None),
        ("spring", |energy| energy.spring_j, None),
        ("contact", |energy| energy.elastic_j, None),
        ("gravity", |energy| energy.gravity_j, None),
        ("balance", |energy| energy.balance_j, None),
    ];
    quantities.retain(|(name, ..)| has_fingers || *name != "spring");
    let curves = curves(&[(0, String::new())], &quantities, |sample| std::slice::from_ref(&sample.energy));
    panel("Energy", "J", curves)
}

/// Panels of joint angles, joint rates and torques. A single finger has no name.
fn finger_panels(system: &System) -> [PanelPlan; 3] {
    let is_single = system.fingers.len() == 1;
    let name = |side: Side| if is_single { String::new() } else { side.name().to_string() };
    let fingers: Vec<Item> = system.fingers_by_side().map(|(side, _)| (side as usize, name(side))).collect();
    let joints = |quantities: &[Quantity<FingerState>]| curves(&fingers, quantities, |sample| &sample.fingers);
    let mut angles = joints(&[
        ("q11", |finger| wrap_angle(finger.q11_rad), Some(|finger| finger.qd11_rad_s)),
        ("q21", |finger| wrap_angle(finger.q21_rad), Some(|finger| finger.qd21_rad_s)),
        ("q22", |finger| wrap_angle(finger.q22_rad), Some(|finger| finger.qd22_rad_s)),
    ]);
    let rates = joints(&[
        ("qd11", |finger| finger.qd11_rad_s, None),
        ("qd21", |finger| finger.qd21_rad_s, None),
        ("qd22", |finger| finger.qd22_rad_s, None),
    ]);
    let mut torques = joints(&[("motor", |finger| finger.motor_torque_n_m, None)]);
    let limited = system.fingers_by_side().filter(|(_, finger)| finger.limit.is_some());
    let limits: Vec<Item> =
        limited.map(|(side, _)| (GripperContact::Finger(side, FingerContact::Limit).index(), name(side))).collect();
    let limit = |quantity: Quantity<ContactSample>| curves(&limits, &[quantity], |sample| &sample.contacts);
    if is_single {
        angles.extend(limit(("to limit", |contact| contact.gap_m, Some(|contact| contact.gap_rate_m_s))));
    }
    torques.extend(limit(("limit", |contact| contact.normal_n, None)));
    [panel("Joint angle", "rad", angles), panel("Joint rate", "rad/s", rates), panel("Torque", "N·m", torques)]
}
