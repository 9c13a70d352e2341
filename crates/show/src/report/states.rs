//! What moves, as it is at the end of a run, under the keys of the JSON document: a finger that is alone is `final`; two of them
//! are `fingers`, and what they grasp is the `object`; where there are none, bodies are `discs`.

use serde::{Serialize, Serializer};

use super::named::Named;
use crate::scene::{DiscMotion, Scene};
use crate::trace::{BodyState, FingerState, Layout, Outcome};

/// A body at the end of the run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BodyReport {
    /// `free`, `driven` or `fixed`; `unknown` without a scene that has it.
    pub motion: &'static str,
    pub x_m: f64,
    pub y_m: f64,
    pub angle_rad: f64,
    pub vx_m_s: f64,
    pub vy_m_s: f64,
    pub spin_rad_s: f64,
}

/// Fingers and bodies by their names.
#[derive(Clone, Debug, PartialEq)]
pub struct States {
    /// A finger that is alone has no name.
    pub fingers: Named<FingerState>,
    /// In the order of their names where there is no finger.
    pub bodies: Named<BodyReport>,
    fingered: usize,
    told: bool,
}

/// What stands under one key.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum State<'a> {
    Finger(&'a FingerState),
    Fingers(&'a Named<FingerState>),
    Body(&'a BodyReport),
    Bodies(&'a Named<BodyReport>),
}

impl States {
    /// Of samples of this layout; all is null where there is no outcome.
    pub fn new(layout: &Layout, outcome: Option<&Outcome>, scene: Option<&Scene>) -> Self {
        let fingers = outcome.into_iter().flat_map(|outcome| layout.fingers.iter().zip(&outcome.last.fingers));
        let bodies = outcome.into_iter().flat_map(|outcome| layout.bodies.iter().zip(&outcome.last.bodies));
        let mut bodies: Named<_> = bodies.map(|(name, state)| (name.clone(), body(name, scene, state))).collect();
        if layout.fingers.is_empty() {
            bodies.0.sort_by(|a, b| a.0.cmp(&b.0));
        }
        States {
            fingers: fingers.map(|(name, state)| (name.clone(), *state)).collect(),
            bodies,
            fingered: layout.fingers.len(),
            told: outcome.is_some(),
        }
    }

    /// The keys of the document, and what stands there.
    pub fn entries(&self) -> Vec<(&'static str, Option<State<'_>>)> {
        let told = |state| self.told.then_some(state);
        match self.fingered {
            0 => vec![("discs", told(State::Bodies(&self.bodies)))],
            1 => vec![("final", self.fingers.first().map(State::Finger))],
            _ => {
                vec![("fingers", told(State::Fingers(&self.fingers))), ("object", self.bodies.first().map(State::Body))]
            }
        }
    }
}

impl Serialize for States {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.entries())
    }
}

fn body(name: &str, scene: Option<&Scene>, state: &BodyState) -> BodyReport {
    let known = scene.and_then(|scene| scene.system.discs.iter().find(|disc| disc.name == name));
    BodyReport {
        motion: match known.map(|disc| &disc.motion) {
            Some(DiscMotion::Fixed) => "fixed",
            Some(DiscMotion::Driven { .. }) => "driven",
            Some(DiscMotion::Free { .. }) => "free",
            None => "unknown",
        },
        x_m: state.centre_m[0],
        y_m: state.centre_m[1],
        angle_rad: state.angle_rad,
        vx_m_s: state.velocity_m_s[0],
        vy_m_s: state.velocity_m_s[1],
        spin_rad_s: state.spin_rad_s,
    }
}
