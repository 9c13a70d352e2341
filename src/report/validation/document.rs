//! The figures of a validation, in the order and under the keys of the JSON document.
//!
//! Keys carry their SI unit; those without one are ratios, counts or words. Where there is nothing to measure, and
//! where one model lacks what the other has (`passed` is then false), the value is null.

use serde::Serialize;

use super::super::contacts::Contacts;
use super::super::states::States;
use super::differences::DifferencesReport;
use super::errors::Errors;
use super::invariants::FindingReport;
use super::statistics::StatisticsReport;
use crate::invariants::Finding;
use crate::scene::words::SceneKind;
use crate::scene::{Scene, Words};
use crate::trace::{Energy, Layout, Model};
use crate::validate::{
    Check, Climb, Criterion, IMPACT_S, Recording, Row, Rung, TORQUE_STEP, Tried, Validation, Value, keys, members,
    name, of_reference, own,
};

/// One validation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ValidationReport {
    /// Name of the scene.
    pub scene: String,
    /// `finger`, `bodies` or `gripper`; what a kind of scene does not have is no key at all.
    pub kind: &'static str,
    /// Whether every bound holds.
    pub passed: bool,
    pub duration_s: f64,
    /// Trajectories are compared up to here.
    pub until_s: f64,
    /// Runs of which the worst counts, and the relative step from one to the next: of the motor torque, or of all speeds of discs
    /// and gravity.
    pub ensemble_runs: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ensemble_torque_step: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ensemble_speed_step: Option<f64>,
    pub verdict: Vec<CheckReport>,
    /// Estimated error of the reference along the path, of the two methods of the analytic model; m where there are discs alone. Null
    /// where it is unknown.
    pub reference_error: Option<f64>,
    /// The model to trust where a bound fails; null where none fails, or neither is to be trusted.
    pub trusted: Option<&'static str>,
    /// Finer settings of the engine that were run because a bound failed.
    pub finer: Vec<FinerReport>,
    /// Criteria of both models, and why they are not judged; null where they are.
    pub criteria: Vec<CriterionReport>,
    pub criteria_unjudged: Option<&'static str>,
    pub analytic: ModelReport,
    pub engine: ModelReport,
    /// Means over many runs beyond `until_s`, where trajectories are not compared; null if they are to the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub statistics: Option<Option<StatisticsReport>>,
    /// Impacts of both models, the scene's own torque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impacts: Option<Vec<ImpactReport>>,
    /// Of the engine at the scene's settings: worst of the ensemble.
    pub differences: DifferencesReport,
    /// Whether settings that take long were left out of the ladder, and the time that it had; null without one.
    pub quick: bool,
    pub ladder_time_s: Option<f64>,
    /// Speed against error: all settings that were tried; empty without a ladder.
    pub settings: Vec<SettingReport>,
    /// Directory of the results as given, and the files in it; null if none were asked for.
    pub directory: Option<String>,
    pub files: Option<Vec<String>>,
}

/// One bound.
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
    /// As keys of `[engine]`.
    pub setting: String,
    pub passed: bool,
}

/// One criterion in both models.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CriterionReport {
    /// Key of its bound, with its unit.
    pub criterion: &'static str,
    /// The pair or contact it is of; null where there is one.
    pub of: Option<String>,
    pub analytic: ValueReport,
    pub engine: ValueReport,
    /// What the bound is compared with; null where one model has none.
    pub difference: f64,
    pub limit: f64,
}

/// A word, or a figure in SI, or null.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ValueReport {
    Word(&'static str),
    Figure(Option<f64>),
}

impl From<&Criterion> for CriterionReport {
    fn from(found: &Criterion) -> Self {
        let value = |value: &Value| match value {
            Value::Word(word) => ValueReport::Word(word),
            Value::Figure(figure) => ValueReport::Figure(*figure),
        };
        CriterionReport {
            criterion: found.bound,
            of: Some(found.of.clone()).filter(|of| !of.is_empty()),
            analytic: value(&found.analytic),
            engine: value(&found.engine),
            difference: found.difference,
            limit: found.limit,
        }
    }
}

/// One of the two models, of the scene itself: the analytic one at its reference preset, the engine as the scene
/// says.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModelReport {
    pub setting: String,
    pub steps: u64,
    /// Median wall time with nothing listening; null without a ladder, which measures it.
    pub wall_s: Option<f64>,
    /// What moves, at the end of what is compared.
    #[serde(flatten)]
    pub states: States,
    /// Restitution is not measured here: `phalanx run` does.
    pub contacts: Contacts,
    pub energy: Energy,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loop_gap_m: Option<f64>,
    /// How near this run came to breaking each invariant.
    pub invariants: Vec<FindingReport>,
}

