//! Rows, columns and summary of sweep results.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::{Arc, LazyLock};

use phalanx_show::format::object::Named;
use serde::Serialize;

use super::Study;
use super::axis::{Field, FieldType, column_kind};
use super::figures::{Extrema, SceneFigures};
use crate::criteria::{Class, Fate};
use crate::scene::Scene;
use crate::scene::keywords::SceneKind;
use crate::scene::schema::schema_for;
use crate::table::{Column, Kind, Table, TableError, Value};
use crate::trace::{Channel, Schema};
use crate::units::Dimension;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Simulated to the end.
    Completed,
    /// Not simulated, excluded by the filter.
    Filtered,
    /// The scene is invalid.
    Refused,
    /// The simulation did not finish.
    Failed,
}

impl Status {
    pub const ALL: [Status; 4] = [Status::Completed, Status::Filtered, Status::Refused, Status::Failed];

    /// Name in results and reports.
    pub fn name(self) -> &'static str {
        ["completed", "filtered", "refused", "failed"][self as usize]
    }
}

/// One row of the results. A row has a verdict (the class of a finger, or the fate of a grasp by a gripper) or a
/// reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub run: u64,
    pub status: Status,
    /// One value per column, see [`columns`].
    pub cells: Vec<Value>,
}

/// Result columns of fingers, after the columns of the axes: dimensions, statics, class and forces.
const FINGER_COLUMNS: &str = "l12_m l21_m l22_m t22_m mass_kg trajectory_rad motor_n_m spring_n_m static_f21_n static_f22_n \
     static_pfp_n force_positive form_closed status reason t_geo_s tts_s rebound_percent class class_reason f21_n f22_n pfp_n \
     peak_f21_n peak_f22_n steps check check_error_rad";

/// Result columns of grippers: dimensions, forces and torques of both fingers, fate and final position of the object.
const GRIPPER_COLUMNS: &str = "palm_width_m right_l21_m left_l21_m right_motor_n_m left_motor_n_m right_spring_n_m left_spring_n_m \
     status reason grasp grasped_s tts_s until_s form_closed x_start_m x_m y_m angle_rad offset_ratio speed_m_s slip_m slip_rad \
     contacts_lost link_overlap_m right_proximal_first_s left_proximal_first_s right_distal_first_s left_distal_first_s \
     right_proximal_n right_distal_n left_proximal_n left_distal_n palm_n table_n peak_right_proximal_n peak_right_distal_n \
     peak_left_proximal_n peak_left_distal_n peak_palm_n steps check check_error_rad";

/// Names of the result columns of fingers and of grippers, in order.
fn hand_columns(fingers: usize) -> &'static [&'static str] {
    static COLUMNS: LazyLock<[Vec<&str>; 2]> =
        LazyLock::new(|| [FINGER_COLUMNS, GRIPPER_COLUMNS].map(|names| names.split(' ').collect()));
    &COLUMNS[usize::from(fingers == 2)]
}

/// Result columns of any scene before and after its figures.
const BEFORE: [&str; 2] = ["status", "reason"];
const AFTER: [&str; 3] = ["steps", "check", "check_error_rad"];

/// What the runs of a study have in common, and the names of its result columns.
#[derive(Clone, Debug)]
pub(super) enum Figures {
    /// Of this number of five-bar fingers.
    Hand(usize),
    /// Of a scene of any other kind.
    Scene(Box<SceneFigures>),
}

/// The result columns of a study.
#[derive(Clone, Debug)]
pub(super) struct Results {
    pub figures: Figures,
    /// Channels whose least and largest values are columns.
    pub extrema: Vec<Channel>,
    /// Names of the columns, in order.
    names: Arc<[String]>,
}

