//! Report of a validation: one document, printed as text or JSON, and the time series of both models side by side.
//!
//! Keys of the document end in their SI unit; those without a unit are ratios, counts or words. A value is null where
//! there is nothing to measure, and where only one of the models has the quantity (`passed` is then false).

mod text;

use std::io::{self, Write};

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::contacts::Contacts;
use super::named::Named;
use super::samples::cell;
use super::states::States;
use crate::format::numbers::{format_number, or_dash};
use crate::format::report::{Report, table};
use crate::invariants::Finding;
use crate::scene::{Keyword, Scene};
use crate::trace::{Channel, Energy, Model, Schema};
use crate::validate::{
    Angle, Differences, IMPACT_S, Impact, LadderOptions, LadderRow, MEMBER_PERTURBATION, Recording,
    SolverConfiguration, Validation, configuration_name, ensemble_size, largest, reference_configuration,
    scene_configuration,
};

/// Report of a validation.
#[derive(Clone, Debug)]
pub struct ValidationReport<'a> {
    scene: &'a Scene,
    schema: Schema,
    validation: &'a Validation,
    /// Options of the ladder, if it was run.
    ladder: Option<LadderOptions>,
    /// Directory of the results, as given by the user, and the files in it; `None` if no files were requested.
    pub files: Option<(String, Vec<String>)>,
    /// Whether the text of a mechanism contains all differences; otherwise only the largest ones.
    pub all: bool,
}

impl<'a> ValidationReport<'a> {
    /// Creates the report. `ladder` contains the options of the ladder in `validation`; `None` if no ladder was run.
    pub fn new(scene: &'a Scene, validation: &'a Validation, ladder: Option<LadderOptions>) -> Self {
        let schema = Schema::from_scene(scene);
        ValidationReport { scene, schema, validation, ladder, files: None, all: true }
    }

    fn differences(&self) -> NamedDifferences<'_> {
        NamedDifferences { schema: &self.schema, found: &self.validation.differences }
    }

    /// The analytic model at its reference preset, or the engine at the scene's settings.
    fn configuration(&self, model: Model) -> SolverConfiguration {
        match model {
            Model::Analytic => reference_configuration(self.scene),
            Model::Engine => scene_configuration(self.scene),
        }
    }

    fn model(&self, model: Model) -> ModelDocument<'_> {
        let found = self.validation;
        let is_analytic = model == Model::Analytic;
        let timed = found.ladder.iter().find(|row| if is_analytic { row.is_reference } else { row.is_from_scene });
        let outcome = if is_analytic { &found.reference.outcome } else { &found.engine.outcome };
        ModelDocument {
            setting: configuration_name(&self.configuration(model)),
            steps: outcome.work.steps,
            wall_s: timed.and_then(|row| row.cost.wall_s),
            states: States::new(&self.schema, Some(outcome), Some(self.scene)),
            contacts: Contacts::new(&self.schema, outcome, &[]),
            energy: outcome.last.energy(),
            loop_gap_m: self.scene.has_joints().then_some(outcome.loop_gap_m),
            invariants: if is_analytic { &found.reference_invariants } else { &found.engine_invariants },
        }
    }

    /// The errors of a configuration are null for the reference and without results. A single finger has only the
    /// largest error of the angles, and all differences instead.
    fn setting<'r>(&'r self, row: &'r LadderRow) -> SettingDocument<'r> {
        let is_single_finger = self.schema.fingers.len() == 1;
        let shown = if is_single_finger { 1 } else { TOTAL.len() };
        let named = |found| NamedDifferences { schema: &self.schema, found };
        SettingDocument {
            row,
            errors: by_key(figures(&TOTAL, &self.schema, row.differences.as_ref(), 0).take(shown)),
            differences: is_single_finger.then(|| row.differences.as_ref().map(named)),
        }
    }

    /// Pairs the touch-downs of both models by their order at each contact.
    fn impacts(&self) -> Vec<ImpactPair> {
        let Validation { reference, engine, .. } = self.validation;
        let at_contact = |contact: usize| {
            let impacts = |run: &Recording| run.impacts.of_contact(contact).copied().collect::<Vec<Impact>>();
            let (analytic, engine) = (impacts(reference), impacts(engine));
            (0..analytic.len().max(engine.len())).map(move |index| {
                let (analytic, engine) = (analytic.get(index), engine.get(index));
                ImpactPair {
                    site: self.schema.contacts[contact].name.clone(),
                    analytic_s: analytic.map(|impact| impact.time_s),
                    engine_s: engine.map(|impact| impact.time_s),
                    window_s: analytic.or(engine).map_or(IMPACT_S, |impact| impact.end_s() - impact.time_s),
                    analytic_n_s: analytic.map(Impact::impulse_n_s),
                    engine_n_s: engine.map(Impact::impulse_n_s),
                }
            })
        };
        self.schema.surfaces().flat_map(at_contact).collect()
    }
}

