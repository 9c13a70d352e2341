//! Rows, columns and summary of sweep results.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use phalanx_show::format::object::Named;
use serde::Serialize;

use super::Study;
use super::axis::{Field, FieldType, column_kind};
use super::figures::hand_columns;
use crate::criteria::{Class, Fate};
use crate::scene::keywords::SceneKind;
use crate::scene::schema::schema_for;
use crate::table::{Column, Kind, Table, TableError, Value};
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

/// One row of the results. It contains a verdict (the class of a finger, or the fate of a grasp by a gripper) or a
/// reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub run: u64,
    pub status: Status,
    /// One value per column; see [`columns`].
    pub cells: Vec<Value>,
}

/// Returns the type of a result column. It depends on the name of the column, or on the unit at the end of the name.
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

/// Returns the type of a result column, or of the column of a scene field; `None` for other columns.
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

/// Returns the rows as a table sorted by run. If several rows have the same run, only the first one is used.
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

    /// Sets a result, unless its column is not selected. A number that is not finite is stored as missing.
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
    /// Completed runs of fingers by dynamic class, from best to worst. For other scenes, completed runs by the fate of
    /// the grasp. Empty if there is neither.
    pub by_class: Named<u64>,
    /// Number of completed runs without a class, because the finger cannot grasp its object; `reasons` contains the
    /// reasons.
    pub no_class: u64,
    /// Reasons of runs that were not completed or have no class. Those with the same status and a text that differs
    /// only in numbers are grouped.
    pub reasons: Vec<Reason>,
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Reason {
    pub status: String,
    /// Text of the first of these runs. The texts of the others differ only in numbers.
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
