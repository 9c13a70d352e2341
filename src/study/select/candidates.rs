//! Runs, axes and conditions of a table of results.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use serde::{Serialize, Serializer};

use crate::criteria::Class;
use crate::study::quantity::ColumnFormat;
use crate::study::sweep::Status;
use crate::table::{Table, TableError, Value};

/// Axis of a study: a column and its values, in the order of the runs. It is serialised with the number of its values.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Axis {
    /// Scene field with its unit as suffix, such as `design.base_m`.
    pub column: String,
    #[serde(serialize_with = "length")]
    pub values: Vec<Value>,
    /// Whether the axis varies within a design. Such axes define the conditions.
    #[serde(rename = "again")]
    pub varies_within_design: bool,
}

fn length<S: Serializer>(values: &[Value], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_u64(values.len() as u64)
}

/// Values of the axes that vary within a design; empty if there are no such axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    pub values: Vec<(String, Value)>,
}

impl Condition {
    /// Returns the name, such as `mu_static 0.8`; "all runs" for a condition without values.
    pub(crate) fn name(&self) -> String {
        let name = |(column, value): &(String, Value)| ColumnFormat::for_column(column).name_and_value(value);
        let names: Vec<String> = self.values.iter().map(name).collect();
        if names.is_empty() { "all runs".to_string() } else { names.join(", ") }
    }
}

/// One run. Figures that are missing are `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    pub run: i64,
    pub design: i64,
    /// Index of the row in the table, from 0.
    pub row: usize,
    /// Index of the condition of the run in the selection.
    pub condition: usize,
    pub axes: Vec<Value>,
    pub status: Status,
    pub force_positive: Option<bool>,
    pub form_closed: Option<bool>,
    pub class: Option<Class>,
    pub class_reason: Option<String>,
    /// Reason why the run is incomplete, or why figures are missing; `None` without a reason.
    pub reason: Option<String>,
    pub tts_s: Option<f64>,
    /// Final simulated normal force on the proximal phalanx, N.
    pub f21_n: Option<f64>,
    /// Final simulated normal force on the distal phalanx, N.
    pub f22_n: Option<f64>,
    /// Palm force computed from these normal forces, N.
    pub pfp_n: Option<f64>,
}

impl Candidate {
    /// Whether the run is complete but has no class, because the finger cannot grasp its object.
    pub fn cannot_grasp(&self) -> bool {
        self.status == Status::Completed && self.class.is_none()
    }
}

pub(crate) fn parse_class(name: &str) -> Option<Class> {
    Class::ALL.into_iter().find(|class| class.name() == name)
}

/// Content of a table of results; the runs are sorted by number.
type Results = (Vec<Axis>, Vec<Condition>, Vec<Candidate>);

pub(super) fn read_results(table: &Table) -> Result<Results, SelectError> {
    let (design, first_result) = (table.column("design")?, table.column("l12_m")?);
    if first_result < design {
        return Err(SelectError::ColumnOrder);
    }
    let axis_columns = design + 1..first_result;
    let mut runs = read_candidates(table, axis_columns.clone())?;
    runs.sort_by_key(|run| (run.run, run.row));
    if let Some(pair) = runs.windows(2).find(|pair| pair[0].run == pair[1].run) {
        return Err(SelectError::DuplicateRun { run: pair[0].run, first: pair[0].row + 1, second: pair[1].row + 1 });
    }
    let columns = table.columns[axis_columns].iter().enumerate();
    let axes: Vec<Axis> = columns.map(|(index, column)| collect_axis(&column.name, index, &runs)).collect();
    let conditions = assign_conditions(&axes, &mut runs)?;
    Ok((axes, conditions, runs))
}

