//! The JSON document of a validation.
//!
//! Keys end in their SI unit; those without a unit are ratios, counts or words. A value is null where there is nothing
//! to measure, and where only one of the models has the quantity (`passed` is then false).

use serde::Serialize;

use super::super::contacts::Contacts;
use super::super::named::Named;
use super::super::states::States;
use super::differences::{NamedDifferences, TOTAL, by_key, figures};
use crate::invariants::Finding;
use crate::scene::keywords::SceneKind;
use crate::scene::{Keyword, Scene};
use crate::trace::{Energy, Layout, Model, Outcome};
use crate::validate::{
    Criterion, FinerConfiguration, IMPACT_S, Impact, LadderOptions, LadderRow, MEMBER_PERTURBATION, Recording,
    SolverConfiguration, Statistics, Validation, Verdict, configuration_name, ensemble_size, reference_configuration,
    scene_configuration,
};

/// Report of a validation.
#[derive(Clone, Debug, Serialize)]
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
    pub verdict: Verdict,
    /// Estimated error of the reference trajectory, from two integration methods of the analytic model; in m for scenes
    /// of discs, otherwise in rad. Null where it is unknown.
    pub reference_error: Option<f64>,
    /// The model to trust if a bound fails; null if none fails, or if neither model can be trusted.
    #[serde(rename = "trusted")]
    pub trusted_model: Option<&'static str>,
    /// Finer settings of the engine that were run because a bound failed.
    #[serde(rename = "finer")]
    pub finer_settings: Vec<FinerConfiguration>,
    /// Criteria of both models.
    pub criteria: Vec<Criterion>,
    /// Reason why the criteria are not judged; null if they are.
    #[serde(rename = "criteria_unjudged")]
    pub reason_not_judged: Option<&'static str>,
    pub analytic: ModelReport,
    pub engine: ModelReport,
    /// Means over many runs beyond `until_s`, where trajectories are not compared; null if they are compared to the
    /// end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub statistics: Option<Option<Statistics>>,
    /// Impacts of both models at the scene's own torque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impacts: Option<Vec<ImpactReport>>,
    /// Differences of the engine at the scene's settings: the worst of the ensemble.
    pub differences: NamedDifferences,
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

/// Run of one of the models for the scene itself: the analytic model at its reference preset, or the engine at the
/// scene's settings.
#[derive(Clone, Debug, Serialize)]
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
    #[serde(skip)]
    pub(super) outcome: Outcome,
}

