//! The figures of a run, in the order and under the keys of the JSON document.
//!
//! Keys carry their SI unit; where there is no value the key is there and null. Keys are added over time, never renamed.

use serde::{Serialize, Serializer};

use super::check::RunCheckReport;
use super::contacts::Contacts;
use super::grasp::GraspReport;
use super::states::States;
use crate::criteria::{Criteria, GraspCriteria, Rebound, grasp_at_rest};
use crate::scene::table::held::Written;
use crate::scene::table::{Table, columns};
use crate::scene::words::SceneKind;
use crate::scene::{Engine, Integrator, Scene, Words};
use crate::trace::{Energy, Layout, Model, Outcome, Work};

/// One run. All that is known only from the simulation is null if that could not even report how far it came; what a kind of
/// scene does not have is no key at all.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunReport {
    /// Name of the scene.
    pub scene: String,
    /// `finger`, `bodies` or `gripper`.
    pub kind: &'static str,
    /// `analytic` or `engine`.
    pub model: &'static str,
    /// Length asked for; `end_s` says how far the run came.
    pub duration_s: f64,
    /// Accepted steps.
    pub steps: Option<u64>,
    /// Wall time of the simulation: the one figure that differs between two runs of the same scene.
    pub wall_s: f64,
    /// What moves, as it is at the end.
    #[serde(flatten)]
    pub states: States,
    pub contacts: Option<Contacts>,
    /// Of a finger; null without an object, without a grasp of it, or if the run was not completed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub criteria: Option<Option<Criteria>>,
    /// Of a finger with an object: why there are no criteria; null where there are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_criteria: Option<Option<String>>,
    /// Of a gripper: what became of the object; null if the run was not completed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grasp: Option<Option<GraspReport>>,
    pub completed: bool,
    /// Time reached.
    pub end_s: Option<f64>,
    /// Of a gripper: largest acceleration of its palm's middle over `duration_s`; null if the palm stays where it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub palm_peak_acceleration_m_s2: Option<Option<f64>>,
    /// Null if the run was completed.
    pub error: Option<Failure>,
    pub energy: Option<Energy>,
    /// Sentences on what makes the results doubtful; empty for a sound run.
    pub warnings: Vec<String>,
    pub work: Option<Work>,
    /// Settings of the analytic model; null for a run of the engine.
    pub integrator: Option<Used<Integrator>>,
    /// Settings of the engine model; null for a run of the analytic one.
    pub engine: Option<Used<Engine>>,
    /// Of a finger or a gripper: largest opening of a joint of the engine; null for the analytic model, whose loop is closed by construction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loop_gap_m: Option<Option<f64>>,
    /// Path of the log as given; null if none was asked for.
    pub log: Option<String>,
    /// Path of the page; null if none was asked for.
    pub page: Option<String>,
    /// Path of the table of samples as given; null if none was asked for.
    pub csv: Option<String>,
    /// Null if the run was not checked.
    pub check: Option<RunCheckReport>,
}

/// Why a run ended early.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Failure {
    pub time_s: f64,
    pub reason: String,
}

/// The settings in force of one model, under the names of the table of settings; null is what a choice among them leaves out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Used<T>(pub T);

impl<T: Table> Serialize for Used<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(columns(&self.0).into_iter().map(|(name, value)| (name, value.map(Written::si))))
    }
}

/// What a run came to, as far as it did.
#[derive(Clone, Copy, Debug)]
pub struct Came<'a> {
    pub wall_s: f64,
    pub outcome: Option<&'a Outcome>,
    /// Of a finger, if its run was completed.
    pub criteria: Option<Criteria>,
    /// Of a gripper.
    pub grasp: Option<&'a GraspCriteria>,
    /// Of pairs of discs.
    pub rebounds: &'a [Rebound],
    /// Sentences on what makes the results doubtful.
    pub warnings: &'a [String],
}

/// Why a run of a finger has no criteria, if it cannot have any.
fn no_criteria(scene: &Scene, completed: bool) -> Option<String> {
    scene.object()?;
    match grasp_at_rest(scene) {
        _ if !completed => Some("the run was not completed".to_string()),
        Err(reason) => Some(format!("the finger cannot grasp this object: {reason}")),
        Ok(_) => None,
    }
}

impl RunReport {
    /// A run with what is known of it: all of it, or up to where it broke off, and why.
    pub fn new(scene: &Scene, model: Model, came: &Came<'_>, error: Option<Failure>) -> Self {
        let (engine, outcome) = (model == Model::Engine, came.outcome);
        let (kind, layout) = (scene.kind(), Layout::of(&scene.system));
        let (finger, gripper) = (kind == SceneKind::Finger, kind == SceneKind::Gripper);
        let palm_peak = || scene.system.palm_motion.as_ref().map(|motion| motion.peak_m_s2([0.0; 2], scene.duration_s));
        let criteria = came.criteria.filter(|_| error.is_none());
        RunReport {
            scene: scene.name.clone(),
            kind: kind.word(),
            model: model.name(),
            duration_s: scene.duration_s,
            steps: outcome.map(|outcome| outcome.work.steps),
            wall_s: came.wall_s,
            states: States::new(&layout, outcome, Some(scene)),
            contacts: outcome.map(|outcome| Contacts::new(&layout, outcome, came.rebounds)),
            criteria: finger.then_some(criteria),
            no_criteria: finger.then(|| no_criteria(scene, error.is_none()).filter(|_| criteria.is_none())),
            grasp: gripper
                .then(|| came.grasp.zip(outcome).map(|(found, of)| GraspReport::new(found, Some(scene), &of.last))),
            completed: error.is_none(),
            end_s: outcome.map(|outcome| outcome.last.time_s),
            palm_peak_acceleration_m_s2: gripper.then(palm_peak),
            error,
            energy: outcome.map(|outcome| outcome.last.energy),
            warnings: came.warnings.to_vec(),
            work: outcome.map(|outcome| outcome.work),
            integrator: (!engine).then_some(Used(scene.integrator)),
            engine: engine.then_some(Used(scene.engine)),
            loop_gap_m: (finger || gripper).then(|| outcome.filter(|_| engine).map(|outcome| outcome.loop_gap_m)),
            log: None,
            page: None,
            csv: None,
            check: None,
        }
    }

    /// Whether the scene has joints to speak of.
    pub fn has_joints(&self) -> bool {
        self.kind != SceneKind::Bodies.word()
    }
}