/// Keys that do not apply to a kind of scene are absent.
impl Serialize for ValidationReport<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (scene, validation) = (self.scene, self.validation);
        let has_fingers = !self.schema.fingers.is_empty();
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("scene", &scene.name)?;
        map.serialize_entry("kind", scene.kind.keyword())?;
        map.serialize_entry("passed", &validation.verdict.passed())?;
        map.serialize_entry("duration_s", &scene.duration_s)?;
        map.serialize_entry("until_s", &validation.until_s)?;
        map.serialize_entry("ensemble_runs", &ensemble_size(scene))?;
        // Relative difference of the motor torque, or of gravity and the speeds of all discs, between consecutive runs.
        let step = if has_fingers { "ensemble_torque_step" } else { "ensemble_speed_step" };
        map.serialize_entry(step, &MEMBER_PERTURBATION)?;
        map.serialize_entry("verdict", &validation.verdict)?;
        // In m for scenes without joints, otherwise in rad.
        map.serialize_entry("reference_error", &validation.reference_error())?;
        map.serialize_entry("trusted", &validation.trusted_model().map(Model::name))?;
        map.serialize_entry("finer", &validation.finer_configurations)?;
        map.serialize_entry("criteria", &validation.criteria)?;
        let reason = validation.reason_not_judged.filter(|_| !validation.criteria.is_empty());
        map.serialize_entry("criteria_unjudged", &reason)?;
        map.serialize_entry("analytic", &self.model(Model::Analytic))?;
        map.serialize_entry("engine", &self.model(Model::Engine))?;
        if scene.finger_count() == 1 {
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
struct ImpactPair {
    site: String,
    analytic_s: Option<f64>,
    engine_s: Option<f64>,
    /// Time after the touch-down over which the impulse is measured: up to the lift-off of the analytic model, or 20 µs.
    window_s: f64,
    analytic_n_s: Option<f64>,
    engine_n_s: Option<f64>,
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

/// One figure of a component: key in the document, header in tables with the displayed unit, displayed value per SI
/// value, number of digits, and the value for the component with an index; the angles of fingers and the centres of
/// bodies have the indices of [`Differences::path`].
struct Figure(&'static str, &'static str, f64, usize, fn(&Differences, usize) -> Option<f64>);

const JOINT: [Figure; 5] = [
    Figure("max_rad", "max, rad", 1.0, 3, |found, k| Some(found.path[k].max)),
    Figure("max_at_s", "at, ms", 1e3, 5, |found, k| Some(found.path[k].max_at_s)),
    Figure("rms_rad", "RMS, rad", 1.0, 3, |found, k| Some(found.path[k].rms)),
    Figure("end_rad", "at the end, rad", 1.0, 3, |found, k| Some(found.path[k].end)),
    Figure("rate_rms_rad_s", "rate RMS, rad/s", 1.0, 3, |found, k| Some(found.rate_rms_rad_s[k])),
];
const BODY: [Figure; 6] = [
    Figure("max_m", "max, µm", 1e6, 3, |found, k| Some(found.path[k].max)),
    Figure("max_at_s", "at, ms", 1e3, 5, |found, k| Some(found.path[k].max_at_s)),
    Figure("rms_m", "RMS, µm", 1e6, 3, |found, k| Some(found.path[k].rms)),
    Figure("end_m", "at the end, µm", 1e6, 3, |found, k| Some(found.path[k].end)),
    Figure("angle_max_rad", "angle max, rad", 1.0, 3, |found, k| Some(found.turn[k - found.rate_rms_rad_s.len()].max)),
    Figure("angle_end_rad", "angle at the end, rad", 1.0, 3, |found, k| {
        Some(found.turn[k - found.rate_rms_rad_s.len()].end)
    }),
];
/// Figures of a contact between surfaces; forces and impulses are relative.
const CONTACT: [Figure; 4] = [
    Figure("first_touch_s", "first contact, µs", 1e6, 3, |found, k| found.contact_time_s[k]),
    Figure("impulse", "impulse, %", 100.0, 2, |found, k| found.impulse[k]),
    Figure("final_force", "final force, %", 100.0, 2, |found, k| found.final_force[k]),
    Figure("peak_force", "peak force, %", 100.0, 2, |found, k| found.peak_force[k]),
];
/// Largest errors of a setting.
const TOTAL: [Figure; 8] = [
    Figure("angle_max_rad", "angle, rad", 1.0, 2, |found, _| Some(found.angle_max())),
    Figure("position_max_m", "position, µm", 1e6, 2, |found, _| Some(found.centre_max())),
    Figure("first_touch_s", "touch, µs", 1e6, 2, |found, _| largest(&found.contact_time_s)),
    Figure("impulse", "impulse, %", 100.0, 2, |found, _| largest(&found.impulse)),
    Figure("final_force", "force, %", 100.0, 2, |found, _| largest(&found.final_force)),
    Figure("peak_force", "peak, %", 100.0, 2, |found, _| largest(&found.peak_force)),
    Figure("loop_gap_m", "gap, µm", 1e6, 2, |found, _| Some(found.loop_gap_m)),
    Figure("energy_created", "energy, %", 100.0, 2, |found, _| Some(found.energy_created)),
];

impl Figure {
    /// Whether scenes of this schema have the figure: final forces only with fingers, peak forces only without.
    fn applies_to(&self, schema: &Schema) -> bool {
        match self.0 {
            "final_force" => !schema.fingers.is_empty(),
            "loop_gap_m" => !schema.joints.is_empty(),
            "position_max_m" => !schema.bodies.is_empty(),
            "peak_force" => schema.fingers.is_empty(),
            _ => true,
        }
    }

    /// Formats the value; a missing value is a dash.
    fn cell(&self, value: Option<f64>) -> String {
        or_dash(value, |value| format_number(value * self.2, self.3))
    }
}

/// Returns the figures that scenes of this schema have, with their values; none has a value without differences.
fn figures<'a>(
    all: &'a [Figure],
    schema: &'a Schema,
    found: Option<&'a Differences>,
    index: usize,
) -> impl Iterator<Item = (&'a Figure, Option<f64>)> {
    let figures = all.iter().filter(|figure| figure.applies_to(schema));
    figures.map(move |figure| (figure, found.and_then(|found| (figure.4)(found, index))))
}

/// The same under their keys.
fn by_key<'a>(figures: impl Iterator<Item = (&'a Figure, Option<f64>)>) -> Named<Option<f64>> {
    figures.map(|(figure, value)| (figure.0.to_string(), value)).collect()
}

