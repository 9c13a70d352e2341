//! Parameters of a scene, and derivatives by them.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::scene::Scene;

/// Largest relative change of a parameter in difference quotients.
const MAX_CHANGE: f64 = 1e-4;

/// A numeric parameter of a scene.
pub struct Parameter<'a> {
    pub name: String,
    /// SI unit; empty for a plain number.
    pub unit: &'static str,
    pub value: f64,
    /// Returns the scene for a value of the parameter.
    pub scene_at: Box<dyn Fn(f64) -> Result<Scene, String> + 'a>,
}

/// Derivatives of a run with respect to one parameter, for the columns of a recording, in SI units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gradient {
    pub unit: &'static str,
    pub value: f64,
    /// Derivatives of the last sample.
    pub end: Derivatives,
    /// Derivatives of contact events, in the order of the run.
    pub events: Vec<EventGradient>,
    /// Derivative of the time to stability; `None` if the run has no such time.
    pub tts_s: Option<Derivative>,
}

/// Derivatives of quantities, by name.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Derivatives {
    pub values: BTreeMap<String, f64>,
    /// Estimated errors: the change of each derivative if the tolerance is ten times larger.
    pub errors: BTreeMap<String, f64>,
    /// Reason why there are no derivatives; `None` if there are.
    pub reason: Option<String>,
}

/// A derivative with its estimated error, or the reason why there is none.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Derivative {
    pub value: Option<f64>,
    pub error: Option<f64>,
    pub reason: Option<String>,
}

/// Derivatives of an event.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EventGradient {
    pub time_s: f64,
    pub contact: String,
    pub kind: &'static str,
    /// Derivative of the time of the event.
    pub time: Derivative,
    /// Derivatives of the sample at the event; the time of the sample moves with the event.
    pub state: Derivatives,
}

impl Parameter<'_> {
    /// Size against which changes of the parameter are measured.
    pub(super) fn scale(&self) -> f64 {
        if self.value == 0.0 { 1.0 } else { self.value.abs() }
    }

    /// Largest change of the value in difference quotients.
    pub(super) fn largest_change(&self) -> f64 {
        MAX_CHANGE * self.scale()
    }
}
