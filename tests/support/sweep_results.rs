//! Tables of sweep results built in code.

use std::collections::BTreeMap;

use phalanx::table::{Column, Kind, Table, Value};

/// Columns of the tables, in order.
const COLUMNS: [(&str, Kind); 16] = [
    ("run", Kind::Integer),
    ("design", Kind::Integer),
    ("contact.friction.mu_static", Kind::Number),
    ("design.base_m", Kind::Number),
    ("l12_m", Kind::Number),
    ("mass_kg", Kind::Number),
    ("force_positive", Kind::Flag),
    ("form_closed", Kind::Flag),
    ("status", Kind::Text),
    ("reason", Kind::Text),
    ("tts_s", Kind::Number),
    ("class", Kind::Text),
    ("class_reason", Kind::Text),
    ("f21_n", Kind::Number),
    ("f22_n", Kind::Number),
    ("pfp_n", Kind::Number),
];

/// One run of a sweep: the values of its columns.
#[derive(Clone)]
pub struct SweepRun(BTreeMap<&'static str, Value>);

impl SweepRun {
    /// The run with another value of a column.
    pub fn with(mut self, column: &'static str, value: impl Into<Value>) -> Self {
        self.0.insert(column, value.into());
        self
    }
}

/// A run that satisfies every criterion of the thesis. The forces are PFP, F21 and F22.
pub fn successful_run(design: i64, tts_s: f64, [pfp_n, f21_n, f22_n]: [f64; 3]) -> SweepRun {
    let reason = "in position with both contacts active from 7 ms on, in less than 15 ms, without a rebound";
    let run = ungraspable_run(design, "").with("reason", Value::Missing).with("tts_s", tts_s);
    let run = run.with("force_positive", true).with("form_closed", true).with("class", "stable");
    run.with("class_reason", reason).with("pfp_n", pfp_n).with("f21_n", f21_n).with("f22_n", f22_n)
}

/// A run of an invalid scene; its row has only design, lengths and mass.
pub fn refused_run(design: i64) -> SweepRun {
    ungraspable_run(design, "the scene is not valid").with("status", "refused")
}

/// A completed run of a finger that cannot grasp its object.
pub fn ungraspable_run(design: i64, reason: &'static str) -> SweepRun {
    let run = SweepRun(BTreeMap::new()).with("design", design).with("contact.friction.mu_static", 0.8);
    let run = run.with("design.base_m", 0.012).with("l12_m", 0.02).with("mass_kg", 0.02 + 1e-3 * design as f64);
    run.with("status", "completed").with("reason", reason)
}

/// Returns the table of the runs, numbered from 1.
pub fn results_table(runs: &[SweepRun]) -> Table {
    let row = |(number, run): (i64, &SweepRun)| {
        let run = run.clone().with("run", number);
        COLUMNS.iter().map(|(name, _)| run.0.get(name).cloned().unwrap_or(Value::Missing)).collect()
    };
    let columns = COLUMNS.map(|(name, kind)| Column::new(name, kind)).to_vec();
    Table::new(columns, (1..).zip(runs).map(row).collect())
}
