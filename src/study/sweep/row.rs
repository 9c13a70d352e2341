//! Rows and columns of sweep results.

use std::collections::BTreeMap;

use super::Study;
use super::field::{Field, FieldType};
use crate::scene::keywords::SceneKind;
use crate::scene::schema::schema_for;
use crate::table::{Column, Kind, Table, Value};
use crate::units::Dimension;

/// How a run ended.
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
        match self {
            Status::Completed => "completed",
            Status::Filtered => "filtered",
            Status::Refused => "refused",
            Status::Failed => "failed",
        }
    }
}

/// One row of the results. A row without a verdict has a reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub run: u64,
    pub status: Status,
    /// Whether the row has a verdict: the class of a finger, or the fate of a grasp by a gripper. Incomplete runs and
    /// fingers that cannot grasp their object have none.
    pub has_verdict: bool,
    /// One value per column, see [`columns`].
    pub cells: Vec<Value>,
}

/// Result columns that follow the columns of the axes, in order.
pub(in crate::study) fn result_columns(kind: SceneKind) -> &'static [(&'static str, FieldType)] {
    if kind == SceneKind::Gripper { &GRIPPER_COLUMNS } else { &FINGER_COLUMNS }
}

const LENGTH: FieldType = FieldType::Quantity(Dimension::Length);
const ANGLE: FieldType = FieldType::Quantity(Dimension::Angle);
const TIME: FieldType = FieldType::Quantity(Dimension::Time);
const MASS: FieldType = FieldType::Quantity(Dimension::Mass);
const FORCE: FieldType = FieldType::Quantity(Dimension::Force);
const TORQUE: FieldType = FieldType::Quantity(Dimension::Torque);
const SPEED: FieldType = FieldType::Quantity(Dimension::Speed);

/// Result columns of grippers: dimensions, forces and torques of both fingers, fate and final position of the object.
static GRIPPER_COLUMNS: [(&str, FieldType); 42] = [
    ("palm_width_m", LENGTH),
    ("right_l21_m", LENGTH),
    ("left_l21_m", LENGTH),
    ("right_motor_n_m", TORQUE),
    ("left_motor_n_m", TORQUE),
    ("right_spring_n_m", TORQUE),
    ("left_spring_n_m", TORQUE),
    ("status", FieldType::Text),
    ("reason", FieldType::Text),
    ("grasp", FieldType::Text),
    ("grasped_s", TIME),
    ("tts_s", TIME),
    ("until_s", TIME),
    ("form_closed", FieldType::Flag),
    ("x_start_m", LENGTH),
    ("x_m", LENGTH),
    ("y_m", LENGTH),
    ("angle_rad", ANGLE),
    ("offset_ratio", FieldType::Number),
    ("speed_m_s", SPEED),
    ("slip_m", LENGTH),
    ("slip_rad", ANGLE),
    ("contacts_lost", FieldType::Integer(0, i64::MAX)),
    ("link_overlap_m", LENGTH),
    ("right_proximal_first_s", TIME),
    ("left_proximal_first_s", TIME),
    ("right_distal_first_s", TIME),
    ("left_distal_first_s", TIME),
    ("right_proximal_n", FORCE),
    ("right_distal_n", FORCE),
    ("left_proximal_n", FORCE),
    ("left_distal_n", FORCE),
    ("palm_n", FORCE),
    ("table_n", FORCE),
    ("peak_right_proximal_n", FORCE),
    ("peak_right_distal_n", FORCE),
    ("peak_left_proximal_n", FORCE),
    ("peak_left_distal_n", FORCE),
    ("peak_palm_n", FORCE),
    ("steps", FieldType::Integer(0, i64::MAX)),
    ("check", FieldType::Text),
    ("check_error_rad", ANGLE),
];

/// Result columns of fingers: dimensions, statics, class and forces.
static FINGER_COLUMNS: [(&str, FieldType); 28] = [
    ("l12_m", LENGTH),
    ("l21_m", LENGTH),
    ("l22_m", LENGTH),
    ("t22_m", LENGTH),
    ("mass_kg", MASS),
    ("trajectory_rad", ANGLE),
    ("motor_n_m", TORQUE),
    ("spring_n_m", TORQUE),
    ("static_f21_n", FORCE),
    ("static_f22_n", FORCE),
    ("static_pfp_n", FORCE),
    ("force_positive", FieldType::Flag),
    ("form_closed", FieldType::Flag),
    ("status", FieldType::Text),
    ("reason", FieldType::Text),
    ("t_geo_s", TIME),
    ("tts_s", TIME),
    ("rebound_percent", FieldType::Percent),
    ("class", FieldType::Text),
    ("class_reason", FieldType::Text),
    ("f21_n", FORCE),
    ("f22_n", FORCE),
    ("pfp_n", FORCE),
    ("peak_f21_n", FORCE),
    ("peak_f22_n", FORCE),
    ("steps", FieldType::Integer(0, i64::MAX)),
    ("check", FieldType::Text),
    ("check_error_rad", ANGLE),
];

