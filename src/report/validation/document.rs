//! The JSON document of a validation.
//!
//! Keys end in their SI unit; those without a unit are ratios, counts or words. A value is null where there is nothing
//! to measure, and where only one of the models has the quantity (`passed` is then false).

use serde::Serialize;

use super::super::contacts::Contacts;
use super::super::states::States;
use super::differences::DifferencesReport;
use super::errors::Errors;
use super::invariants::FindingReport;
use super::statistics::StatisticsReport;
use crate::invariants::Finding;
use crate::scene::keywords::SceneKind;
use crate::scene::{Keyword, Scene};
use crate::trace::{Energy, Layout, Model};
use crate::validate::{
    Check, Criterion, Evaluation, IMPACT_S, LadderOptions, LadderRow, MEMBER_PERTURBATION, Recording,
    SolverConfiguration, Validation, Value, configuration_name, engine_keys, ensemble_size, reference_configuration,
    scene_configuration,
};

/// Report of a validation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ValidationReport {
    /// Name of the scene.
    pub scene: String,
    /// `finger`, `bodies` or `gripper`. Keys that do not apply to a kind of scene are absent.
    pub kind: &'static str,
    /// Whether every bound holds.
    pub passed: bool,
    pub duration_s: f64,
    /// Trajectories are compared up to this time.
    pub until_s: f64,
    /// Number of runs; the worst counts.
    pub ensemble_runs: usize,
    /// Relative difference of the motor torque between consecutive runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ensemble_torque_step: Option<f64>,
    /// Relative difference of gravity and the speeds of all discs between consecutive runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ensemble_speed_step: Option<f64>,
    pub verdict: Vec<CheckReport>,
    /// Estimated error of the reference trajectory, from two integration methods of the analytic model; in m for scenes
    /// of discs, otherwise in rad. Null where it is unknown.
    pub reference_error: Option<f64>,
    /// The model to trust if a bound fails; null if none fails, or if neither model can be trusted.
    #[serde(rename = "trusted")]
    pub trusted_model: Option<&'static str>,
    /// Finer settings of the engine that were run because a bound failed.
    #[serde(rename = "finer")]
    pub finer_settings: Vec<FinerReport>,
    /// Criteria of both models.
    pub criteria: Vec<CriterionReport>,
    /// Reason why the criteria are not judged; null if they are.
    #[serde(rename = "criteria_unjudged")]
    pub reason_not_judged: Option<&'static str>,
    pub analytic: ModelReport,
    pub engine: ModelReport,
    /// Means over many runs beyond `until_s`, where trajectories are not compared; null if they are compared to the
    /// end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub statistics: Option<Option<StatisticsReport>>,
    /// Impacts of both models at the scene's own torque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impacts: Option<Vec<ImpactReport>>,
    /// Differences of the engine at the scene's settings: the worst of the ensemble.
    pub differences: DifferencesReport,
    /// Whether the ladder omits settings that take long.
    pub quick: bool,
    /// Time limit of the ladder; null without a ladder.
    pub ladder_time_s: Option<f64>,
    /// Speed and error of all settings of the ladder; empty without a ladder.
    pub settings: Vec<SettingReport>,
    /// Directory of the results, as given by the user; null if none was requested.
    pub directory: Option<String>,
    /// Files in `directory`; null if none were requested.
    pub files: Option<Vec<String>>,
}

/// A bound, and the measured value that it limits.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CheckReport {
    /// Key of the bound, with its unit.
    pub bound: &'static str,
    pub meaning: &'static str,
    pub measured: Option<f64>,
    pub limit: f64,
    pub passed: bool,
}

/// A finer setting of the engine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FinerReport {
    /// The setting as keys of `[engine]`.
    pub setting: String,
    pub passed: bool,
}

/// One criterion in both models.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CriterionReport {
    /// Key of its bound, with its unit.
    pub criterion: &'static str,
    /// Name of the pair or contact; null for criteria of the whole scene.
    #[serde(rename = "of")]
    pub subject: Option<String>,
    pub analytic: ValueReport,
    pub engine: ValueReport,
    /// The difference that is compared with the limit; null if only one model has a value.
    pub difference: f64,
    pub limit: f64,
}

/// A label, a number in SI units, or null.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ValueReport {
    Label(&'static str),
    Number(Option<f64>),
}

