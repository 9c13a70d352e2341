//! The JSON document of a validation.
//!
//! Keys end in their SI unit; those without a unit are ratios, counts or words. A value is null where there is nothing
//! to measure, and where only one of the models has the quantity (`passed` is then false).

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::super::contacts::Contacts;
use super::super::named::Named;
use super::super::states::States;
use super::differences::{NamedDifferences, TOTAL, by_key, figures};
use crate::invariants::Finding;
use crate::scene::keywords::SceneKind;
use crate::scene::{Keyword, Scene};
use crate::trace::{Energy, Model, Schema};
use crate::validate::{
    IMPACT_S, Impact, LadderOptions, LadderRow, MEMBER_PERTURBATION, Recording, SolverConfiguration, Validation,
    configuration_name, ensemble_size, reference_configuration, scene_configuration,
};

/// Report of a validation.
#[derive(Clone, Debug)]
pub struct ValidationReport<'a> {
    pub(super) scene: &'a Scene,
    pub(super) layout: Schema,
    pub(super) validation: &'a Validation,
    /// Options of the ladder, if it was run.
    pub(super) ladder: Option<LadderOptions>,
    /// Directory of the results, as given by the user, and the files in it; `None` if none were requested.
    pub files: Option<(String, Vec<String>)>,
}

impl<'a> ValidationReport<'a> {
    /// Creates the report. `ladder` are the options of the ladder of `validation`, if it was run.
    pub fn new(scene: &'a Scene, validation: &'a Validation, ladder: Option<LadderOptions>) -> Self {
        let layout = Schema::from_system(&scene.system);
        ValidationReport { scene, layout, validation, ladder, files: None }
    }

    pub(super) fn differences(&self) -> NamedDifferences<'_> {
        NamedDifferences { layout: &self.layout, found: &self.validation.differences }
    }

    /// The analytic model at its reference preset, or the engine at the scene's settings.
    pub(super) fn configuration(&self, model: Model) -> SolverConfiguration {
        match model {
            Model::Analytic => reference_configuration(self.scene),
            Model::Engine => scene_configuration(self.scene),
        }
    }

    fn model(&self, model: Model) -> ModelDocument<'_> {
        let Validation { reference, engine, reference_invariants, engine_invariants, ladder, .. } = self.validation;
        let (recording, invariants) = match model {
            Model::Analytic => (reference, reference_invariants),
            Model::Engine => (engine, engine_invariants),
        };
        let is_timed = |row: &&LadderRow| if model == Model::Analytic { row.is_reference } else { row.is_from_scene };
        let outcome = &recording.outcome;
        ModelDocument {
            setting: configuration_name(&self.configuration(model)),
            steps: outcome.work.steps,
            wall_s: ladder.iter().find(is_timed).and_then(|row| row.cost.wall_s),
            states: States::new(&self.layout, Some(outcome), Some(self.scene)),
            contacts: Contacts::new(&self.layout, outcome, &[]),
            energy: outcome.last.energy(),
            loop_gap_m: (self.scene.kind() != SceneKind::Bodies).then_some(outcome.loop_gap_m),
            invariants,
        }
    }

    /// The errors of a configuration are null for the reference and without results. A single finger has only the
    /// largest error of the angles, and all differences instead.
    fn setting<'r>(&'r self, row: &'r LadderRow) -> SettingDocument<'r> {
        let is_single_finger = self.layout.fingers.len() == 1;
        let shown = if is_single_finger { 1 } else { TOTAL.len() };
        let named = |found| NamedDifferences { layout: &self.layout, found };
        SettingDocument {
            row,
            errors: by_key(figures(&TOTAL, &self.layout, row.differences.as_ref(), 0).take(shown)),
            differences: is_single_finger.then(|| row.differences.as_ref().map(named)),
        }
    }

    /// Pairs the touch-downs of both models by their order at each contact.
    pub(super) fn impacts(&self) -> Vec<ImpactPair> {
        let Validation { reference, engine, .. } = self.validation;
        let at_contact = |contact: usize| {
            let impacts = |run: &Recording| run.impacts.of_contact(contact).copied().collect::<Vec<Impact>>();
            let (analytic, engine) = (impacts(reference), impacts(engine));
            (0..analytic.len().max(engine.len())).map(move |index| {
                let (analytic, engine) = (analytic.get(index), engine.get(index));
                ImpactPair {
                    site: self.layout.contacts[contact].name.clone(),
                    analytic_s: analytic.map(|impact| impact.time_s),
                    engine_s: engine.map(|impact| impact.time_s),
                    window_s: analytic.or(engine).map_or(IMPACT_S, |impact| impact.end_s() - impact.time_s),
                    analytic_n_s: analytic.map(Impact::impulse_n_s),
                    engine_n_s: engine.map(Impact::impulse_n_s),
                }
            })
        };
        self.layout.surfaces().flat_map(at_contact).collect()
    }
}

