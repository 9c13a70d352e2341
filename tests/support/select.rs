//! Hand-made results of a sweep.

use phalanx::table::{Column, Kind, Table, Value};

/// One run, in the words of the results.
#[derive(Clone)]
pub struct Made {
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

/// A run that meets every criterion of the thesis.
pub fn good(design: i64, tts_s: f64, forces: [f64; 3]) -> Made {
    Made {
        design,
        mu: 0.8,
        base_m: 0.012,
        status: "completed",
        force_positive: Some(true),
        form_closed: Some(true),
        class: Some("stable"),
        class_reason: Some("both phalanges press in position from 7 ms on, in less than 15 ms, without a rebound"),
        reason: None,
        tts_s: Some(tts_s),
        forces: Some(forces),
    }
}

/// A run that left nothing but its lengths.
pub fn refused(design: i64) -> Made {
    Made {
        status: "refused",
        force_positive: None,
        form_closed: None,
        class: None,
        class_reason: None,
        reason: Some("the scene is not valid"),
        tts_s: None,
        forces: None,
        ..good(design, 0.0, [0.0; 3])
    }
}

/// A run that was simulated to the end, of a finger that cannot grasp its object.
pub fn ungraspable(design: i64, reason: &'static str) -> Made {
    Made { status: "completed", reason: Some(reason), ..refused(design) }
}

/// The table of these runs, numbered from 1.
pub fn results(runs: &[Made]) -> Table {
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
    let row = |(index, run): (usize, &Made)| {
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