impl From<&Criterion> for CriterionReport {
    fn from(criterion: &Criterion) -> Self {
        let value = |value: &Value| match value {
            Value::Label(label) => ValueReport::Label(label),
            Value::Number(number) => ValueReport::Number(*number),
        };
        CriterionReport {
            criterion: criterion.bound,
            subject: Some(criterion.subject.clone()).filter(|subject| !subject.is_empty()),
            analytic: value(&criterion.analytic),
            engine: value(&criterion.engine),
            difference: criterion.difference,
            limit: criterion.limit,
        }
    }
}

/// Run of one of the models for the scene itself: the analytic model at its reference preset, or the engine at the
/// scene's settings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModelReport {
    pub setting: String,
    pub steps: u64,
    /// Median wall time without output; null without a ladder, which measures it.
    pub wall_s: Option<f64>,
    /// States of fingers and bodies at the end of the compared time.
    #[serde(flatten)]
    pub states: States,
    /// Contacts without restitution, which `phalanx run` measures.
    pub contacts: Contacts,
    pub energy: Energy,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loop_gap_m: Option<f64>,
    /// Margin of each invariant in this run.
    pub invariants: Vec<FindingReport>,
}

/// One touch-down in both models.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImpactReport {
    #[serde(rename = "site")]
    pub contact: String,
    pub analytic_s: Option<f64>,
    pub engine_s: Option<f64>,
    /// Time after the touch-down over which the impulse is measured: up to the lift-off of the analytic model, or 20
    /// µs.
    pub window_s: f64,
    pub analytic_n_s: Option<f64>,
    pub engine_n_s: Option<f64>,
}

/// Whether a setting was evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    Done,
    Failed,
    TooLong,
    NoTime,
}

/// One setting: its cost and its differences from the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SettingReport {
    pub family: &'static str,
    pub setting: String,
    pub model: &'static str,
    /// Whether the scene requests this setting.
    #[serde(rename = "own")]
    pub is_from_scene: bool,
    /// Whether this setting is the reference itself.
    #[serde(rename = "reference")]
    pub is_reference: bool,
    pub status: Status,
    /// Reason why the setting has no results.
    pub reason: Option<String>,
    /// Number of runs; the worst counts.
    pub ensemble_runs: usize,
    pub steps: Option<u64>,
    /// Median wall time of the timed runs.
    pub wall_s: Option<f64>,
    /// Number of timed runs.
    pub timed_runs: Option<usize>,
    /// Ratio of simulated time to wall time.
    pub real_time_factor: Option<f64>,
    /// Ratio of the wall time to that of the analytic model at its engineering preset.
    pub analytic_factor: Option<f64>,
    #[serde(flatten)]
    pub errors: Errors,
}

impl From<&Check> for CheckReport {
    fn from(check: &Check) -> Self {
        CheckReport {
            bound: check.bound,
            meaning: check.meaning,
            measured: check.measured,
            limit: check.limit,
            passed: check.passed(),
        }
    }
}

impl ValidationReport {
    /// Creates the report. `ladder` are the options of the ladder of `validation`, if it was run.
    pub fn new(scene: &Scene, validation: &Validation, ladder: Option<LadderOptions>) -> Self {
        let layout = Layout::from_system(&scene.system);
        let is_single_finger = scene.kind() == SceneKind::Finger;
        let has_fingers = is_single_finger || scene.kind() == SceneKind::Gripper;
        let find_row = |predicate: fn(&LadderRow) -> bool| validation.ladder.iter().find(|row| predicate(row));
        let analytic = (reference_configuration(scene), find_row(|row| row.configuration.is_reference()));
        let engine = (scene_configuration(scene), find_row(|row| row.configuration.is_from_scene));
        ValidationReport {
            scene: scene.name.clone(),
            kind: scene.kind().keyword(),
            passed: validation.verdict.passed(),
            duration_s: scene.duration_s,
            until_s: validation.until_s,
            ensemble_runs: ensemble_size(scene),
            ensemble_torque_step: has_fingers.then_some(MEMBER_PERTURBATION),
            ensemble_speed_step: (!has_fingers).then_some(MEMBER_PERTURBATION),
            verdict: validation.verdict.checks.iter().map(CheckReport::from).collect(),
            reference_error: validation.reference_error(),
            trusted_model: validation.trusted_model().map(Model::name),
            finer_settings: validation
                .finer_configurations
                .iter()
                .map(|(configuration, passed)| FinerReport { setting: engine_keys(configuration), passed: *passed })
                .collect(),
            criteria: validation.criteria.iter().map(CriterionReport::from).collect(),
            reason_not_judged: validation.reason_not_judged.filter(|_| !validation.criteria.is_empty()),
            analytic: ModelReport::new(scene, analytic, &validation.reference, &validation.reference_invariants),
            engine: ModelReport::new(scene, engine, &validation.engine, &validation.engine_invariants),
            statistics: is_single_finger.then(|| validation.statistics.as_ref().map(StatisticsReport::from)),
            impacts: has_fingers.then(|| impacts(&layout, &validation.reference, &validation.engine)),
            differences: DifferencesReport::new(&layout, &validation.differences),
            quick: ladder.is_some_and(|ladder| ladder.quick),
            ladder_time_s: ladder.map(|ladder| ladder.time_s),
            settings: validation.ladder.iter().map(|row| SettingReport::new(&layout, row)).collect(),
            directory: None,
            files: None,
        }
    }