impl Results {
    /// Returns the columns of the studies of a scene, of `only` these figures unless it is empty, and of the `extrema` of these
    /// channels.
    ///
    /// # Errors
    /// Returns an unknown figure or channel, with all names.
    pub fn of(scene: &Scene, only: &[String], extrema: &[String]) -> Result<Self, UnknownFigure> {
        let figures = match scene.finger_count() {
            0 => Figures::Scene(Box::new(SceneFigures::of(scene))),
            fingers => Figures::Hand(fingers),
        };
        let channels = if extrema.is_empty() { Vec::new() } else { Schema::from_scene(scene).channels() };
        let channel = |(index, name): (usize, &String)| {
            let known = channels.iter().find(|channel| channel.name == *name).cloned();
            let names = || channels.iter().map(|channel| channel.name.clone()).collect();
            known.ok_or_else(|| UnknownFigure { key: "extrema", index, name: name.clone(), known: names() })
        };
        let extrema = extrema.iter().enumerate().map(channel).collect::<Result<Vec<Channel>, _>>()?;
        let of_extrema = extrema.iter().flat_map(|channel| Extrema::columns(&channel.name));
        let names: Vec<String> = match &figures {
            Figures::Hand(fingers) => {
                hand_columns(*fingers).iter().map(ToString::to_string).chain(of_extrema).collect()
            }
            Figures::Scene(scene) => {
                let before = BEFORE.into_iter().chain(scene.names()).map(String::from);
                before.chain(of_extrema).chain(AFTER.map(String::from)).collect()
            }
        };
        if let Some((index, name)) = only.iter().enumerate().find(|(_, name)| !names.contains(name)) {
            return Err(UnknownFigure { key: "columns", index, name: name.clone(), known: names });
        }
        let is_common = |name: &str| BEFORE.contains(&name) || AFTER.contains(&name);
        let is_extremum = |name: &str| {
            extrema.iter().any(|channel| Extrema::columns(&channel.name).iter().any(|column| column == name))
        };
        let is_selected =
            |name: &String| only.is_empty() || only.contains(name) || is_common(name) || is_extremum(name);
        let names = names.into_iter().filter(is_selected).collect();
        Ok(Results { figures, extrema, names })
    }

    /// Removes the columns that the fields of the axes have already.
    pub fn without(mut self, fields: &[String]) -> Self {
        self.names = self.names.iter().filter(|name| !fields.contains(name)).cloned().collect();
        self
    }

    /// The result columns of a hand, without extrema.
    pub fn of_hand(fingers: usize) -> Self {
        let names = hand_columns(fingers).iter().map(ToString::to_string).collect();
        Results { figures: Figures::Hand(fingers), extrema: Vec::new(), names }
    }
}

/// An unknown name in `[results]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct UnknownFigure {
    pub key: &'static str,
    /// Index in its list.
    pub index: usize,
    pub name: String,
    pub known: Vec<String>,
}

/// Type of a result column: that of its name, or the unit at the end of the name.
pub fn result_type(name: &str) -> FieldType {
    match name {
        "status" | "reason" | "grasp" | "fate" | "fate_reason" | "class" | "class_reason" | "check" => FieldType::Text,
        "force_positive" | "form_closed" => FieldType::Flag,
        "rebound_percent" => FieldType::Percent,
        "steps" | "contacts_lost" => FieldType::Integer(0, i64::MAX),
        _ => {
            let has_unit = |dimension: &Dimension| {
                name.strip_suffix(dimension.suffix()).is_some_and(|quantity| quantity.ends_with('_'))
            };
            let longest = Dimension::ALL.into_iter().filter(has_unit).max_by_key(|dimension| dimension.suffix().len());
            longest.map_or(FieldType::Number, FieldType::Quantity)
        }
    }
}

/// Type of a result column or of the column of a scene field; `None` for any other column.
pub fn column_type(column: &str) -> Option<FieldType> {
    if [1, 2].into_iter().any(|fingers| hand_columns(fingers).contains(&column)) {
        return Some(result_type(column));
    }
    // Only the base scene knows the dimension of a parameter; its column has the suffix of the unit.
    if column.starts_with("parameters.") {
        return Some(result_type(column));
    }
    let mut fields = SceneKind::ALL.into_iter().filter_map(|kind| Field::from_column(column, schema_for(kind)));
    fields.next().map(|field| field.field_type)
}