/// All differences of a setting, with the names of the components.
#[derive(Clone, Copy, Debug)]
struct NamedDifferences<'a> {
    schema: &'a Schema,
    found: &'a Differences,
}

impl NamedDifferences<'_> {
    /// Names of components with their indices, sorted by name in scenes without fingers.
    fn sorted(&self, names: impl Iterator<Item = String>, first: usize) -> Vec<(String, usize)> {
        let mut names: Vec<_> = names.zip(first..).collect();
        if self.schema.fingers.is_empty() {
            names.sort();
        }
        names
    }

    fn bodies(&self) -> Vec<(String, usize)> {
        self.sorted(self.schema.bodies.iter().cloned(), Angle::ALL.len() * self.schema.fingers.len())
    }

    fn contacts(&self) -> Vec<(String, usize)> {
        self.sorted(self.schema.surfaces().map(|index| self.schema.contacts[index].name.clone()), 0)
    }

    /// Returns the figures of named components as a document.
    fn document(&self, all: &[Figure], names: Vec<(String, usize)>) -> Named<Named<Option<f64>>> {
        let figures = |index| by_key(figures(all, self.schema, Some(self.found), index));
        names.into_iter().map(|(name, index)| (name, figures(index))).collect()
    }

    /// Returns a table for joints, bodies and contacts.
    fn tables(&self) -> Report {
        let joints =
            self.schema.fingers.iter().flat_map(|finger| {
                Angle::ALL.map(|angle| format!("{finger} {}", angle.name()).trim_start().to_string())
            });
        let joints = joints.zip(0..).collect();
        let tables = [(&JOINT[..], joints), (&BODY, self.bodies()), (&CONTACT, self.contacts())];
        Report::join(tables.into_iter().filter(|(_, names)| !names.is_empty()).map(|(all, names)| {
            let figures = |index| figures(all, self.schema, Some(self.found), index);
            let row = |(name, index): &(String, usize)| -> Vec<String> {
                std::iter::once(name.clone()).chain(figures(*index).map(|(figure, value)| figure.cell(value))).collect()
            };
            let headers = figures(names[0].1).map(|(figure, _)| figure.1.to_string());
            let header = std::iter::once("difference".to_string()).chain(headers).collect();
            let occurs = |(_, index): &&(String, usize)| figures(*index).any(|(_, value)| value.is_some());
            table(&std::iter::once(header).chain(names.iter().filter(occurs).map(row)).collect::<Vec<_>>())
        }))
    }
}

