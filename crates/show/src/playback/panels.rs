//! The plots of a run: the same quantities of several contacts, bodies or fingers over time.

use serde::{Serialize, Serializer};

use super::contacts::ShownContact;
use crate::mechanism::Mechanism;
use crate::numeric::plane::wrap_angle;
use crate::scene::{Hand, Object, Scene};
use crate::trace::schema::{JointName, SubjectKind};
use crate::trace::{Sample, Schema};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    Linear,
    /// Linear about 0, logarithmic beyond: shows 8 N and 8 kN in one plot, with their signs.
    Logarithmic,
}

/// Serialised as whether the scale is logarithmic.
impl Serialize for Scale {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bool(*self == Scale::Logarithmic)
    }
}

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

/// Label of a quantity, its key, and the key of its rate, if samples have it.
type Quantity = (&'static str, &'static str, Option<&'static str>);
/// Name of a subject, and its label, which may be empty.
pub(super) type Item = (String, String);

/// Curves of the same quantities for several subjects. Angles of joints of a finger are wrapped to −π to π.
fn curves(schema: &Schema, kind: SubjectKind, items: &[Item], quantities: &[Quantity]) -> Vec<Curve> {
    let curve = |(subject, label): &Item, &(quantity, key, rate): &Quantity| {
        let value = |key: &str| -> Value {
            let channel = schema.channel(kind, subject, key);
            match (kind, key) {
                (SubjectKind::Joint, "angle_rad") if !schema.is_mechanism() => {
                    Box::new(move |sample| wrap_angle(channel.value(sample)))
                }
                _ => Box::new(move |sample| channel.value(sample)),
            }
        };
        let name = format!("{label} {quantity}").trim().to_string();
        Curve { name, value: value(key), rate: rate.map(value) }
    };
    items.iter().flat_map(|item| quantities.iter().map(move |quantity| curve(item, quantity))).collect()
}

/// Curves of a quantity of contacts.
fn contact_curves(contacts: &[ShownContact], key: &'static str, rate: Option<&'static str>) -> Vec<Curve> {
    let curve = |contact: &ShownContact| {
        let value = |key: &'static str| -> Value {
            let contact = contact.clone();
            Box::new(move |sample| contact.value(sample, key))
        };
        Curve { name: contact.name.clone(), value: value(key), rate: rate.map(value) }
    };
    contacts.iter().map(curve).collect()
}

/// Returns the panels of a mechanism: contacts, joints, actuators, tendons, bodies without joints, and energies.
fn mechanism_panels(mechanism: &Mechanism, schema: &Schema, contacts: &[ShownContact]) -> Vec<PanelPlan> {
    let items = |names: &mut dyn Iterator<Item = &JointName>, is_linear: bool| -> Vec<Item> {
        let chosen = names.filter(|joint| joint.is_linear == is_linear);
        chosen.map(|joint| (joint.name.clone(), joint.name.clone())).collect()
    };
    let [joints, sliders] = [false, true].map(|is_linear| items(&mut schema.joints.iter(), is_linear));
    let [motors, drives] = [false, true].map(|is_linear| items(&mut schema.actuators.iter(), is_linear));
    let tendons: Vec<Item> = schema.tendons.iter().map(|name| (name.clone(), name.clone())).collect();
    let is_free = |body: &usize| mechanism.joints.iter().all(|joint| !joint.bodies.contains(&Some(*body)));
    let free = (0..mechanism.bodies.len()).filter(is_free).map(|body| &mechanism.bodies[body].name);
    let bodies: Vec<Item> = free.map(|name| (name.clone(), name.clone())).collect();
    let of = |title, unit, kind, items: &[Item], quantities: &[Quantity]| {
        panel(title, unit, curves(schema, kind, items, quantities))
    };
    let mut panels = vec![
        panel("Normal force", "N", contact_curves(contacts, "normal_n", None)),
        panel("Friction force", "N", contact_curves(contacts, "tangential_n", None)),
        panel("Gap", "m", contact_curves(contacts, "gap_m", Some("gap_rate_m_s"))),
        of("Joint angle", "rad", SubjectKind::Joint, &joints, &[("", "angle_rad", Some("rate_rad_s"))]),
        of("Joint rate", "rad/s", SubjectKind::Joint, &joints, &[("", "rate_rad_s", None)]),
        of("Slider position", "m", SubjectKind::Slider, &sliders, &[("", "position_m", Some("rate_m_s"))]),
        of("Slider rate", "m/s", SubjectKind::Slider, &sliders, &[("", "rate_m_s", None)]),
        of("Torque", "N·m", SubjectKind::Actuator, &motors, &[("", "torque_n_m", None)]),
        of("Force", "N", SubjectKind::LinearActuator, &drives, &[("", "force_n", None)]),
        of("Tendon tension", "N", SubjectKind::Tendon, &tendons, &[("", "tension_n", None)]),
        of("Tendon length", "m", SubjectKind::Tendon, &tendons, &[("", "length_m", Some("rate_m_s"))]),
        of("Position", "m", SubjectKind::Body, &bodies, &[("x", "x_m", Some("vx_m_s")), ("y", "y_m", Some("vy_m_s"))]),
        of("Velocity", "m/s", SubjectKind::Body, &bodies, &[("vx", "vx_m_s", None), ("vy", "vy_m_s", None)]),
        of("Spin", "rad/s", SubjectKind::Body, &bodies, &[("spin", "spin_rad_s", None)]),
        energy_panel(schema, !mechanism.joints.is_empty()),
    ];
    if mechanism.contacts.iter().all(|contact| contact.law.friction.is_none()) {
        panels.remove(1);
    }
    panels.retain(|panel| !panel.curves.is_empty());
    panels
}

