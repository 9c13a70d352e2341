//! Tables of sweep results built in code.

use phalanx::table::{Column, Kind, Table, Value};

/// One run of a sweep; the fields are columns of the results.
#[derive(Clone)]
pub struct SweepRun {
    pub design: i64,
    pub mu: f64,
    pub base_m: f64,
    pub status: &'static str,
    pub force_positive: Option<bool>,
    pub form_closed: Option<bool>,
    pub class: Option<&'static str>,
    pub class_reason: Option<&'static str>,
    pub reason: Option<&'static str>,
    pub tts_s: Option<f64>,
    /// PFP, F21, F22.
    pub forces: Option<[f64; 3]>,
}

/// A run that satisfies every criterion of the thesis.
pub fn successful_run(design: i64, tts_s: f64, forces: [f64; 3]) -> SweepRun {
    SweepRun {
        design,
        mu: 0.8,
        base_m: 0.012,
        status: "completed",
        force_positive: Some(true),
        form_closed: Some(true),
        class: Some("stable"),
        class_reason: Some("in position with both contacts active from 7 ms on, in less than 15 ms, without a rebound"),
        reason: None,
        tts_s: Some(tts_s),
        forces: Some(forces),
    }
}

/// A run of an invalid scene; its row has only design, lengths and mass.
pub fn refused_run(design: i64) -> SweepRun {
    SweepRun {
        status: "refused",
        force_positive: None,
        form_closed: None,
        class: None,
        class_reason: None,
        reason: Some("the scene is not valid"),
        tts_s: None,
        forces: None,
        ..successful_run(design, 0.0, [0.0; 3])
    }
}

/// A completed run of a finger that cannot grasp its object.
pub fn ungraspable_run(design: i64, reason: &'static str) -> SweepRun {
    SweepRun { status: "completed", reason: Some(reason), ..refused_run(design) }
}

/// Returns the table of the runs, numbered from 1.
pub fn results_table(runs: &[SweepRun]) -> Table {
    type Cell = fn(usize, &SweepRun) -> Value;
    let columns: [(&str, Kind, Cell); 16] = [
        ("run", Kind::Integer, |index, _| Value::Integer(index as i64 + 1)),
        ("design", Kind::Integer, |_, run| Value::Integer(run.design)),
        ("contact.friction.mu_static", Kind::Number, |_, run| Value::Number(run.mu)),
        ("design.base_m", Kind::Number, |_, run| Value::Number(run.base_m)),
        ("l12_m", Kind::Number, |_, _| Value::Number(0.02)),
        ("mass_kg", Kind::Number, |_, run| Value::Number(0.02 + 1e-3 * run.design as f64)),
        ("force_positive", Kind::Flag, |_, run| Value::from(run.force_positive)),
        ("form_closed", Kind::Flag, |_, run| Value::from(run.form_closed)),
        ("status", Kind::Text, |_, run| Value::from(run.status)),
        ("reason", Kind::Text, |_, run| Value::from(run.reason)),
        ("tts_s", Kind::Number, |_, run| Value::from(run.tts_s)),
        ("class", Kind::Text, |_, run| Value::from(run.class)),
        ("class_reason", Kind::Text, |_, run| Value::from(run.class_reason)),
        ("f21_n", Kind::Number, |_, run| Value::from(run.forces.map(|forces| forces[1]))),
        ("f22_n", Kind::Number, |_, run| Value::from(run.forces.map(|forces| forces[2]))),
        ("pfp_n", Kind::Number, |_, run| Value::from(run.forces.map(|forces| forces[0]))),
    ];
    let row = |(index, run): (usize, &SweepRun)| columns.iter().map(|(_, _, cell)| cell(index, run)).collect();
    let columns = columns.iter().map(|(name, kind, _)| Column::new(*name, *kind)).collect();
    Table::new(columns, runs.iter().enumerate().map(row).collect())
}
