//! Runs with their figures, axes and conditions, out of a table of results.

use std::collections::{HashMap, HashSet};

use super::SelectError;
use super::classes::CLASSES;
use crate::criteria::Class;
use crate::study::sweep::Status;
use crate::table::{Table, Value};

/// What a study varied: a column, and its values in the order in which the study went through them.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Scene field with its unit suffix, such as `design.base_m`.
    pub column: String,
    pub values: Vec<Value>,
    /// Whether it varies within one design; then it is part of the conditions.
    pub again: bool,
}

/// What differs between runs of one design: a value for each axis that is there `again`; none if there is no such axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    pub values: Vec<(String, Value)>,
}

/// One run. What it has no figure of is `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    pub run: i64,
    pub design: i64,
    /// Row in the table, from 0.
    pub row: usize,
    /// Index into the conditions of the selection.
    pub condition: usize,
    /// One for each axis.
    pub axes: Vec<Value>,
    pub status: Status,
    pub force_positive: Option<bool>,
    pub form_closed: Option<bool>,
    pub class: Option<Class>,
    /// What decides the class.
    pub class_reason: Option<String>,
    /// Why it was not completed, or why figures are missing.
    pub reason: Option<String>,
    pub tts_s: Option<f64>,
    /// Final simulated normal forces, and the palm force of them.
    pub f21_n: Option<f64>,
    pub f22_n: Option<f64>,
    pub pfp_n: Option<f64>,
}

impl Candidate {
    /// Whether it was simulated to the end, but has no class, for the finger cannot grasp its object.
    pub fn cannot_grasp(&self) -> bool {
        self.status == Status::Completed && self.class.is_none()
    }
}

/// The class of a name.
pub fn class_named(name: &str) -> Option<Class> {
    CLASSES.into_iter().find(|class| class.name() == name)
}

/// What a table of results holds.
pub struct Read {
    pub axes: Vec<Axis>,
    pub conditions: Vec<Condition>,
    /// In the order of their numbers.
    pub runs: Vec<Candidate>,
}

/// Axes, conditions and runs.
pub fn read(table: &Table) -> Result<Read, SelectError> {
    let (design, lengths) = (table.column("design")?, table.column("l12_m")?);
    if lengths < design {
        return Err(SelectError::Order);
    }
    let columns = Columns {
        run: table.integers("run")?,
        design: table.integers("design")?,
        status: table.texts("status")?,
        force_positive: table.flags("force_positive")?,
        form_closed: table.flags("form_closed")?,
        class: table.texts("class")?,
        class_reason: texts_if_there(table, "class_reason")?,
        reason: texts_if_there(table, "reason")?,
        tts: table.numbers("tts_s")?,
        f21: table.numbers("f21_n")?,
        f22: table.numbers("f22_n")?,
        pfp: table.numbers("pfp_n")?,
    };
    if table.rows.is_empty() {
        return Err(SelectError::Empty);
    }
    let places = design + 1..lengths;
    let one = |row: usize| candidate(&columns, row, table.rows[row][places.clone()].to_vec());
    let mut runs: Vec<Candidate> = (0..table.rows.len()).map(one).collect::<Result<_, _>>()?;
    runs.sort_by_key(|run| (run.run, run.row));
    if let Some(pair) = runs.windows(2).find(|pair| pair[0].run == pair[1].run) {
        return Err(SelectError::Twice { run: pair[0].run, first: pair[0].row + 1, second: pair[1].row + 1 });
    }
    let names = table.columns[places].iter().enumerate();
    let axes: Vec<Axis> = names.map(|(index, column)| axis(&column.name, index, &runs)).collect();
    let conditions = conditions(&axes, &mut runs)?;
    Ok(Read { axes, conditions, runs })
}

/// The columns that a selection needs, each of its kind.
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

/// A column of texts; nothing in each row where there is no such column.
fn texts_if_there<'a>(table: &'a Table, name: &str) -> Result<Vec<Option<&'a str>>, SelectError> {
    match table.columns.iter().any(|column| column.name == name) {
        true => Ok(table.texts(name)?),
        false => Ok(vec![None; table.rows.len()]),
    }
}

fn candidate(columns: &Columns, row: usize, axes: Vec<Value>) -> Result<Candidate, SelectError> {
    let absent = |column: &'static str| SelectError::Absent { row: row + 1, column };
    let run = columns.run[row].ok_or_else(|| absent("run"))?;
    let word = |column: &'static str, found: &str, allowed: &'static str| SelectError::Word {
        run,
        column,
        found: found.to_string(),
        allowed,
    };
    let status_text = columns.status[row].ok_or_else(|| absent("status"))?;
    let status = Status::ALL.into_iter().find(|status| status.name() == status_text);
    let status = status.ok_or_else(|| word("status", status_text, "completed, filtered, refused or failed"))?;
    let class = columns.class[row].map(|name| {
        class_named(name).ok_or_else(|| word("class", name, "stable, semi-stable, semi-unstable or unstable"))
    });
    let finite = |column: &'static str, value: Option<f64>| match value {
        Some(value) if !value.is_finite() => Err(SelectError::NotFinite { run, column, value }),
        other => Ok(other),
    };
    let found = Candidate {
        run,
        design: columns.design[row].ok_or_else(|| absent("design"))?,
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
    let needed = [
        ("force_positive", found.force_positive.is_none()),
        ("form_closed", found.form_closed.is_none()),
        ("class", found.class.is_none()),
        ("f21_n", found.f21_n.is_none()),
        ("f22_n", found.f22_n.is_none()),
        ("pfp_n", found.pfp_n.is_none()),
    ];
    // A row says why figures are missing, or it is not finished.
    let must_have = status == Status::Completed && found.reason.is_none();
    match needed.iter().find(|(_, absent)| must_have && *absent) {
        Some(&(column, _)) => Err(SelectError::Unfinished { row: row + 1, run, column }),
        None => Ok(found),
    }
}

/// An axis with its values in order of first appearance.
fn axis(column: &str, index: usize, runs: &[Candidate]) -> Axis {
    let mut seen = HashSet::new();
    let mut values = Vec::new();
    let mut of_design = HashMap::new();
    let mut again = false;
    for run in runs {
        let value = &run.axes[index];
        again |= of_design.entry(run.design).or_insert(value) != &value;
        if seen.insert(value.text()) {
            values.push(value.clone());
        }
    }
    Axis { column: column.to_string(), values, again }
}

/// Gives every run its condition; conditions are in order of first appearance.
fn conditions(axes: &[Axis], runs: &mut [Candidate]) -> Result<Vec<Condition>, SelectError> {
    let again: Vec<usize> = (0..axes.len()).filter(|&axis| axes[axis].again).collect();
    let mut places: HashMap<Vec<String>, usize> = HashMap::new();
    let mut conditions = Vec::new();
    let mut designs: HashMap<(i64, usize), i64> = HashMap::new();
    for run in runs {
        let next = conditions.len();
        let place = *places.entry(again.iter().map(|&axis| run.axes[axis].text()).collect()).or_insert(next);
        if place == next {
            let value = |&axis: &usize| (axes[axis].column.clone(), run.axes[axis].clone());
            conditions.push(Condition { values: again.iter().map(value).collect() });
        }
        run.condition = place;
        if let Some(first) = designs.insert((run.design, place), run.run) {
            return Err(SelectError::DesignTwice { design: run.design, first, second: run.run });
        }
    }
    Ok(conditions)
}