/// Name of the verdict column.
pub(super) fn verdict_column(kind: SceneKind) -> &'static str {
    if kind == SceneKind::Gripper { "grasp" } else { "class" }
}

impl Row {
    /// Rebuilds a row from stored cells.
    pub(in crate::study) fn from_cells(kind: SceneKind, cells: Vec<Value>) -> Row {
        let text = |name: &str| match cells.get(column_index(kind, cells.len(), name)?)? {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        };
        let status = Status::ALL.into_iter().find(|status| text("status") == Some(status.name()));
        let run = match cells.first() {
            Some(Value::Integer(run)) => u64::try_from(*run).unwrap_or(0),
            _ => 0,
        };
        Row { run, status: status.unwrap_or(Status::Refused), has_verdict: text(verdict_column(kind)).is_some(), cells }
    }
}

/// Index of a result column in a row of `cell_count` cells. The result columns are the last cells.
fn column_index(kind: SceneKind, cell_count: usize, name: &str) -> Option<usize> {
    let columns = result_columns(kind);
    Some(cell_count.checked_sub(columns.len())? + columns.iter().position(|(column, _)| *column == name)?)
}

/// Type of a result column or of the column of a scene field; `None` for any other column.
pub fn column_type(column: &str) -> Option<FieldType> {
    let kinds = SceneKind::ALL;
    let result_type = kinds
        .into_iter()
        .flat_map(result_columns)
        .find(|(name, _)| *name == column)
        .map(|(_, field_type)| field_type.clone());
    result_type
        .or_else(|| Some(kinds.into_iter().find_map(|kind| Field::from_column(column, schema_for(kind)))?.field_type))
}

/// Columns of the results of a study: `run`, `design`, the axes, and the result columns.
pub fn columns(study: &Study) -> Vec<Column> {
    let first = [Column::new("run", Kind::Integer), Column::new("design", Kind::Integer)];
    let axes = study
        .axes
        .iter()
        .flat_map(|axis| &axis.fields)
        .map(|field| Column::new(field.column(), field.field_type.column_kind()));
    let results =
        result_columns(study.kind).iter().map(|(name, field_type)| Column::new(*name, field_type.column_kind()));
    first.into_iter().chain(axes).chain(results).collect()
}

/// Results as a table sorted by run.
pub fn table(study: &Study, rows: &[Row]) -> Table {
    sorted_table(study, rows.iter().map(|row| row.cells.clone()))
}

/// Rows as a table sorted by run; only the first row of each run is used.
pub fn sorted_table(study: &Study, rows: impl IntoIterator<Item = Vec<Value>>) -> Table {
    let mut by_run = BTreeMap::new();
    for row in rows {
        if let Some(Value::Integer(run)) = row.first() {
            by_run.entry(*run).or_insert(row);
        }
    }
    Table::new(columns(study), by_run.into_values().collect())
}

/// Builder of a row, whose cells are set by column name.
pub(super) struct Cells {
    cells: Vec<Value>,
    kind: SceneKind,
}

impl Cells {
    /// Starts a row with the numbers of run and design and the values of the axes.
    pub fn new(kind: SceneKind, first: Vec<Value>) -> Self {
        let mut cells = first;
        cells.resize(cells.len() + result_columns(kind).len(), Value::Missing);
        Cells { cells, kind }
    }

    /// Sets a result; a number that is not finite becomes missing.
    pub fn set(&mut self, name: &str, value: impl Into<Value>) {
        let value = match value.into() {
            Value::Number(number) if !number.is_finite() => Value::Missing,
            value => value,
        };
        let index = column_index(self.kind, self.cells.len(), name);
        debug_assert!(index.is_some(), "{name}");
        if let Some(index) = index {
            self.cells[index] = value;
        }
    }

    /// Finishes the row.
    pub fn row(mut self, run: u64, status: Status, reason: &str) -> Row {
        self.set("status", status.name());
        // A row must be a single line of the partial file.
        let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        let reason = Some(reason).filter(|reason| !reason.is_empty());
        let has_reason = reason.is_some();
        self.set("reason", reason);
        let row = Row { run, ..Row::from_cells(self.kind, self.cells) };
        debug_assert!(row.has_verdict || has_reason, "run {run} has neither a verdict nor a reason");
        row
    }
}