    /// Whether the scene is a single finger, which the engine can build in reduced coordinates.
    pub(super) fn is_single_finger(&self) -> bool {
        self.kind == SceneKind::Finger.keyword()
    }

    pub(super) fn has_discs_only(&self) -> bool {
        self.kind == SceneKind::Bodies.keyword()
    }
}

impl ModelReport {
    fn new(
        scene: &Scene,
        (configuration, row): (SolverConfiguration, Option<&LadderRow>),
        recording: &Recording,
        invariants: &[Finding],
    ) -> Self {
        let (layout, outcome) = (Layout::from_system(&scene.system), &recording.outcome);
        let wall_s = row.and_then(|row| match row.evaluation {
            Evaluation::Done { cost, .. } => Some(cost.wall_s),
            _ => None,
        });
        ModelReport {
            setting: configuration_name(&configuration),
            steps: outcome.work.steps,
            wall_s,
            states: States::new(&layout, Some(outcome), Some(scene)),
            contacts: Contacts::new(&layout, outcome, &[]),
            energy: outcome.last.energy,
            loop_gap_m: (scene.kind() != SceneKind::Bodies).then_some(outcome.loop_gap_m),
            invariants: invariants.iter().map(FindingReport::from).collect(),
        }
    }
}

/// Pairs the touch-downs of both models by their order at each contact.
fn impacts(layout: &Layout, analytic: &Recording, engine: &Recording) -> Vec<ImpactReport> {
    let mut rows = Vec::new();
    for contact in layout.surfaces() {
        let (mut analytic_impacts, mut engine_impacts) =
            (analytic.impacts.of_contact(contact), engine.impacts.of_contact(contact));
        loop {
            let pair = (analytic_impacts.next(), engine_impacts.next());
            if let (None, None) = pair {
                break;
            }
            rows.push(ImpactReport {
                contact: layout.contacts[contact].name.clone(),
                analytic_s: pair.0.map(|impact| impact.time_s),
                engine_s: pair.1.map(|impact| impact.time_s),
                window_s: pair.0.or(pair.1).map_or(IMPACT_S, |impact| impact.end_s() - impact.time_s),
                analytic_n_s: pair.0.map(|impact| impact.impulse_n_s()),
                engine_n_s: pair.1.map(|impact| impact.impulse_n_s()),
            });
        }
    }
    rows
}

impl SettingReport {
    fn new(layout: &Layout, row: &LadderRow) -> Self {
        let configuration = &row.configuration;
        let (status, reason) = match &row.evaluation {
            Evaluation::Done { .. } => (Status::Done, None),
            Evaluation::Failed { reason } => (Status::Failed, Some(reason.clone())),
            Evaluation::TooLong { steps } => (Status::TooLong, Some(format!("would take {steps:.1e} steps"))),
            Evaluation::NoTime => (Status::NoTime, Some("beyond the time limit of the ladder".to_string())),
        };
        let (differences, cost) = match &row.evaluation {
            Evaluation::Done { differences, cost } => (differences.as_deref(), Some(cost)),
            _ => (None, None),
        };
        SettingReport {
            family: configuration.family.name(),
            setting: configuration_name(configuration),
            model: configuration.model().name(),
            is_from_scene: configuration.is_from_scene,
            is_reference: configuration.is_reference(),
            status,
            reason,
            ensemble_runs: configuration.members,
            steps: cost.map(|cost| cost.steps),
            wall_s: cost.map(|cost| cost.wall_s),
            timed_runs: cost.map(|cost| cost.runs),
            real_time_factor: cost.map(|cost| cost.real_time_factor()),
            analytic_factor: cost.map(|cost| cost.analytic_factor()),
            errors: Errors::new(layout, differences),
        }
    }
}
