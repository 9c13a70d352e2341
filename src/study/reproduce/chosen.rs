//! Design 95 with the printed torques, and its CAD model (thesis §4.3, §4.4).

use super::ReproduceError;
use crate::criteria::{Criteria, Tracker, static_grasp};
use crate::gripper::total_mass;
use crate::scene;
use crate::statics::palm_force;
use crate::trace::{self, Event, FingerContact, FingerState, Outcome, Sample, Sink, SinkError};

const AS_PRINTED: &str = include_str!("../../../scenes/experiment-95.toml");
const CAD: &str = include_str!("../../../scenes/experiment-95-cad.toml");

/// A closing motion of the finger, with the data for a plot and a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Closing {
    pub name: &'static str,
    pub mass_kg: f64,
    pub criteria: Criteria,
    pub outcome: Outcome,
    /// PFP from the final forces.
    pub pfp_n: f64,
    pub points: Vec<ClosingPoint>,
}

/// One sample of a closing motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosingPoint {
    pub time_s: f64,
    pub q11_rad: f64,
    pub q21_rad: f64,
    pub q22_rad: f64,
}

/// Simulates design 95 with the printed torques.
pub fn chosen() -> Result<Closing, ReproduceError> {
    closing("design 95", AS_PRINTED, "experiment-95.toml")
}

/// Simulates design 95 with the masses of the CAD model.
pub fn cad() -> Result<Closing, ReproduceError> {
    closing("CAD model", CAD, "experiment-95-cad.toml")
}

fn closing(name: &'static str, text: &str, file: &str) -> Result<Closing, ReproduceError> {
    let error = ReproduceError::in_step(name);
    let scene = scene::parse(text, file).map_err(|reason| error(&reason))?;
    let object = scene.object().ok_or_else(|| error(&"there is no object"))?;
    let rest = static_grasp(&scene, object).map_err(|reason| error(&reason))?;
    let mut recorder = ClosingRecorder { tracker: Tracker::new(rest.final_angles()), points: Vec::new() };
    let outcome = trace::run_analytic(&scene, &mut recorder).map_err(|reason| error(&reason))?;
    let forces =
        [outcome.last.contact(FingerContact::Proximal).normal_n, outcome.last.contact(FingerContact::Distal).normal_n];
    Ok(Closing {
        name,
        mass_kg: total_mass(&scene.finger().linkage.bodies),
        criteria: recorder.tracker.criteria(rest.static_forces_n()).ok_or_else(|| error(&"the run has no duration"))?,
        pfp_n: palm_force(&rest.end, forces[0], forces[1], rest.mu_static[0]),
        outcome,
        points: recorder.points,
    })
}

/// Records the angles in addition to the criteria.
struct ClosingRecorder {
    tracker: Tracker,
    points: Vec<ClosingPoint>,
}

impl Sink for ClosingRecorder {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let FingerState { q11_rad, q21_rad, q22_rad, .. } = *sample.finger();
        self.points.push(ClosingPoint { time_s: sample.time_s, q11_rad, q21_rad, q22_rad });
        self.tracker.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.tracker.event(event)
    }
}