/// Returns the panels of a scene; `contacts` are the contacts that are shown.
pub(super) fn panels(scene: &Scene, schema: &Schema, contacts: &[ShownContact]) -> Vec<PanelPlan> {
    if let Some(mechanism) = &scene.mechanism {
        return mechanism_panels(mechanism, schema, contacts);
    }
    let hand = &scene.hand;
    let contact = |title, unit, key, rate| PanelPlan {
        scale: Scale::Logarithmic,
        ..panel(title, unit, contact_curves(contacts, key, rate))
    };
    let object: Vec<Item> = hand.moving_object().iter().map(|_| (Object::NAME.to_string(), String::new())).collect();
    let body = |title, unit, quantities: &[Quantity]| {
        panel(title, unit, curves(schema, SubjectKind::Body, &object, quantities))
    };
    let has_friction = |contact| hand.law(contact).is_some_and(|law| law.friction.is_some());
    let [angles, rates, torques] = finger_panels(hand, schema);
    let mut panels = vec![
        contact("Normal force", "N", "normal_n", None),
        contact("Friction force", "N", "tangential_n", None),
        contact("Gap", "m", "gap_m", Some("gap_rate_m_s")),
        body("Object", "m", &[("x", "x_m", Some("vx_m_s")), ("y", "y_m", Some("vy_m_s"))]),
        body("Object velocity", "m/s", &[("vx", "vx_m_s", None), ("vy", "vy_m_s", None)]),
        body("Object angle", "rad", &[("angle", "angle_rad", Some("spin_rad_s"))]),
        angles,
        rates,
        energy_panel(schema, true),
        torques,
    ];
    if !hand.contacts().any(has_friction) {
        panels.remove(1);
    }
    panels.retain(|panel| !panel.curves.is_empty());
    panels
}

fn panel(title: &'static str, unit: &'static str, curves: Vec<Curve>) -> PanelPlan {
    PanelPlan { title, unit, scale: Scale::Linear, curves }
}

fn energy_panel(schema: &Schema, has_joints: bool) -> PanelPlan {
    let mut quantities: Vec<Quantity> = vec![
        ("kinetic", "kinetic_j", None),
        (if has_joints { "motor work" } else { "drive work" }, "motor_work_j", None),
        ("dissipated", "dissipated_j", None),
        ("spring", "spring_j", None),
        ("contact", "elastic_j", None),
        ("gravity", "gravity_j", None),
        ("balance", "balance_j", None),
    ];
    quantities.retain(|(name, ..)| has_joints || *name != "spring");
    let hand = [("energy".to_string(), String::new())];
    panel("Energy", "J", curves(schema, SubjectKind::Energy, &hand, &quantities))
}

/// Joints whose angles and rates are shown.
const JOINTS: [&str; 3] = ["q11", "q21", "q22"];

/// Panels of joint angles, joint rates and torques. A single finger has no label.
fn finger_panels(hand: &Hand, schema: &Schema) -> [PanelPlan; 3] {
    let is_single = hand.fingers.len() == 1;
    let named = |finger: &str, part: &str| if is_single { part.to_string() } else { format!("{finger}_{part}") };
    // Curves of all three joints of a finger, then of the next finger.
    let of_joints = |labels: [&'static str; 3], key: &'static str, rate: Option<&'static str>| -> Vec<Curve> {
        let of_finger = |finger: &String| {
            let joint = |(joint, label): (&str, &'static str)| {
                curves(schema, SubjectKind::Joint, &[(named(finger, joint), finger.clone())], &[(label, key, rate)])
            };
            JOINTS.into_iter().zip(labels).flat_map(joint).collect::<Vec<_>>()
        };
        schema.fingers.iter().flat_map(of_finger).collect()
    };
    let mut angles = of_joints(JOINTS, "angle_rad", Some("rate_rad_s"));
    let rates = of_joints(["qd11", "qd21", "qd22"], "rate_rad_s", None);
    let motors: Vec<Item> = schema.fingers.iter().map(|finger| (named(finger, "motor"), finger.clone())).collect();
    let mut torques = curves(schema, SubjectKind::Actuator, &motors, &[("motor", "torque_n_m", None)]);
    let limited = hand.fingers_by_side().zip(&schema.fingers).filter(|((_, finger), _)| finger.limit.is_some());
    let limits: Vec<Item> = limited.map(|(_, finger)| (named(finger, "limit"), finger.clone())).collect();
    let limit = |quantity: Quantity| curves(schema, SubjectKind::Limit, &limits, &[quantity]);
    if is_single {
        angles.extend(limit(("to limit", "gap_rad", Some("gap_rate_rad_s"))));
    }
    torques.extend(limit(("limit", "torque_n_m", None)));
    [panel("Joint angle", "rad", angles), panel("Joint rate", "rad/s", rates), panel("Torque", "N·m", torques)]
}