/// One touch-down in both models.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImpactReport {
    pub site: String,
    pub analytic_s: Option<f64>,
    pub engine_s: Option<f64>,
    /// How long the impulse is taken after the touch-down: up to the analytic model's lift-off, or for the first 20 µs.
    pub window_s: f64,
    pub analytic_n_s: Option<f64>,
    pub engine_n_s: Option<f64>,
}

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
    /// Whether the scene asks for this one, and whether it is the reference itself.
    pub own: bool,
    pub reference: bool,
    pub status: Status,
    /// Why there are no figures.
    pub reason: Option<String>,
    /// Runs of which the worst counts.
    pub ensemble_runs: usize,
    pub steps: Option<u64>,
    /// Median wall time of so many runs.
    pub wall_s: Option<f64>,
    pub timed_runs: Option<usize>,
    /// Simulated time over wall time; wall time over that of the analytic model at its engineering preset.
    pub real_time_factor: Option<f64>,
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
    /// `ladder`: how the ladder of `found` was climbed, if it was.
    pub fn new(scene: &Scene, found: &Validation, ladder: Option<Climb>) -> Self {
        let layout = Layout::of(&scene.system);
        let (finger, gripper) = (scene.kind() == SceneKind::Finger, scene.kind() == SceneKind::Gripper);
        let fingers = finger || gripper;
        let row = |wanted: fn(&Row) -> bool| found.rows.iter().find(|row| wanted(row));
        let analytic = (of_reference(scene), row(|row| row.rung.is_reference()));
        let engine = (own(scene), row(|row| row.rung.own));
        ValidationReport {
            scene: scene.name.clone(),
            kind: scene.kind().word(),
            passed: found.verdict.passed(),
            duration_s: scene.duration_s,
            until_s: found.until_s,
            ensemble_runs: members(scene),
            ensemble_torque_step: fingers.then_some(TORQUE_STEP),
            ensemble_speed_step: (!fingers).then_some(TORQUE_STEP),
            verdict: found.verdict.checks.iter().map(CheckReport::from).collect(),
            reference_error: found.reference_error(),
            trusted: found.trusted().map(Model::name),
            finer: found
                .finer
                .iter()
                .map(|(rung, passed)| FinerReport { setting: keys(rung), passed: *passed })
                .collect(),
            criteria: found.criteria.iter().map(CriterionReport::from).collect(),
            criteria_unjudged: found.unjudged.filter(|_| !found.criteria.is_empty()),
            analytic: ModelReport::new(scene, analytic, &found.reference, &found.reference_invariants),
            engine: ModelReport::new(scene, engine, &found.engine, &found.engine_invariants),
            statistics: finger.then(|| found.statistics.as_ref().map(StatisticsReport::from)),
            impacts: fingers.then(|| impacts(&layout, &found.reference, &found.engine)),
            differences: DifferencesReport::new(&layout, &found.differences),
            quick: ladder.is_some_and(|ladder| ladder.quick),
            ladder_time_s: ladder.map(|ladder| ladder.time_s),
            settings: found.rows.iter().map(|row| SettingReport::new(&layout, row)).collect(),
            directory: None,
            files: None,
        }
    }

    /// Whether coordinates can be made of its joints.
    pub(super) fn has_coordinates(&self) -> bool {
        self.kind == SceneKind::Finger.word()
    }

    pub(super) fn is_of_discs(&self) -> bool {
        self.kind == SceneKind::Bodies.word()
    }
}

impl ModelReport {
    fn new(scene: &Scene, (rung, row): (Rung, Option<&Row>), recording: &Recording, invariants: &[Finding]) -> Self {
        let (layout, outcome) = (Layout::of(&scene.system), &recording.outcome);
        let wall_s = row.and_then(|row| match row.tried {
            Tried::Done { cost, .. } => Some(cost.wall_s),
            _ => None,
        });
        ModelReport {
            setting: name(&rung),
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

/// The touch-downs of both models, the i-th of one beside the i-th of the other.
fn impacts(layout: &Layout, analytic: &Recording, engine: &Recording) -> Vec<ImpactReport> {
    let mut rows = Vec::new();
    for site in layout.surfaces() {
        let (mut ours, mut theirs) = (analytic.impacts.of(site), engine.impacts.of(site));
        loop {
            let pair = (ours.next(), theirs.next());
            if let (None, None) = pair {
                break;
            }
            rows.push(ImpactReport {
                site: layout.contacts[site].name.clone(),
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
    fn new(layout: &Layout, row: &Row) -> Self {
        let rung = &row.rung;
        let (status, reason) = match &row.tried {
            Tried::Done { .. } => (Status::Done, None),
            Tried::Failed { reason } => (Status::Failed, Some(reason.clone())),
            Tried::TooLong { steps } => (Status::TooLong, Some(format!("would take {steps:.1e} steps"))),
            Tried::NoTime => (Status::NoTime, Some("beyond the time of the ladder".to_string())),
        };
        let (found, cost) = match &row.tried {
            Tried::Done { differences, cost } => (differences.as_deref(), Some(cost)),
            _ => (None, None),
        };
        SettingReport {
            family: rung.family.name(),
            setting: name(rung),
            model: rung.model().name(),
            own: rung.own,
            reference: rung.is_reference(),
            status,
            reason,
            ensemble_runs: rung.members,
            steps: cost.map(|cost| cost.steps),
            wall_s: cost.map(|cost| cost.wall_s),
            timed_runs: cost.map(|cost| cost.runs),
            real_time_factor: cost.map(|cost| cost.real_time_factor()),
            analytic_factor: cost.map(|cost| cost.analytic_factor()),
            errors: Errors::new(layout, found),
        }
    }
}
