//! Final states of fingers and bodies in the JSON document. A single finger has the key `final`; two fingers have the
//! key `fingers`, and their object the key `object`; without fingers, bodies have the key `discs`.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::named::Named;
use crate::scene::{DiscMotion, Scene};
use crate::trace::schema::State as _;
use crate::trace::{BodyState, FingerState, Outcome, Schema};

/// A body at the end of the run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyReport {
    /// `free`, `driven` or `fixed`; `unknown` without a scene that has it.
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

/// Fingers and bodies by their names.
#[derive(Clone, Debug, PartialEq)]
pub struct States {
    /// A single finger has an empty name.
    pub fingers: Named<FingerState>,
    /// Sorted by name if there are no fingers.
    pub bodies: Named<BodyReport>,
    finger_count: usize,
    has_outcome: bool,
}

/// Value of one key of [`States`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum State<'a> {
    Finger(&'a FingerState),
    Fingers(&'a Named<FingerState>),
    Body(&'a BodyReport),
    Bodies(&'a Named<BodyReport>),
}

impl States {
    /// Builds the report of the final states; all are null without an outcome.
    pub fn new(schema: &Schema, outcome: Option<&Outcome>, scene: Option<&Scene>) -> Self {
        let fingers = outcome.into_iter().flat_map(|outcome| schema.fingers.iter().zip(outcome.last.fingers()));
        let bodies = outcome.into_iter().flat_map(|outcome| schema.bodies.iter().zip(outcome.last.bodies()));
        let discs = scene.map_or(&[][..], |scene| &scene.system.discs);
        let motion = |name: &str| match discs.iter().find(|disc| disc.name == name).map(|disc| &disc.motion) {
            Some(DiscMotion::Fixed) => "fixed",
            Some(DiscMotion::Driven { .. }) => "driven",
            Some(DiscMotion::Free { .. }) => "free",
            None => "unknown",
        };
        let body = |(name, state): (&String, BodyState)| (name.clone(), BodyReport { motion: motion(name), state });
        let mut bodies: Named<_> = bodies.map(body).collect();
        if schema.fingers.is_empty() {
            bodies.0.sort_by(|a, b| a.0.cmp(&b.0));
        }
        States {
            fingers: fingers.map(|(name, state)| (name.clone(), state)).collect(),
            bodies,
            finger_count: schema.fingers.len(),
            has_outcome: outcome.is_some(),
        }
    }

    /// Returns the keys of the document and their values.
    pub fn entries(&self) -> Vec<(&'static str, Option<State<'_>>)> {
        let present = |state| self.has_outcome.then_some(state);
        match self.finger_count {
            0 => vec![("discs", present(State::Bodies(&self.bodies)))],
            1 => vec![("final", self.fingers.first().map(State::Finger))],
            _ => {
                vec![
                    ("fingers", present(State::Fingers(&self.fingers))),
                    ("object", self.bodies.first().map(State::Body)),
                ]
            }
        }
    }
}

impl Serialize for States {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.entries())
    }
}
