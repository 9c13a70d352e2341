//! Final states of fingers and bodies in the JSON document. A single finger has the key `final`; two fingers have the
//! key `fingers`, and their object the key `object`. A mechanism has `joints`, `actuators`, `tendons` and `bodies`, and
//! `drives` if an actuator has a gear, a motor or feedback.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::named::Named;
use crate::mechanism::Mechanism;
use crate::scene::{Object, Scene};
use crate::trace::schema::{Quantity, State as _, SubjectKind};
use crate::trace::{BodyState, FingerState, Outcome, Schema};

/// A body at the end of the run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyReport {
    /// `free`, `driven`, `fixed`, or `jointed` for a body with joints; `unknown` without a scene that contains the
    /// body.
    pub motion: &'static str,
    pub state: BodyState,
}

/// Serialised as the motion and the quantities of a body.
impl Serialize for BodyReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("motion", self.motion)?;
        for (quantity, value) in BodyState::QUANTITIES.iter().zip(self.state.values()) {
            map.serialize_entry(quantity.key, &value)?;
        }
        map.end()
    }
}

/// A joint, an actuator or a tendon at the end of the run. It is serialised as its quantities.
#[derive(Clone, Debug, PartialEq)]
pub struct JointReport(pub Vec<(&'static Quantity, f64)>);

impl Serialize for JointReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(quantity, value)| (quantity.key, value)))
    }
}

/// Final states of fingers, bodies and other parts, by their names.
#[derive(Clone, Debug, PartialEq)]
pub struct States {
    /// Joints of a mechanism.
    pub joints: Named<JointReport>,
    /// Actuators of a mechanism.
    pub actuators: Named<JointReport>,
    /// Tendons of a mechanism.
    pub tendons: Named<JointReport>,
    /// Shafts, motors and distances of actuators, together by the name of the actuator.
    pub drives: Named<JointReport>,
    /// Places of the cables of a mechanism with friction, and pulleys from which the cable has lifted off.
    pub elements: Named<JointReport>,
    /// States of the fingers. The name of a single finger is empty.
    pub fingers: Named<FingerState>,
    pub bodies: Named<BodyReport>,
    finger_count: usize,
    has_outcome: bool,
}