/// Columns of the results of a study: `run`, `design`, the axes, and the result columns.
pub fn columns(study: &Study) -> Vec<Column> {
    let numbers = ["run", "design"].map(|name| Column::new(name, Kind::Integer)).into_iter();
    let fields = study.axes.iter().flat_map(|axis| &axis.fields);
    let axes = fields.map(|field| Column::new(field.column(), column_kind(&field.field_type)));
    let results = study.results.names.iter().map(|name| Column::new(name.clone(), column_kind(&result_type(name))));
    numbers.chain(axes).chain(results).collect()
}

pub fn table(study: &Study, rows: &[Row]) -> Table {
    sorted_table(study, rows.iter().map(|row| row.cells.clone()))
}

/// Rows as a table sorted by run; only the first row of each run is used.
pub fn sorted_table(study: &Study, rows: impl IntoIterator<Item = Vec<Value>>) -> Table {
    let mut by_run = BTreeMap::new();
    for row in rows {
        if let Some(run) = row.first().and_then(Value::as_integer) {
            by_run.entry(run).or_insert(row);
        }
    }
    Table::new(columns(study), by_run.into_values().collect())
}

/// Builder of a row, whose cells are set by column name.
pub(super) struct Cells {
    run: u64,
    /// Run, design and values of the axes, then the results.
    cells: Vec<Value>,
    names: Arc<[String]>,
}

impl Cells {
    /// Starts the row of a run, without results.
    pub fn new(study: &Study, run: u64, axes: impl Iterator<Item = Value>) -> Self {
        let names = Arc::clone(&study.results.names);
        let numbers = [run, study.design(run)].map(|number| Value::Integer(number as i64));
        let results = names.iter().map(|_| Value::Missing);
        Cells { run, cells: numbers.into_iter().chain(axes).chain(results).collect(), names }
    }

    /// Sets a result, unless its column is not selected; a number that is not finite becomes missing.
    pub fn set(&mut self, name: &str, value: impl Into<Value>) {
        let value = match value.into() {
            Value::Number(number) if !number.is_finite() => Value::Missing,
            value => value,
        };
        self.set_exactly(name, value);
    }

    /// Sets a result that may be infinite, unless its column is not selected.
    pub fn set_exactly(&mut self, name: &str, value: Value) {
        let index = self.names.iter().position(|column| column == name);
        let first = self.cells.len() - self.names.len();
        if let Some(cell) = index.and_then(|index| self.cells.get_mut(first + index)) {
            *cell = value;
        }
    }

    /// Sets several results of one type.
    pub fn set_all<const N: usize>(&mut self, values: [(&str, impl Into<Value>); N]) {
        values.into_iter().for_each(|(name, value)| self.set(name, value));
    }

    pub fn row(mut self, status: Status, reason: &str) -> Row {
        self.set("status", status.name());
        // A row must be a single line of the partial file.
        let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        self.set("reason", Some(reason).filter(|reason| !reason.is_empty()));
        Row { run: self.run, status, cells: self.cells }
    }
}

/// Counts of the rows of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    pub runs: u64,
    /// Runs by status, in the order of [`Status::ALL`].
    pub by_status: Named<u64>,
    /// Completed runs of fingers by dynamic class from best to worst; of others by the fate of the grasp; empty without both.
    pub by_class: Named<u64>,
    /// Completed runs without a class, because the finger cannot grasp its object. `reasons` contains the reasons.
    pub no_class: u64,
    /// Reasons of runs that were not completed or have no class, grouped by status and text without numbers.
    pub reasons: Vec<Reason>,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Reason {
    pub status: String,
    /// Text of the first of these runs; the others differ in numbers only.
    pub reason: String,
    pub runs: u64,
    pub first_run: u64,
}

