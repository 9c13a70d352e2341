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
    let columns = [
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
    let row = |(index, run): (usize, &SweepRun)| {
        let force = |index: usize| Value::from(run.forces.map(|forces| forces[index]));
        vec![
            Value::Integer(index as i64 + 1),
            Value::Integer(run.design),
            Value::Number(run.mu),
            Value::Number(run.base_m),
            Value::Number(0.02),
            Value::Number(0.02 + 1e-3 * run.design as f64),
            Value::from(run.force_positive),
            Value::from(run.form_closed),
            Value::from(run.status),
            Value::from(run.reason),
            Value::from(run.tts_s),
            Value::from(run.class),
            Value::from(run.class_reason),
            force(1),
            force(2),
            force(0),
        ]
    };
    let columns = columns.map(|(name, kind)| Column::new(name, kind)).to_vec();
    Table::new(columns, runs.iter().enumerate().map(row).collect())
}
