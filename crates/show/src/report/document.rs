//! The JSON document of a run: its figures in order.
//!
//! Keys contain their SI unit; a missing value is null. Keys may be added, but are never renamed.

use serde::{Serialize, Serializer};

use super::check::RunCheckReport;
use super::contacts::Contacts;
use super::grasp::GraspReport;
use super::states::States;
use crate::criteria::{Criteria, GraspCriteria, Rebound, scene_static_grasp};
use crate::scene::keywords::SceneKind;
use crate::scene::schema::{SettingsSection, columns};
use crate::scene::{Engine, Integrator, Keyword, Scene};
use crate::trace::{Energy, Model, Outcome, Schema, Work};

/// One run. All results are null if the simulation failed without a partial outcome. Keys that do not apply to the kind
/// of scene are omitted.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunReport {
    /// Name of the scene.
    pub scene: String,
    /// `finger`, `bodies` or `gripper`.
    pub kind: &'static str,
    /// `analytic` or `engine`.
    pub model: &'static str,
    /// Requested duration; `end_s` is the time reached.
    pub duration_s: f64,
    /// Accepted steps.
    pub steps: Option<u64>,
    /// Wall time of the simulation, the only figure that differs between two runs of the same scene.
    pub wall_s: f64,
    /// Final states of fingers and bodies.
    #[serde(flatten)]
    pub states: States,
    pub contacts: Option<Contacts>,
    /// Criteria of a finger; null without an object, if the finger cannot grasp it, or if the run was not completed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub criteria: Option<Option<Criteria>>,
    /// Reason why a finger with an object has no criteria; null if it has criteria.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_criteria: Option<Option<String>>,
    /// Fate of a gripper's object; null if the run was not completed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grasp: Option<Option<GraspReport>>,
    pub completed: bool,
    /// Time reached.
    pub end_s: Option<f64>,
    /// Largest acceleration of the centre of a gripper's palm over `duration_s`; null if the palm does not move.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub palm_peak_acceleration_m_s2: Option<Option<f64>>,
    /// Reason and time of the failure; null if the run was completed.
    pub error: Option<Failure>,
    pub energy: Option<Energy>,
    /// Reasons to doubt the results; empty for a valid run.
    pub warnings: Vec<String>,
    pub work: Option<Work>,
    /// Settings of the analytic model; null for a run of the engine.
    pub integrator: Option<EffectiveSettings<Integrator>>,
    /// Settings of the engine model; null for a run of the analytic one.
    pub engine: Option<EffectiveSettings<Engine>>,
    /// Largest gap of a joint of the engine, with fingers only; null for the analytic model, whose loop is closed by
    /// construction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loop_gap_m: Option<Option<f64>>,
    /// Path of the log as given; null if none was requested.
    pub log: Option<String>,
    /// Path of the page; null if none was requested.
    pub page: Option<String>,
    /// Path of the table of samples as given; null if none was requested.
    pub csv: Option<String>,
    /// Accuracy check; null if the run was not checked.
    pub check: Option<RunCheckReport>,
}

/// Time and reason of the early end of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failure {
    pub time_s: f64,
    pub reason: String,
}

/// The settings of one model as used in the run, by name. Settings that do not apply because of others are null.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectiveSettings<T>(pub T);

impl<T: SettingsSection> Serialize for EffectiveSettings<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(columns(&self.0))
    }
}

/// The available results of a run.
#[derive(Clone, Copy, Debug)]
pub struct RunData<'a> {
    pub wall_s: f64,
    pub outcome: Option<&'a Outcome>,
    /// Criteria of a finger, if its run was completed.
    pub criteria: Option<Criteria>,
    /// Criteria of a gripper.
    pub grasp: Option<&'a GraspCriteria>,
    /// Rebounds of pairs of discs.
    pub rebounds: &'a [Rebound],
    /// Reasons to doubt the results.
    pub warnings: &'a [String],
}

/// Returns the reason why the run of a finger has no criteria; `None` if it has criteria or there is no object.
fn no_criteria(scene: &Scene, completed: bool) -> Option<String> {
    scene.object()?;
    match scene_static_grasp(scene) {
        _ if !completed => Some("the run was not completed".to_string()),
        Err(reason) => Some(format!("the finger cannot grasp this object: {reason}")),
        Ok(_) => None,
    }
}

impl RunReport {
    /// Builds the report of a completed run, or of a run up to its failure `error`.
    pub fn new(scene: &Scene, model: Model, data: &RunData<'_>, error: Option<Failure>) -> Self {
        let (engine, outcome) = (model == Model::Engine, data.outcome);
        let (kind, layout) = (scene.kind(), Schema::from_system(&scene.system));
        let (finger, gripper) = (kind == SceneKind::Finger, kind == SceneKind::Gripper);
        let palm_peak = || {
            scene.system.palm_motion.as_ref().map(|motion| motion.peak_acceleration_m_s2([0.0; 2], scene.duration_s))
        };
        let criteria = data.criteria.filter(|_| error.is_none());
        RunReport {
            scene: scene.name.clone(),
            kind: kind.keyword(),
            model: model.name(),
            duration_s: scene.duration_s,
            steps: outcome.map(|outcome| outcome.work.steps),
            wall_s: data.wall_s,
            states: States::new(&layout, outcome, Some(scene)),
            contacts: outcome.map(|outcome| Contacts::new(&layout, outcome, data.rebounds)),
            criteria: finger.then_some(criteria),
            no_criteria: finger.then(|| no_criteria(scene, error.is_none()).filter(|_| criteria.is_none())),
            grasp: gripper.then(|| {
                data.grasp.zip(outcome).map(|(found, outcome)| GraspReport::new(found, Some(scene), &outcome.last))
            }),
            completed: error.is_none(),
            end_s: outcome.map(|outcome| outcome.last.time_s),
            palm_peak_acceleration_m_s2: gripper.then(palm_peak),
            error,
            energy: outcome.map(|outcome| outcome.last.energy()),
            warnings: data.warnings.to_vec(),
            work: outcome.map(|outcome| outcome.work),
            integrator: (!engine).then_some(EffectiveSettings(scene.integrator)),
            engine: engine.then_some(EffectiveSettings(scene.engine)),
            loop_gap_m: (finger || gripper).then(|| outcome.filter(|_| engine).map(|outcome| outcome.loop_gap_m)),
            log: None,
            page: None,
            csv: None,
            check: None,
        }
    }

    /// Whether the scene has fingers.
    pub fn has_joints(&self) -> bool {
        self.kind != SceneKind::Bodies.keyword()
    }
}
