//! Rows and columns of the results.

use std::collections::BTreeMap;

use super::Study;
use super::field::{Field, Holds};
use crate::scene::schema::schema_of;
use crate::scene::words::SceneKind;
use crate::table::{Column, Kind, Table, Value};
use crate::units::Dimension;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Simulated to the end.
    Completed,
    /// Not simulated, because of its statics.
    Filtered,
    /// The scene is not valid.
    Refused,
    /// The simulation did not come to its end.
    Failed,
}

impl Status {
    pub const ALL: [Status; 4] = [Status::Completed, Status::Filtered, Status::Refused, Status::Failed];

    /// In results and reports.
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
    /// Whether it has a verdict: a class, or of a gripper what became of the grasp. A run that was not completed has none, and a
    /// finger that cannot grasp its object has none.
    pub judged: bool,
    /// A value for each of [`columns`].
    pub cells: Vec<Value>,
}

/// Columns after those of the axes, in order.
pub(in crate::study) fn found(kind: SceneKind) -> &'static [(&'static str, Holds)] {
    if kind == SceneKind::Gripper { &OF_GRIPPER } else { &OF_FINGER }
}

const LENGTH: Holds = Holds::Quantity(Dimension::Length);
const ANGLE: Holds = Holds::Quantity(Dimension::Angle);
const TIME: Holds = Holds::Quantity(Dimension::Time);
const MASS: Holds = Holds::Quantity(Dimension::Mass);
const FORCE: Holds = Holds::Quantity(Dimension::Force);
const TORQUE: Holds = Holds::Quantity(Dimension::Torque);
const SPEED: Holds = Holds::Quantity(Dimension::Speed);

/// Of grippers: lengths and forces of both fingers, what became of the object and where it is.
static OF_GRIPPER: [(&str, Holds); 42] = [
    ("palm_width_m", LENGTH),
    ("right_l21_m", LENGTH),
    ("left_l21_m", LENGTH),
    ("right_motor_n_m", TORQUE),
    ("left_motor_n_m", TORQUE),
    ("right_spring_n_m", TORQUE),
    ("left_spring_n_m", TORQUE),
    ("status", Holds::Text),
    ("reason", Holds::Text),
    ("grasp", Holds::Text),
    ("grasped_s", TIME),
    ("tts_s", TIME),
    ("until_s", TIME),
    ("form_closed", Holds::Flag),
    ("x_start_m", LENGTH),
    ("x_m", LENGTH),
    ("y_m", LENGTH),
    ("angle_rad", ANGLE),
    ("offset_ratio", Holds::Number),
    ("speed_m_s", SPEED),
    ("slip_m", LENGTH),
    ("slip_rad", ANGLE),
    ("contacts_lost", Holds::Whole(0, i64::MAX)),
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
    ("steps", Holds::Whole(0, i64::MAX)),
    ("check", Holds::Text),
    ("check_error_rad", ANGLE),
];

static OF_FINGER: [(&str, Holds); 28] = [
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
    ("force_positive", Holds::Flag),
    ("form_closed", Holds::Flag),
    ("status", Holds::Text),
    ("reason", Holds::Text),
    ("t_geo_s", TIME),
    ("tts_s", TIME),
    ("rebound_percent", Holds::Percent),
    ("class", Holds::Text),
    ("class_reason", Holds::Text),
    ("f21_n", FORCE),
    ("f22_n", FORCE),
    ("pfp_n", FORCE),
    ("peak_f21_n", FORCE),
    ("peak_f22_n", FORCE),
    ("steps", Holds::Whole(0, i64::MAX)),
    ("check", Holds::Text),
    ("check_error_rad", ANGLE),
];

/// The column of the verdict.
pub(super) fn verdict_column(kind: SceneKind) -> &'static str {
    if kind == SceneKind::Gripper { "grasp" } else { "class" }
}

impl Row {
    /// The row of these cells, as they were written.
    pub(in crate::study) fn of_cells(kind: SceneKind, cells: Vec<Value>) -> Row {
        let text = |name: &str| match cells.get(place(kind, cells.len(), name)?)? {
            Value::Text(text) => Some(text.as_str()),
            _ => None,
        };
        let status = Status::ALL.into_iter().find(|status| text("status") == Some(status.name()));
        let run = match cells.first() {
            Some(Value::Integer(run)) => u64::try_from(*run).unwrap_or(0),
            _ => 0,
        };
        Row { run, status: status.unwrap_or(Status::Refused), judged: text(verdict_column(kind)).is_some(), cells }
    }
}

/// Where a found column stands in a row of so many cells.
fn place(kind: SceneKind, cells: usize, name: &str) -> Option<usize> {
    let found = found(kind);
    Some(cells.checked_sub(found.len())? + found.iter().position(|(column, _)| *column == name)?)
}

/// What a column of results holds: one of every study's, or of a field that varies; `None` of any other column.
pub fn held_by(column: &str) -> Option<Holds> {
    let kinds = SceneKind::ALL;
    let own = kinds.into_iter().flat_map(found).find(|(name, _)| *name == column).map(|(_, holds)| holds.clone());
    own.or_else(|| Some(kinds.into_iter().find_map(|kind| Field::of_column(column, schema_of(kind)))?.holds))
}

/// The columns of a study's results: `run`, `design`, the axes, and what is found.
pub fn columns(study: &Study) -> Vec<Column> {
    let first = [Column::new("run", Kind::Integer), Column::new("design", Kind::Integer)];
    let axes =
        study.axes.iter().flat_map(|axis| &axis.fields).map(|field| Column::new(field.column(), field.holds.kind()));
    let found = found(study.kind).iter().map(|(name, holds)| Column::new(*name, holds.kind()));
    first.into_iter().chain(axes).chain(found).collect()
}

/// The results as a table, by run.
pub fn table(study: &Study, rows: &[Row]) -> Table {
    sorted(study, rows.iter().map(|row| row.cells.clone()))
}

/// Rows of cells as a table, by run; of a run that is there twice, the first.
pub fn sorted(study: &Study, rows: impl IntoIterator<Item = Vec<Value>>) -> Table {
    let mut by_run = BTreeMap::new();
    for row in rows {
        if let Some(Value::Integer(run)) = row.first() {
            by_run.entry(*run).or_insert(row);
        }
    }
    Table::new(columns(study), by_run.into_values().collect())
}

/// The cells of a row, named while it is made.
pub(super) struct Cells {
    cells: Vec<Value>,
    kind: SceneKind,
}

impl Cells {
    pub fn new(kind: SceneKind, first: Vec<Value>) -> Self {
        let mut cells = first;
        cells.resize(cells.len() + found(kind).len(), Value::Missing);
        Cells { cells, kind }
    }

    /// Sets what was found; numbers that are not finite are missing.
    pub fn set(&mut self, name: &str, value: impl Into<Value>) {
        let value = match value.into() {
            Value::Number(number) if !number.is_finite() => Value::Missing,
            value => value,
        };
        let place = place(self.kind, self.cells.len(), name);
        debug_assert!(place.is_some(), "{name}");
        if let Some(place) = place {
            self.cells[place] = value;
        }
    }

    pub fn row(mut self, run: u64, status: Status, reason: &str) -> Row {
        self.set("status", status.name());
        // One row is one line of the file that grows.
        let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        let reason = Some(reason).filter(|reason| !reason.is_empty());
        let has_reason = reason.is_some();
        self.set("reason", reason);
        let row = Row { run, ..Row::of_cells(self.kind, self.cells) };
        debug_assert!(row.judged || has_reason, "run {run} has neither a verdict nor a reason");
        row
    }
}
