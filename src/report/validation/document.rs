//! The figures of a validation, in the order and under the keys of the JSON document.
//!
//! Keys carry their SI unit; those without one are ratios, counts or words. Where there is nothing to measure, and
//! where one model lacks what the other has (`passed` is then false), the value is null.

use std::collections::BTreeMap;

use serde::Serialize;

use super::super::contacts::FingerContacts;
use super::super::document::{Energies, Final};
use super::invariants::FindingReport;
use super::statistics::StatisticsReport;
use crate::invariants::Finding;
use crate::scene::Scene;
use crate::trace::Site;
use crate::validate::{
    Angle, Check, Differences, IMPACT_S, MEMBERS, Recording, Row, TORQUE_STEP, Tried, Validation, name,
};

/// One validation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ValidationReport {
    /// Name of the scene.
    pub scene: String,
    /// `finger`.
    pub kind: &'static str,
    /// Whether every bound holds.
    pub passed: bool,
    pub duration_s: f64,
    /// Trajectories are compared up to here.
    pub until_s: f64,
    /// Runs of which the worst counts, and the relative step of the motor torque from one to the next.
    pub ensemble_runs: usize,
    pub ensemble_torque_step: f64,
    pub verdict: Vec<CheckReport>,
    pub analytic: ModelReport,
    pub engine: ModelReport,
    /// Means over many runs beyond `until_s`, where trajectories are not compared; null if they are to the end.
    pub statistics: Option<StatisticsReport>,
    /// Impacts of both models, the scene's own torque.
    pub impacts: Vec<ImpactReport>,
    /// Of the engine at the scene's settings: worst of the ensemble.
    pub differences: DifferencesReport,
    /// Whether settings that take long were left out.
    pub quick: bool,
    /// Speed against error: all settings that were tried.
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

/// One of the two models at the scene's own torque: the analytic one at its reference preset, the engine as the scene
/// says.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModelReport {
    pub setting: String,
    pub steps: Option<u64>,
    /// Median wall time with nothing listening.
    pub wall_s: Option<f64>,
    #[serde(rename = "final")]
    pub last: Final,
    pub contacts: FingerContacts,
    pub energy: Energies,
    pub loop_gap_m: f64,
    /// How near this run came to breaking each invariant.
    pub invariants: Vec<FindingReport>,
}

/// One touch-down of a phalanx in both models.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImpactReport {
    pub site: &'static str,
    pub analytic_s: Option<f64>,
    pub engine_s: Option<f64>,
    /// How long the impulse is taken after the touch-down: up to the analytic model's lift-off, or for the first 20 µs.
    pub window_s: f64,
    pub analytic_n_s: Option<f64>,
    pub engine_n_s: Option<f64>,
}

/// Differences of one joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AngleDifference {
    pub max_rad: f64,
    pub max_at_s: f64,
    pub rms_rad: f64,
    pub end_rad: f64,
    pub rate_rms_rad_s: f64,
}

/// Differences of the contact of one phalanx; the forces and impulses are relative.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ContactDifference {
    pub first_touch_s: Option<f64>,
    pub impulse: Option<f64>,
    pub final_force: Option<f64>,
}

/// Everything in which a setting differs from the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DifferencesReport {
    pub joints: BTreeMap<&'static str, AngleDifference>,
    pub proximal: ContactDifference,
    pub distal: ContactDifference,
    pub loop_gap_m: f64,
    pub energy_created_j: f64,
    /// Relative to the work of the motor.
    pub energy_created: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    Done,
    Failed,
    TooLong,
}

/// One setting: its cost and its differences `E` from the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SettingReport<E = JointErrors> {
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
    pub errors: E,
}

/// Differences of a finger; null for the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointErrors {
    pub angle_max_rad: Option<f64>,
    pub differences: Option<DifferencesReport>,
}

