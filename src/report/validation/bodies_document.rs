//! The figures of a validation of discs; see [`ValidationReport`](super::ValidationReport) for the keys that both have.

use std::collections::BTreeMap;

use serde::Serialize;

use super::super::contacts::{PairReport, pairs};
use super::super::discs::{DiscReport, discs};
use super::super::document::Energies;
use super::document::{CheckReport, SettingReport};
use super::invariants::FindingReport;
use crate::invariants::Finding;
use crate::scene::BodiesScene;
use crate::trace::Simulated;
use crate::validate::{BodiesDifferences, MEMBERS, Recording, Row, TORQUE_STEP, Tried, Validation, name};

/// One validation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodiesValidationReport {
    pub scene: String,
    /// `bodies`.
    pub kind: &'static str,
    pub passed: bool,
    pub duration_s: f64,
    /// Both models are run up to here.
    pub until_s: f64,
    /// Runs of which the worst counts, and the relative step of all speeds and of gravity from one to the next.
    pub ensemble_runs: usize,
    pub ensemble_speed_step: f64,
    pub verdict: Vec<CheckReport>,
    pub analytic: BodiesModelReport,
    pub engine: BodiesModelReport,
    /// Of the engine at the scene's settings: worst of the ensemble.
    pub differences: DiscDifferences,
    pub quick: bool,
    pub settings: Vec<SettingReport<DiscErrors>>,
    pub directory: Option<String>,
    pub files: Option<Vec<String>>,
}

/// One of the two models: the analytic one at its reference preset, the engine as the scene says.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodiesModelReport {
    pub setting: String,
    pub steps: Option<u64>,
    pub wall_s: Option<f64>,
    /// At the end of what is compared.
    pub discs: BTreeMap<String, DiscReport>,
    /// Restitution is not measured here: `phalanx run` does.
    pub contacts: BTreeMap<String, PairReport>,
    pub energy: Energies,
    /// How near this run came to breaking each invariant.
    pub invariants: Vec<FindingReport>,
}

/// Differences of one disc.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DiscDifference {
    pub max_m: f64,
    pub max_at_s: f64,
    pub rms_m: f64,
    pub end_m: f64,
    pub angle_end_rad: f64,
}

/// Differences of one pair; impulse and peak force are relative.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PairDifference {
    pub first_touch_s: Option<f64>,
    pub impulse: Option<f64>,
    pub peak_force: Option<f64>,
}

/// Everything in which the engine differs from the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DiscDifferences {
    pub discs: BTreeMap<String, DiscDifference>,
    pub pairs: BTreeMap<String, PairDifference>,
    pub energy_created_j: f64,
    /// Relative to the largest energy of the run.
    pub energy_created: f64,
}

/// Worst differences of a setting over all discs and pairs; null for the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DiscErrors {
    pub position_max_m: Option<f64>,
    pub first_touch_s: Option<f64>,
    pub impulse: Option<f64>,
    pub peak_force: Option<f64>,
    pub energy_created: Option<f64>,
}

impl From<Option<&BodiesDifferences>> for DiscErrors {
    fn from(found: Option<&BodiesDifferences>) -> Self {
        DiscErrors {
            position_max_m: found.map(BodiesDifferences::position_m),
            first_touch_s: found.and_then(BodiesDifferences::contact_time),
            impulse: found.and_then(BodiesDifferences::impulse),
            peak_force: found.and_then(BodiesDifferences::peak_force),
            energy_created: found.map(|found| found.energy_created),
        }
    }
}

impl BodiesValidationReport {
    pub fn new(scene: &BodiesScene, found: &Validation<BodiesScene>, quick: bool) -> Self {
        let row = |wanted: fn(&Row<BodiesDifferences>) -> bool| found.rows.iter().find(|row| wanted(row));
        BodiesValidationReport {
            scene: scene.name.clone(),
            kind: "bodies",
            passed: found.verdict.passed(),
            duration_s: scene.duration_s,
            until_s: found.bounds.until_s,
            ensemble_runs: MEMBERS,
            ensemble_speed_step: TORQUE_STEP,
            verdict: found.verdict.checks.iter().map(CheckReport::from).collect(),
            analytic: model(scene, row(|row| row.rung.is_reference()), &found.reference, &found.reference_invariants),
            engine: model(scene, row(|row| row.rung.own), &found.engine, &found.engine_invariants),
            differences: differences(scene, &found.differences),
            quick,
            settings: found.rows.iter().map(SettingReport::from).collect(),
            directory: None,
            files: None,
        }
    }
}

fn model(
    scene: &BodiesScene,
    row: Option<&Row<BodiesDifferences>>,
    run: &Recording,
    invariants: &[Finding],
) -> BodiesModelReport {
    let cost = row.and_then(|row| match row.tried {
        Tried::Done { cost, .. } => Some(cost),
        _ => None,
    });
    let layout = Simulated::from(scene).layout();
    BodiesModelReport {
        setting: row.map(|row| name(&row.rung)).unwrap_or_default(),
        steps: cost.map(|cost| cost.steps),
        wall_s: cost.map(|cost| cost.wall_s),
        discs: discs(&layout.bodies, Some(scene), &run.outcome.last.bodies),
        contacts: pairs(&layout, &run.outcome, &[]),
        energy: Energies::from(&run.outcome.last.energy),
        invariants: invariants.iter().map(FindingReport::from).collect(),
    }
}

fn differences(scene: &BodiesScene, found: &BodiesDifferences) -> DiscDifferences {
    let disc = |k: usize| DiscDifference {
        max_m: found.position_max_m[k],
        max_at_s: found.position_max_at_s[k],
        rms_m: found.position_rms_m[k],
        end_m: found.position_end_m[k],
        angle_end_rad: found.angle_end_rad[k],
    };
    let pair = |k: usize| PairDifference {
        first_touch_s: found.contact_time_s[k],
        impulse: found.impulse[k],
        peak_force: found.peak_force[k],
    };
    let pairs = scene.pairs().into_iter().enumerate();
    DiscDifferences {
        discs: scene.discs.iter().enumerate().map(|(k, of)| (of.name.clone(), disc(k))).collect(),
        pairs: pairs.map(|(k, of)| (scene.pair_name(of), pair(k))).collect(),
        energy_created_j: found.energy_created_j,
        energy_created: found.energy_created,
    }
}