/// Keys that do not apply to a kind of scene are absent.
impl Serialize for ValidationReport<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (scene, validation) = (self.scene, self.validation);
        let has_fingers = !self.layout.fingers.is_empty();
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("scene", &scene.name)?;
        map.serialize_entry("kind", scene.kind().keyword())?;
        map.serialize_entry("passed", &validation.verdict.passed())?;
        map.serialize_entry("duration_s", &scene.duration_s)?;
        map.serialize_entry("until_s", &validation.until_s)?;
        map.serialize_entry("ensemble_runs", &ensemble_size(scene))?;
        // Relative difference of the motor torque, or of gravity and the speeds of all discs, between consecutive runs.
        let step = if has_fingers { "ensemble_torque_step" } else { "ensemble_speed_step" };
        map.serialize_entry(step, &MEMBER_PERTURBATION)?;
        map.serialize_entry("verdict", &validation.verdict)?;
        // In m for scenes of discs, otherwise in rad.
        map.serialize_entry("reference_error", &validation.reference_error())?;
        map.serialize_entry("trusted", &validation.trusted_model().map(Model::name))?;
        map.serialize_entry("finer", &validation.finer_configurations)?;
        map.serialize_entry("criteria", &validation.criteria)?;
        let reason = validation.reason_not_judged.filter(|_| !validation.criteria.is_empty());
        map.serialize_entry("criteria_unjudged", &reason)?;
        map.serialize_entry("analytic", &self.model(Model::Analytic))?;
        map.serialize_entry("engine", &self.model(Model::Engine))?;
        if scene.kind() == SceneKind::Finger {
            map.serialize_entry("statistics", &validation.statistics)?;
        }
        if has_fingers {
            map.serialize_entry("impacts", &self.impacts())?;
        }
        map.serialize_entry("differences", &self.differences())?;
        map.serialize_entry("quick", &self.ladder.is_some_and(|ladder| ladder.quick))?;
        map.serialize_entry("ladder_time_s", &self.ladder.map(|ladder| ladder.time_s))?;
        let settings: Vec<_> = validation.ladder.iter().map(|row| self.setting(row)).collect();
        map.serialize_entry("settings", &settings)?;
        map.serialize_entry("directory", &self.files.as_ref().map(|(directory, _)| directory))?;
        map.serialize_entry("files", &self.files.as_ref().map(|(_, files)| files))?;
        map.end()
    }
}

/// Run of one of the models for the scene itself.
#[derive(Serialize)]
struct ModelDocument<'a> {
    setting: String,
    steps: u64,
    /// Median wall time without output; null without a ladder, which measures it.
    wall_s: Option<f64>,
    /// States of fingers and bodies at the end of the compared time.
    #[serde(flatten)]
    states: States,
    /// Contacts without restitution, which `phalanx run` measures.
    contacts: Contacts,
    energy: Energy,
    #[serde(skip_serializing_if = "Option::is_none")]
    loop_gap_m: Option<f64>,
    invariants: &'a [Finding],
}

/// One touch-down in both models.
#[derive(Serialize)]
pub(super) struct ImpactPair {
    pub site: String,
    pub analytic_s: Option<f64>,
    pub engine_s: Option<f64>,
    /// Time after the touch-down over which the impulse is measured: up to the lift-off of the analytic model, or 20
    /// µs.
    pub window_s: f64,
    pub analytic_n_s: Option<f64>,
    pub engine_n_s: Option<f64>,
}

/// A configuration of the ladder with its errors.
#[derive(Serialize)]
struct SettingDocument<'a> {
    #[serde(flatten)]
    row: &'a LadderRow,
    #[serde(flatten)]
    errors: Named<Option<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    differences: Option<Option<NamedDifferences<'a>>>,
}