impl From<Option<&Differences>> for JointErrors {
    fn from(found: Option<&Differences>) -> Self {
        JointErrors {
            angle_max_rad: found.map(Differences::angle_rad),
            differences: found.map(DifferencesReport::from),
        }
    }
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
    pub fn new(scene: &Scene, found: &Validation, quick: bool) -> Self {
        let row = |wanted: fn(&Row) -> bool| found.rows.iter().find(|row| wanted(row));
        ValidationReport {
            scene: scene.name.clone(),
            kind: "finger",
            passed: found.verdict.passed(),
            duration_s: scene.duration_s,
            until_s: found.bounds.until_s,
            ensemble_runs: MEMBERS,
            ensemble_torque_step: TORQUE_STEP,
            verdict: found.verdict.checks.iter().map(CheckReport::from).collect(),
            analytic: ModelReport::new(
                row(|row| row.rung.is_reference()),
                &found.reference,
                &found.reference_invariants,
            ),
            statistics: found.statistics.as_ref().map(StatisticsReport::from),
            engine: ModelReport::new(row(|row| row.rung.own), &found.engine, &found.engine_invariants),
            impacts: impacts(&found.reference, &found.engine),
            differences: DifferencesReport::from(&found.differences),
            quick,
            settings: found.rows.iter().map(SettingReport::from).collect(),
            directory: None,
            files: None,
        }
    }
}

impl ModelReport {
    fn new(row: Option<&Row>, recording: &Recording, invariants: &[Finding]) -> Self {
        let outcome = &recording.outcome;
        let cost = row.and_then(|row| match row.tried {
            Tried::Done { cost, .. } => Some(cost),
            _ => None,
        });
        ModelReport {
            setting: row.map(|row| name(&row.rung)).unwrap_or_default(),
            steps: cost.map(|cost| cost.steps),
            wall_s: cost.map(|cost| cost.wall_s),
            last: Final::from(outcome.last.finger()),
            contacts: FingerContacts::from(outcome),
            energy: Energies::from(&outcome.last.energy),
            loop_gap_m: outcome.loop_gap_m,
            invariants: invariants.iter().map(FindingReport::from).collect(),
        }
    }
}

/// The touch-downs of both models, the i-th of one beside the i-th of the other.
fn impacts(analytic: &Recording, engine: &Recording) -> Vec<ImpactReport> {
    let mut rows = Vec::new();
    for site in [Site::Proximal, Site::Distal] {
        let (mut ours, mut theirs) = (analytic.impacts.of(site as usize), engine.impacts.of(site as usize));
        loop {
            let pair = (ours.next(), theirs.next());
            if let (None, None) = pair {
                break;
            }
            rows.push(ImpactReport {
                site: site.name(),
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

impl From<&Differences> for DifferencesReport {
    fn from(found: &Differences) -> Self {
        let joint = |k: usize| AngleDifference {
            max_rad: found.angle_max_rad[k],
            max_at_s: found.angle_max_at_s[k],
            rms_rad: found.angle_rms_rad[k],
            end_rad: found.angle_end_rad[k],
            rate_rms_rad_s: found.rate_rms_rad_s[k],
        };
        let contact = |k: usize| ContactDifference {
            first_touch_s: found.contact_time_s[k],
            impulse: found.impulse[k],
            final_force: found.final_force[k],
        };
        DifferencesReport {
            joints: Angle::ALL.into_iter().enumerate().map(|(k, angle)| (angle.name(), joint(k))).collect(),
            proximal: contact(0),
            distal: contact(1),
            loop_gap_m: found.loop_gap_m,
            energy_created_j: found.energy_created_j,
            energy_created: found.energy_created,
        }
    }
}

impl<D, E: for<'a> From<Option<&'a D>>> From<&Row<D>> for SettingReport<E> {
    fn from(row: &Row<D>) -> Self {
        let rung = &row.rung;
        let (status, reason) = match &row.tried {
            Tried::Done { .. } => (Status::Done, None),
            Tried::Failed { reason } => (Status::Failed, Some(reason.clone())),
            Tried::TooLong { steps } => (Status::TooLong, Some(format!("would take {steps:.1e} steps"))),
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
            errors: E::from(found),
        }
    }
}
