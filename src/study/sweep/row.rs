//! Rows and columns of sweep results.

use std::collections::BTreeMap;

use super::Study;
use super::field::{Field, FieldType, column_kind};
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

/// Names of the result columns, in order.
fn result_columns(kind: SceneKind) -> impl Iterator<Item = &'static str> {
    if kind == SceneKind::Gripper { GRIPPER_COLUMNS } else { FINGER_COLUMNS }.split(' ')
}

/// Type of a result column: that of its name, or the unit at the end of the name.
fn result_type(name: &str) -> FieldType {
    match name {
        "status" | "reason" | "grasp" | "class" | "class_reason" | "check" => FieldType::Text,
        "force_positive" | "form_closed" => FieldType::Flag,
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
    let is_result = SceneKind::ALL.into_iter().flat_map(result_columns).any(|name| name == column);
    let field = || SceneKind::ALL.into_iter().find_map(|kind| Field::from_column(column, schema_for(kind)));
    if is_result { Some(result_type(column)) } else { field().map(|field| field.field_type) }
}

/// Columns of the results of a study: `run`, `design`, the axes, and the result columns.
pub fn columns(study: &Study) -> Vec<Column> {
    let numbers = ["run", "design"].map(|name| Column::new(name, Kind::Integer)).into_iter();
    let fields = study.axes.iter().flat_map(|axis| &axis.fields);
    let axes = fields.map(|field| Column::new(field.column(), column_kind(&field.field_type)));
    let results = result_columns(study.kind).map(|name| Column::new(name, column_kind(&result_type(name))));
    numbers.chain(axes).chain(results).collect()
}

/// Results as a table sorted by run.
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
    cells: Vec<Value>,
    /// Index of the first result.
    first: usize,
    kind: SceneKind,
}

impl Cells {
    /// Starts a row with the numbers of run and design and the values of the axes.
    pub fn new(kind: SceneKind, first: impl Iterator<Item = Value>) -> Self {
        let mut cells: Vec<Value> = first.collect();
        let first = cells.len();
        cells.extend(result_columns(kind).map(|_| Value::Missing));
        Cells { cells, first, kind }
    }

    /// Sets a result; a number that is not finite becomes missing.
    pub fn set(&mut self, name: &str, value: impl Into<Value>) {
        let index = result_columns(self.kind).position(|column| column == name);
        debug_assert!(index.is_some(), "{name}");
        if let Some(cell) = index.and_then(|index| self.cells.get_mut(self.first + index)) {
            *cell = match value.into() {
                Value::Number(number) if !number.is_finite() => Value::Missing,
                value => value,
            };
        }
    }

    /// Finishes the row.
    pub fn row(mut self, run: u64, status: Status, reason: &str) -> Row {
        self.set("status", status.name());
        // A row must be a single line of the partial file.
        let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        self.set("reason", Some(reason).filter(|reason| !reason.is_empty()));
        Row { run, status, cells: self.cells }
    }
}
