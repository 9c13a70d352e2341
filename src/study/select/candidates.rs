//! Reads runs, axes and conditions from a table of results.

use std::collections::{HashMap, HashSet};

use super::SelectError;
use super::classes::CLASSES;
use crate::criteria::Class;
use crate::study::sweep::Status;
use crate::table::{Table, Value};

/// Axis of a study: a column and its values in the order of the runs.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Scene field with unit suffix, such as `design.base_m`.
    pub column: String,
    pub values: Vec<Value>,
    /// Whether it varies within a design. Such axes define the conditions.
    pub varies_within_design: bool,
}

/// Values of the axes that vary within a design; empty if there are none.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    pub values: Vec<(String, Value)>,
}

/// One run. Missing figures are `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    pub run: i64,
    pub design: i64,
    /// Index of the row in the table, from 0.
    pub row: usize,
    /// Index into the conditions of the selection.
    pub condition: usize,
    /// One value per axis.
    pub axes: Vec<Value>,
    pub status: Status,
    pub force_positive: Option<bool>,
    pub form_closed: Option<bool>,
    pub class: Option<Class>,
    /// Reason for the class.
    pub class_reason: Option<String>,
    /// Reason why the run is incomplete or figures are missing.
    pub reason: Option<String>,
    pub tts_s: Option<f64>,
    /// Final simulated normal force on the proximal phalanx, N.
    pub f21_n: Option<f64>,
    /// Final simulated normal force on the distal phalanx, N.
    pub f22_n: Option<f64>,
    /// Palm force from these normal forces, N.
    pub pfp_n: Option<f64>,
}

impl Candidate {
    /// Whether the run is complete but has no class, because the finger cannot grasp its object.
    pub fn cannot_grasp(&self) -> bool {
        self.status == Status::Completed && self.class.is_none()
    }
}

/// Returns the class with this name.
pub fn parse_class(name: &str) -> Option<Class> {
    CLASSES.into_iter().find(|class| class.name() == name)
}

/// Content of a table of results.
pub struct ResultRuns {
    pub axes: Vec<Axis>,
    pub conditions: Vec<Condition>,
    /// Runs sorted by number.
    pub runs: Vec<Candidate>,
}

/// Reads axes, conditions and runs from a table of results.
pub fn read_results(table: &Table) -> Result<ResultRuns, SelectError> {
    let (design, first_result) = (table.column("design")?, table.column("l12_m")?);
    if first_result < design {
        return Err(SelectError::ColumnOrder);
    }
    let columns = Columns {
        run: table.integers("run")?,
        design: table.integers("design")?,
        status: table.texts("status")?,
        force_positive: table.flags("force_positive")?,
        form_closed: table.flags("form_closed")?,
        class: table.texts("class")?,
        class_reason: optional_texts(table, "class_reason")?,
        reason: optional_texts(table, "reason")?,
        tts: table.numbers("tts_s")?,
        f21: table.numbers("f21_n")?,
        f22: table.numbers("f22_n")?,
        pfp: table.numbers("pfp_n")?,
    };
    if table.rows.is_empty() {
        return Err(SelectError::Empty);
    }
    let axis_columns = design + 1..first_result;
    let read_row = |row: usize| read_candidate(&columns, row, table.rows[row][axis_columns.clone()].to_vec());
    let mut runs: Vec<Candidate> = (0..table.rows.len()).map(read_row).collect::<Result<_, _>>()?;
    runs.sort_by_key(|run| (run.run, run.row));
    if let Some(pair) = runs.windows(2).find(|pair| pair[0].run == pair[1].run) {
        return Err(SelectError::DuplicateRun { run: pair[0].run, first: pair[0].row + 1, second: pair[1].row + 1 });
    }
    let columns = table.columns[axis_columns].iter().enumerate();
    let axes: Vec<Axis> = columns.map(|(index, column)| collect_axis(&column.name, index, &runs)).collect();
    let conditions = assign_conditions(&axes, &mut runs)?;
    Ok(ResultRuns { axes, conditions, runs })
}

/// Columns required for a selection.
struct Columns<'a> {
    run: Vec<Option<i64>>,
    design: Vec<Option<i64>>,
    status: Vec<Option<&'a str>>,
    force_positive: Vec<Option<bool>>,
    form_closed: Vec<Option<bool>>,
    class: Vec<Option<&'a str>>,
    class_reason: Vec<Option<&'a str>>,
    reason: Vec<Option<&'a str>>,
    tts: Vec<Option<f64>>,
    f21: Vec<Option<f64>>,
    f22: Vec<Option<f64>>,
    pfp: Vec<Option<f64>>,
}