impl Reason {
    /// Reason of a single run.
    pub(in crate::study) fn of_run(run: i64, status: &str, reason: &str) -> Self {
        Reason { status: status.to_string(), reason: reason.to_string(), runs: 1, first_run: run.unsigned_abs() }
    }
}

impl Summary {
    pub fn count_with_status(&self, status: Status) -> u64 {
        self.by_status.get(status.name()).copied().unwrap_or(0)
    }

    /// Adds the counts of later rows of the same study.
    pub(in crate::study) fn add(&mut self, other: Summary) {
        self.runs += other.runs;
        self.no_class += other.no_class;
        for (counts, more) in [(&mut self.by_status, other.by_status), (&mut self.by_class, other.by_class)] {
            counts.0.iter_mut().zip(more.0).for_each(|((_, count), (_, more))| *count += more);
        }
        let reasons = std::mem::take(&mut self.reasons).into_iter().chain(other.reasons);
        self.reasons = group_reasons(&Status::ALL.map(Status::name), reasons);
    }
}

pub fn summary(table: &Table) -> Result<Summary, TableError> {
    let (runs, status) = (table.integers("run")?, table.texts("status")?);
    let has_column = |name: &str| table.columns.iter().any(|column| column.name == name);
    let (class, classes) = match ["grasp", "fate", "class"].into_iter().find(|name| has_column(name)) {
        Some("class") => (table.texts("class")?, Class::ALL.map(Class::name).to_vec()),
        Some(fate) => (table.texts(fate)?, Fate::NAMES.to_vec()),
        // A scene without a grasp, or a study without this column.
        None => (Vec::new(), Vec::new()),
    };
    let reason = table.texts("reason")?;
    let count = |column: &[Option<&str>], names: &[&str]| {
        let count = |name| column.iter().filter(|cell| **cell == Some(name)).count() as u64;
        names.iter().map(|name| (name.to_string(), count(name))).collect()
    };
    let statuses = Status::ALL.map(Status::name);
    let rows = runs.iter().zip(&status).zip(&reason);
    let reasons = rows.filter_map(|((run, status), reason)| Some(Reason::of_run((*run)?, (*status)?, (*reason)?)));
    let no_class = status.iter().zip(&class).filter(|(status, class)| **status == Some(statuses[0]) && class.is_none());
    Ok(Summary {
        runs: table.rows.len() as u64,
        by_status: count(&status, &statuses),
        by_class: count(&class, &classes),
        no_class: no_class.count() as u64,
        reasons: group_reasons(&statuses, reasons),
    })
}

/// Groups reasons by status and text without numbers. The groups are in the given order of the statuses, and the most
/// frequent ones of a status come first.
pub(in crate::study) fn group_reasons(statuses: &[&str], reasons: impl Iterator<Item = Reason>) -> Vec<Reason> {
    let mut groups: BTreeMap<(String, String), Reason> = BTreeMap::new();
    for reason in reasons {
        match groups.entry((reason.status.clone(), without_numbers(&reason.reason))) {
            Entry::Vacant(group) => _ = group.insert(reason),
            Entry::Occupied(mut group) => group.get_mut().runs += reason.runs,
        }
    }
    let mut groups: Vec<Reason> = groups.into_values().collect();
    let rank = |name: &str| statuses.iter().position(|status| *status == name);
    groups.sort_by_key(|group| (rank(&group.status), Reverse(group.runs), group.first_run));
    groups
}

/// Replaces words with digits by `#`, so that reasons that differ only in numbers are equal.
fn without_numbers(reason: &str) -> String {
    let is_numeric = |word: &&str| word.contains(|c: char| c.is_ascii_digit()) && !word.starts_with('`');
    let words = reason.split_whitespace().map(|word| if is_numeric(&word) { "#" } else { word });
    words.collect::<Vec<_>>().join(" ")
}