impl Serialize for NamedDifferences<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        let joints = |finger: usize| {
            let names = Angle::ALL.iter().map(|angle| angle.name().to_string());
            self.document(&JOINT, names.zip(Angle::ALL.len() * finger..).collect())
        };
        let [bodies, contacts] = [self.document(&BODY, self.bodies()), self.document(&CONTACT, self.contacts())];
        match self.schema.fingers.as_slice() {
            [] => {
                map.serialize_entry("bodies", &bodies)?;
                map.serialize_entry("contacts", &contacts)?;
            }
            [_] => {
                map.serialize_entry("joints", &joints(0))?;
                contacts.iter().try_for_each(|(name, contact)| map.serialize_entry(name, contact))?;
            }
            fingers => {
                let fingers: Named<_> = fingers.iter().cloned().zip((0..).map(joints)).collect();
                map.serialize_entry("fingers", &fingers)?;
                map.serialize_entry("object", &bodies.first())?;
                map.serialize_entry("contacts", &contacts)?;
            }
        }
        if !self.schema.joints.is_empty() {
            map.serialize_entry("loop_gap_m", &self.found.loop_gap_m)?;
        }
        map.serialize_entry("energy_created_j", &self.found.energy_created_j)?;
        map.serialize_entry("energy_created", &self.found.energy_created)?;
        map.end()
    }
}

/// Columns of the time series of a single finger, in their order.
const FINGER_COLUMNS: &str = "q11_rad q21_rad q22_rad qd11_rad_s qd21_rad_s qd22_rad_s proximal_gap_m distal_gap_m \
                              proximal_normal_n distal_normal_n proximal_tangential_n distal_tangential_n \
                              limit_torque_n_m kinetic_j balance_j";

/// Writes both runs at every multiple of the scene's log interval and at the end.
///
/// Each quantity in SI units has two columns, with the suffixes `_analytic` and `_engine`. A finger has angles, rates, gaps,
/// forces and energies; other scenes have all quantities of a sample. Quantities of a contact without an object are empty.
pub(crate) fn write_series(out: &mut impl Write, scene: &Scene, [analytic, engine]: [&Recording; 2]) -> io::Result<()> {
    let is_finger = scene.finger_count() == 1;
    // The first column is the time.
    let all = Schema::from_scene(scene).channels().into_iter().skip(1);
    let position = |column: &Channel| FINGER_COLUMNS.split(' ').position(|name| name == column.name);
    let mut all: Vec<Channel> = all.filter(|column| !is_finger || position(column).is_some()).collect();
    if is_finger {
        all.sort_by_key(position);
    }
    let headers = all.iter().map(|Channel { name, .. }| format!(",{name}_analytic,{name}_engine"));
    writeln!(out, "time_s{}", headers.collect::<String>())?;
    let (numeric_hz, end_s) = (scene.log.numeric_hz, analytic.outcome.last.time_s);
    let mut cursors = [0, 0];
    for index in 0_u64.. {
        let time_s = (index as f64 / numeric_hz).min(end_s);
        let samples = (analytic.interpolate(time_s, &mut cursors[0]), engine.interpolate(time_s, &mut cursors[1]));
        let (Some(analytic), Some(engine)) = samples else { break };
        write!(out, "{time_s:?}")?;
        for column in &all {
            write!(out, ",{},{}", cell(column.value(&analytic)), cell(column.value(&engine)))?;
        }
        writeln!(out)?;
        if time_s >= end_s {
            break;
        }
    }
    Ok(())
}