/// Margin of one invariant.
#[derive(Clone, Debug, Serialize)]
pub struct FindingReport {
    pub invariant: &'static str,
    pub meaning: &'static str,
    #[serde(rename = "held")]
    pub is_satisfied: bool,
    /// Measured value as a fraction of the limit; null if it is not finite.
    pub share: f64,
    /// Worst value, in the SI unit of the quantity.
    pub measured: f64,
    /// Limit, in the same unit.
    pub allowed: f64,
    /// Location of the worst value.
    #[serde(rename = "place")]
    pub location: Option<String>,
    /// Time of the worst value.
    pub time_s: f64,
    /// The finding as one line of text.
    #[serde(skip)]
    pub line: String,
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

/// One setting: its cost and its errors, which are null for the reference and without results.
#[derive(Clone, Debug, Serialize)]
pub struct SettingReport {
    #[serde(flatten)]
    pub row: LadderRow,
    /// Largest errors; for a single finger only of the angles.
    #[serde(flatten)]
    pub errors: Named<Option<f64>>,
    /// All differences of a single finger.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub differences: Option<Option<NamedDifferences>>,
}

impl ValidationReport {
    /// Creates the report. `ladder` are the options of the ladder of `validation`, if it was run.
    pub fn new(scene: &Scene, validation: &Validation, ladder: Option<LadderOptions>) -> Self {
        let layout = Layout::from_system(&scene.system);
        let has_fingers = !layout.fingers.is_empty();
        let find_row = |predicate: fn(&LadderRow) -> bool| validation.ladder.iter().find(|row| predicate(row));
        let analytic = (reference_configuration(scene), find_row(|row| row.is_reference));
        let engine = (scene_configuration(scene), find_row(|row| row.is_from_scene));
        ValidationReport {
            scene: scene.name.clone(),
            kind: scene.kind().keyword(),
            passed: validation.verdict.passed(),
            duration_s: scene.duration_s,
            until_s: validation.until_s,
            ensemble_runs: ensemble_size(scene),
            ensemble_torque_step: has_fingers.then_some(MEMBER_PERTURBATION),
            ensemble_speed_step: (!has_fingers).then_some(MEMBER_PERTURBATION),
            verdict: validation.verdict.clone(),
            reference_error: validation.reference_error(),
            trusted_model: validation.trusted_model().map(Model::name),
            finer_settings: validation.finer_configurations.clone(),
            criteria: validation.criteria.clone(),
            reason_not_judged: validation.reason_not_judged.filter(|_| !validation.criteria.is_empty()),
            analytic: ModelReport::new(scene, analytic, &validation.reference, &validation.reference_invariants),
            engine: ModelReport::new(scene, engine, &validation.engine, &validation.engine_invariants),
            statistics: (scene.kind() == SceneKind::Finger).then(|| validation.statistics.clone()),
            impacts: has_fingers.then(|| impacts(&layout, &validation.reference, &validation.engine)),
            quick: ladder.is_some_and(|ladder| ladder.quick),
            ladder_time_s: ladder.map(|ladder| ladder.time_s),
            settings: validation.ladder.iter().map(|row| SettingReport::new(&layout, row)).collect(),
            differences: NamedDifferences { layout, found: validation.differences.clone() },
            directory: None,
            files: None,
        }
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
        ModelReport {
            setting: configuration_name(&configuration),
            steps: outcome.work.steps,
            wall_s: row.and_then(|row| row.cost.wall_s),
            states: States::new(&layout, Some(outcome), Some(scene)),
            contacts: Contacts::new(&layout, outcome, &[]),
            energy: outcome.last.energy,
            loop_gap_m: (scene.kind() != SceneKind::Bodies).then_some(outcome.loop_gap_m),
            invariants: invariants.iter().map(FindingReport::from).collect(),
            outcome: outcome.clone(),
        }
    }
}

impl From<&Finding> for FindingReport {
    fn from(found: &Finding) -> Self {
        Self {
            invariant: found.invariant.name(),
            meaning: found.invariant.meaning(),
            is_satisfied: !found.is_violated(),
            share: found.ratio_to_limit(),
            measured: found.measured,
            allowed: found.allowed,
            location: found.contact.clone(),
            time_s: found.time_s,
            line: found.to_string(),
        }
    }
}

impl SettingReport {
    fn new(layout: &Layout, row: &LadderRow) -> Self {
        let is_single_finger = layout.fingers.len() == 1;
        let found = row.differences.as_ref();
        let shown = if is_single_finger { 1 } else { TOTAL.len() };
        let named = |found: &_| NamedDifferences { layout: layout.clone(), found: Clone::clone(found) };
        SettingReport {
            row: row.clone(),
            errors: by_key(figures(&TOTAL, layout, found, 0).take(shown)),
            differences: is_single_finger.then(|| found.map(named)),
        }
    }
}

/// Pairs the touch-downs of both models by their order at each contact.
fn impacts(layout: &Layout, analytic: &Recording, engine: &Recording) -> Vec<ImpactReport> {
    let at_contact = |contact: usize| {
        let [analytic, engine]: [Vec<&Impact>; 2] =
            [analytic, engine].map(|run| run.impacts.of_contact(contact).collect());
        (0..analytic.len().max(engine.len())).map(move |index| {
            let (analytic, engine) = (analytic.get(index), engine.get(index));
            ImpactReport {
                contact: layout.contacts[contact].name.clone(),
                analytic_s: analytic.map(|impact| impact.time_s),
                engine_s: engine.map(|impact| impact.time_s),
                window_s: analytic.or(engine).map_or(IMPACT_S, |impact| impact.end_s() - impact.time_s),
                analytic_n_s: analytic.map(|impact| impact.impulse_n_s()),
                engine_n_s: engine.map(|impact| impact.impulse_n_s()),
            }
        })
    };
    layout.surfaces().flat_map(at_contact).collect()
}