/// Value for one key of [`States`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum State<'a> {
    Finger(&'a FingerState),
    Fingers(&'a Named<FingerState>),
    Body(&'a BodyReport),
    Bodies(&'a Named<BodyReport>),
    Joints(&'a Named<JointReport>),
}

impl States {
    /// Builds the report of the final states. Without an outcome, all of them are null.
    pub fn new(schema: &Schema, outcome: Option<&Outcome>, scene: Option<&Scene>) -> Self {
        let fingers = outcome.into_iter().flat_map(|outcome| schema.fingers.iter().zip(outcome.last.fingers()));
        let bodies = outcome.into_iter().flat_map(|outcome| schema.bodies.iter().zip(outcome.last.bodies()));
        let object = scene.and_then(Scene::object);
        let mechanism = scene.and_then(|scene| scene.mechanism.as_ref());
        let motion_in = |mechanism: &Mechanism, name: &str| {
            let body = mechanism.bodies.iter().position(|body| body.name == name)?;
            Some(match &mechanism.bodies[body].motion {
                Some(_) => "driven",
                None if mechanism.has_joint(Some(body)) => "jointed",
                None => "free",
            })
        };
        let motion = |name: &str| match object {
            Some(_) => "free",
            None => mechanism.and_then(|mechanism| motion_in(mechanism, name)).unwrap_or("unknown"),
        };
        let body = |(name, state): (&String, BodyState)| (name.clone(), BodyReport { motion: motion(name), state });
        // Samples do not report a fixed object.
        let fixed = scene.filter(|scene| scene.finger_count() == 2 && scene.hand.moving_object().is_none());
        let fixed = fixed.zip(outcome).map(|(scene, outcome)| {
            let state = outcome.last.object(&scene.hand);
            (Object::NAME.to_string(), BodyReport { motion: "fixed", state })
        });
        let subjects = if schema.is_mechanism() { schema.subjects() } else { Vec::new() };
        let quantities_of = |kinds: [SubjectKind; 2]| -> Named<JointReport> {
            let chosen = subjects.iter().filter(|subject| kinds.contains(&subject.kind));
            let values = chosen.zip(std::iter::repeat(outcome)).filter_map(|(subject, outcome)| {
                // A run that was rejected has no last sample.
                let last = outcome.map(|outcome| &outcome.last).filter(|last| !last.values().is_empty())?;
                let values = subject.channels().map(|(quantity, channel)| (quantity, channel.value(last)));
                Some((subject.name.clone(), JointReport(values.collect())))
            });
            values.collect()
        };
        let mut drives: Named<JointReport> = Named(Vec::new());
        for kind in [SubjectKind::Shaft, SubjectKind::Motor, SubjectKind::Distance] {
            for (name, report) in quantities_of([kind; 2]).iter() {
                match drives.0.iter_mut().find(|(known, _)| known == name) {
                    Some((_, known)) => known.0.extend(report.0.iter().copied()),
                    None => drives.0.push((name.clone(), report.clone())),
                }
            }
        }
        let rubs = |name: &str| {
            let all = mechanism.into_iter().flat_map(|mechanism| &mechanism.tendons);
            all.filter(|tendon| tendon.has_friction()).any(|tendon| name.starts_with(&format!("{}[", tendon.name)))
        };
        let is_special =
            |(name, report): &(String, JointReport)| rubs(name) || report.0.first().is_some_and(|on| on.1 < 0.5);
        States {
            drives,
            joints: quantities_of([SubjectKind::Joint, SubjectKind::Slider]),
            actuators: quantities_of([SubjectKind::Actuator, SubjectKind::LinearActuator]),
            tendons: quantities_of([SubjectKind::Tendon; 2]),
            elements: quantities_of([SubjectKind::CableElement; 2]).0.into_iter().filter(is_special).collect(),
            fingers: fingers.map(|(name, state)| (name.clone(), state)).collect(),
            bodies: bodies.map(body).chain(fixed).collect(),
            finger_count: schema.fingers.len(),
            has_outcome: outcome.is_some(),
        }
    }

    /// Bodies that move without joints, and those of these names.
    pub(super) fn bodies_without_joints(&self, names: [&str; 2]) -> Vec<(&str, &BodyReport)> {
        let is_shown =
            |(name, body): &&(String, BodyReport)| body.motion != "jointed" || names.contains(&name.as_str());
        self.bodies.iter().filter(is_shown).map(|(name, body)| (name.as_str(), body)).collect()
    }

    /// Returns the keys of the document with their values.
    pub fn entries(&self) -> Vec<(&'static str, Option<State<'_>>)> {
        let present = |state| self.has_outcome.then_some(state);
        match self.finger_count {
            0 => {
                let mut entries = vec![
                    ("joints", present(State::Joints(&self.joints))),
                    ("actuators", present(State::Joints(&self.actuators))),
                    ("drives", present(State::Joints(&self.drives))),
                    ("tendons", present(State::Joints(&self.tendons))),
                    ("cables", present(State::Joints(&self.elements))),
                    ("bodies", present(State::Bodies(&self.bodies))),
                ];
                // Most mechanisms have neither.
                entries.retain(|(key, _)| match *key {
                    "drives" => !self.drives.0.is_empty(),
                    "cables" => !self.elements.0.is_empty(),
                    _ => true,
                });
                entries
            }
            1 => vec![("final", self.fingers.first().map(State::Finger))],
            _ => vec![
                ("fingers", present(State::Fingers(&self.fingers))),
                ("object", self.bodies.first().map(State::Body)),
            ],
        }
    }
}

impl Serialize for States {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.entries())
    }
}
