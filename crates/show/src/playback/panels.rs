//! The plots of a run: the same quantities of several contacts, bodies or joints over time.

use serde::{Serialize, Serializer};

use super::contacts::ShownContact;
use crate::mechanism::{Joint, Mechanism, Spring};
use crate::scene::Scene;
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

/// Curves of the same quantities for several subjects.
fn curves(schema: &Schema, kind: SubjectKind, items: &[Item], quantities: &[Quantity]) -> Vec<Curve> {
    let curve = |(subject, label): &Item, &(quantity, key, rate): &Quantity| {
        let value = |key: &str| -> Value {
            let channel = schema.channel(kind, subject, key);
            Box::new(move |sample| channel.value(sample))
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

/// Returns the panels of a scene: contacts, joints, actuators, tendons, bodies without joints, and energies; `contacts` are
/// the contacts that are shown.
pub(super) fn panels(scene: &Scene, schema: &Schema, contacts: &[ShownContact]) -> Vec<PanelPlan> {
    let mechanism = scene.drawn_mechanism();
    let items = |names: &mut dyn Iterator<Item = &JointName>, is_linear: bool| -> Vec<Item> {
        let chosen = names.filter(|joint| joint.is_linear == is_linear);
        chosen.map(|joint| (joint.name.clone(), joint.name.clone())).collect()
    };
    let shown = schema.joints.iter().enumerate().filter(|(joint, _)| is_shown(&mechanism, *joint));
    let shown: Vec<&JointName> = shown.map(|(_, name)| name).collect();
    let [joints, sliders] = [false, true].map(|is_linear| items(&mut shown.iter().copied(), is_linear));
    let [motors, drives] = [false, true].map(|is_linear| items(&mut schema.actuators.iter(), is_linear));
    let limits = schema.contacts.iter().filter(|contact| contact.is_angular);
    let limits: Vec<Item> = limits.map(|contact| (contact.name.clone(), contact.name.clone())).collect();
    let named = |names: &[String]| -> Vec<Item> { names.iter().map(|name| (name.clone(), name.clone())).collect() };
    let tendons = named(&schema.tendons);
    // Without friction the tension is the same everywhere.
    let rubs = |name: &&String| {
        mechanism.tendons.iter().any(|tendon| tendon.has_friction() && name.starts_with(&format!("{}[", tendon.name)))
    };
    let places: Vec<Item> = schema.elements.iter().filter(rubs).map(|name| (name.clone(), name.clone())).collect();
    let is_free = |body: &usize| !mechanism.has_joint(Some(*body));
    let free = mechanism.reported_bodies().filter(is_free).map(|body| &mechanism.bodies[body].name);
    let bodies: Vec<Item> = free.map(|name| (name.clone(), name.clone())).collect();
    let of = |title, unit, kind, items: &[Item], quantities: &[Quantity]| {
        panel(title, unit, curves(schema, kind, items, quantities))
    };
    // Forces of mechanisms reach from their weights to impacts.
    let scale = if mechanism.joints.is_empty() { Scale::Linear } else { Scale::Logarithmic };
    let contact =
        |title, unit, key, rate| PanelPlan { scale, ..panel(title, unit, contact_curves(contacts, key, rate)) };
    let mut torques = curves(schema, SubjectKind::Actuator, &motors, &[("", "torque_n_m", None)]);
    torques.extend(curves(schema, SubjectKind::Limit, &limits, &[("", "torque_n_m", None)]));
    let mut panels = vec![
        contact("Normal force", "N", "normal_n", None),
        contact("Friction force", "N", "tangential_n", None),
        contact("Gap", "m", "gap_m", Some("gap_rate_m_s")),
        of("Position", "m", SubjectKind::Body, &bodies, &[("x", "x_m", Some("vx_m_s")), ("y", "y_m", Some("vy_m_s"))]),
        of("Velocity", "m/s", SubjectKind::Body, &bodies, &[("vx", "vx_m_s", None), ("vy", "vy_m_s", None)]),
        of("Angle", "rad", SubjectKind::Body, &bodies, &[("angle", "angle_rad", Some("spin_rad_s"))]),
        of("Spin", "rad/s", SubjectKind::Body, &bodies, &[("spin", "spin_rad_s", None)]),
        of("Joint angle", "rad", SubjectKind::Joint, &joints, &[("", "angle_rad", Some("rate_rad_s"))]),
        of("Joint rate", "rad/s", SubjectKind::Joint, &joints, &[("", "rate_rad_s", None)]),
        of("Slider position", "m", SubjectKind::Slider, &sliders, &[("", "position_m", Some("rate_m_s"))]),
        of("Slider rate", "m/s", SubjectKind::Slider, &sliders, &[("", "rate_m_s", None)]),
        panel("Torque", "N·m", torques),
        of("Force", "N", SubjectKind::LinearActuator, &drives, &[("", "force_n", None)]),
        of("Tendon tension", "N", SubjectKind::Tendon, &tendons, &[("", "tension_n", None)]),
        of("Tension behind", "N", SubjectKind::CableElement, &places, &[("", "tension_n", None)]),
        of("Cable speed", "m/s", SubjectKind::CableElement, &places, &[("", "slip_m_s", None)]),
        of("Tendon length", "m", SubjectKind::Tendon, &tendons, &[("", "length_m", Some("rate_m_s"))]),
        of("Motor torque", "N·m", SubjectKind::Shaft, &named(&schema.shafts), &[("", "motor_torque_n_m", None)]),
        of("Current", "A", SubjectKind::Motor, &named(&schema.motors), &[("", "current_a", None)]),
        of("Voltage", "V", SubjectKind::Motor, &named(&schema.motors), &[("", "voltage_v", None)]),
        of(
            "Distance",
            "m",
            SubjectKind::Distance,
            &named(&schema.distances),
            &[("", "distance_m", Some("distance_rate_m_s"))],
        ),
        energy_panel(schema, !mechanism.joints.is_empty()),
    ];
    if mechanism.contacts.iter().all(|contact| contact.law.friction.is_none()) {
        panels.remove(1);
    }
    panels.retain(|panel| !panel.curves.is_empty());
    panels
}

/// Whether a joint is plotted. Of a hand, whose links are not reported, these are the joints with a coordinate at the start,
/// or on which a spring or a limit acts.
fn is_shown(mechanism: &Mechanism, joint: usize) -> bool {
    let Joint { bodies, start, limit, .. } = &mechanism.joints[joint];
    let is_reported = bodies.iter().flatten().any(|body| mechanism.bodies[*body].is_reported);
    let mut springs = mechanism.springs.iter().filter_map(Spring::on).flat_map(|on| &on.terms);
    is_reported || start.is_some() || limit.is_some() || springs.any(|(other, _)| *other == joint)
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
        ("cable friction", "cable_friction_j", None),
    ];
    let is_shown = |name: &str| match name {
        "spring" => has_joints,
        "cable friction" => !schema.elements.is_empty(),
        _ => true,
    };
    quantities.retain(|(name, ..)| is_shown(name));
    let hand = [("energy".to_string(), String::new())];
    panel("Energy", "J", curves(schema, SubjectKind::Energy, &hand, &quantities))
}