/// Reads and checks all runs of a table; their condition is assigned later.
fn read_candidates(table: &Table, axis_columns: Range<usize>) -> Result<Vec<Candidate>, SelectError> {
    let optional_texts = |name: &str| match table.find(name) {
        Some(_) => table.texts(name),
        None => Ok(vec![None; table.rows.len()]),
    };
    let (numbers, designs) = (table.integers("run")?, table.integers("design")?);
    let (statuses, classes) = (table.texts("status")?, table.texts("class")?);
    let (force_positive, form_closed) = (table.flags("force_positive")?, table.flags("form_closed")?);
    let (class_reasons, reasons) = (optional_texts("class_reason")?, optional_texts("reason")?);
    const FIGURES: [&str; 4] = ["tts_s", "f21_n", "f22_n", "pfp_n"];
    let figures = FIGURES.into_iter().map(|name| table.numbers(name)).collect::<Result<Vec<_>, _>>()?;
    if table.rows.is_empty() {
        return Err(SelectError::Empty);
    }
    let read_row = |row: usize| {
        let missing = |column: &'static str| SelectError::MissingValue { row: row + 1, column };
        let run = numbers[row].ok_or_else(|| missing("run"))?;
        let unknown = |column: &'static str, found: &str, allowed: &'static str| SelectError::UnknownName {
            run,
            column,
            found: found.to_string(),
            allowed,
        };
        let status = statuses[row].ok_or_else(|| missing("status"))?;
        let known = Status::ALL.into_iter().find(|known| known.name() == status);
        let status = known.ok_or_else(|| unknown("status", status, "completed, filtered, refused or failed"))?;
        let class = classes[row].map(|name| {
            parse_class(name).ok_or_else(|| unknown("class", name, "stable, semi-stable, semi-unstable or unstable"))
        });
        let figure = |index: usize| match figures[index][row] {
            Some(value) if !value.is_finite() => Err(SelectError::NotFinite { run, column: FIGURES[index], value }),
            value => Ok(value),
        };
        let candidate = Candidate {
            run,
            design: designs[row].ok_or_else(|| missing("design"))?,
            row,
            condition: 0,
            axes: table.rows[row][axis_columns.clone()].to_vec(),
            status,
            force_positive: force_positive[row],
            form_closed: form_closed[row],
            class: class.transpose()?,
            class_reason: class_reasons[row].map(String::from),
            reason: reasons[row].map(String::from),
            tts_s: figure(0)?,
            f21_n: figure(1)?,
            f22_n: figure(2)?,
            pfp_n: figure(3)?,
        };
        // A completed row without a reason must have all figures except tts; otherwise it is unfinished.
        let present = [force_positive[row].is_some(), form_closed[row].is_some(), candidate.class.is_some()];
        let names = ["force_positive", "form_closed", "class"].into_iter().chain(FIGURES.into_iter().skip(1));
        let present = present.into_iter().chain(figures[1..].iter().map(|values| values[row].is_some()));
        let mut unfinished = names.zip(present).filter(|(_, is_present)| !is_present);
        match unfinished.next().filter(|_| status == Status::Completed && candidate.reason.is_none()) {
            Some((column, _)) => Err(SelectError::Unfinished { row: row + 1, run, column }),
            None => Ok(candidate),
        }
    };
    (0..table.rows.len()).map(read_row).collect()
}

/// Collects the values of an axis in order of first appearance.
fn collect_axis(column: &str, index: usize, runs: &[Candidate]) -> Axis {
    let (mut seen, mut value_of_design) = (HashSet::new(), HashMap::new());
    let (mut values, mut varies_within_design) = (Vec::new(), false);
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
        let key = condition_axes.iter().map(|&axis| run.axes[axis].text()).collect();
        run.condition = *indices.entry(key).or_insert_with(|| {
            let value = |&axis: &usize| (axes[axis].column.clone(), run.axes[axis].clone());
            conditions.push(Condition { values: condition_axes.iter().map(value).collect() });
            conditions.len() - 1
        });
        if let Some(first) = designs.insert((run.design, run.condition), run.run) {
            return Err(SelectError::DuplicateDesign { design: run.design, first, second: run.run });
        }
    }
    Ok(conditions)
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SelectError {
    #[error("{0}; a selection requires the results of `phalanx sweep`")]
    Table(#[from] TableError),
    #[error(
        "the column `l12_m` is before `design`: the axes of the study are the columns between `design` and `l12_m`, \
         in that order, as `phalanx sweep` writes them"
    )]
    ColumnOrder,
    #[error("the results have no rows: run `phalanx sweep` first")]
    Empty,
    #[error("row {row} has no `{column}`: the row is not finished; let `phalanx sweep` resume and write it again")]
    MissingValue { row: usize, column: &'static str },
    #[error("run {run}: `{column}` is `{found}`, expected {allowed}")]
    UnknownName { run: i64, column: &'static str, found: String, allowed: &'static str },
    #[error("run {run}: `{column}` is {value}, expected a finite number or an empty cell")]
    NotFinite { run: i64, column: &'static str, value: f64 },
    #[error(
        "row {row} (run {run}) is completed, but has neither `{column}` nor a `reason`: the row is not finished; repeat the sweep \
         (`phalanx sweep --restart`)"
    )]
    Unfinished { row: usize, run: i64, column: &'static str },
    #[error("run {run} occurs twice, in rows {first} and {second}: remove one of them")]
    DuplicateRun { run: i64, first: usize, second: usize },
    #[error(
        "design {design} occurs twice with the same value of every axis, as runs {first} and {second}: use the results of one study, \
         which contain each design once per condition"
    )]
    DuplicateDesign { design: i64, first: i64, second: i64 },
    #[error("the weight of {name} is {value}, but weights must be finite and not negative")]
    Weight { name: &'static str, value: f64 },
    #[error("all weights are 0: at least one weight must be positive")]
    NoWeight,
}