/// Column of texts; empty in every row if there is no such column.
fn optional_texts<'a>(table: &'a Table, name: &str) -> Result<Vec<Option<&'a str>>, SelectError> {
    match table.columns.iter().any(|column| column.name == name) {
        true => Ok(table.texts(name)?),
        false => Ok(vec![None; table.rows.len()]),
    }
}

/// Reads and validates one run.
fn read_candidate(columns: &Columns, row: usize, axes: Vec<Value>) -> Result<Candidate, SelectError> {
    let missing = |column: &'static str| SelectError::MissingValue { row: row + 1, column };
    let run = columns.run[row].ok_or_else(|| missing("run"))?;
    let unknown = |column: &'static str, found: &str, allowed: &'static str| SelectError::UnknownName {
        run,
        column,
        found: found.to_string(),
        allowed,
    };
    let status_text = columns.status[row].ok_or_else(|| missing("status"))?;
    let status = Status::ALL.into_iter().find(|status| status.name() == status_text);
    let status = status.ok_or_else(|| unknown("status", status_text, "completed, filtered, refused or failed"))?;
    let class = columns.class[row].map(|name| {
        parse_class(name).ok_or_else(|| unknown("class", name, "stable, semi-stable, semi-unstable or unstable"))
    });
    let finite = |column: &'static str, value: Option<f64>| match value {
        Some(value) if !value.is_finite() => Err(SelectError::NotFinite { run, column, value }),
        other => Ok(other),
    };
    let candidate = Candidate {
        run,
        design: columns.design[row].ok_or_else(|| missing("design"))?,
        row,
        condition: 0,
        axes,
        status,
        force_positive: columns.force_positive[row],
        form_closed: columns.form_closed[row],
        class: class.transpose()?,
        class_reason: columns.class_reason[row].map(String::from),
        reason: columns.reason[row].map(String::from),
        tts_s: finite("tts_s", columns.tts[row])?,
        f21_n: finite("f21_n", columns.f21[row])?,
        f22_n: finite("f22_n", columns.f22[row])?,
        pfp_n: finite("pfp_n", columns.pfp[row])?,
    };
    let is_missing = [
        ("force_positive", candidate.force_positive.is_none()),
        ("form_closed", candidate.form_closed.is_none()),
        ("class", candidate.class.is_none()),
        ("f21_n", candidate.f21_n.is_none()),
        ("f22_n", candidate.f22_n.is_none()),
        ("pfp_n", candidate.pfp_n.is_none()),
    ];
    // A completed row without a reason must have all figures; otherwise it is unfinished.
    let requires_all = status == Status::Completed && candidate.reason.is_none();
    match is_missing.iter().find(|(_, missing)| requires_all && *missing) {
        Some(&(column, _)) => Err(SelectError::Unfinished { row: row + 1, run, column }),
        None => Ok(candidate),
    }
}

/// Collects the values of an axis in order of first appearance.
fn collect_axis(column: &str, index: usize, runs: &[Candidate]) -> Axis {
    let mut seen = HashSet::new();
    let mut values = Vec::new();
    let mut value_of_design = HashMap::new();
    let mut varies_within_design = false;
    for run in runs {
        let value = &run.axes[index];
        varies_within_design |= value_of_design.entry(run.design).or_insert(value) != &value;
        if seen.insert(value.text()) {
            values.push(value.clone());
        }
    }
    Axis { column: column.to_string(), values, varies_within_design }
}

/// Assigns a condition to every run; the conditions are in order of first appearance.
fn assign_conditions(axes: &[Axis], runs: &mut [Candidate]) -> Result<Vec<Condition>, SelectError> {
    let condition_axes: Vec<usize> = (0..axes.len()).filter(|&axis| axes[axis].varies_within_design).collect();
    let mut indices: HashMap<Vec<String>, usize> = HashMap::new();
    let mut conditions = Vec::new();
    let mut designs: HashMap<(i64, usize), i64> = HashMap::new();
    for run in runs {
        let next = conditions.len();
        let index = *indices.entry(condition_axes.iter().map(|&axis| run.axes[axis].text()).collect()).or_insert(next);
        if index == next {
            let value = |&axis: &usize| (axes[axis].column.clone(), run.axes[axis].clone());
            conditions.push(Condition { values: condition_axes.iter().map(value).collect() });
        }
        run.condition = index;
        if let Some(first) = designs.insert((run.design, index), run.run) {
            return Err(SelectError::DuplicateDesign { design: run.design, first, second: run.run });
        }
    }
    Ok(conditions)
}
