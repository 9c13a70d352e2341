//! Both models side by side on one grid of times, as comma-separated values.

use std::io::{self, Write};

use crate::trace::Sample;
use crate::validate::{Recording, turned};

type Column = (&'static str, fn(&Sample) -> f64);

/// The quantities, in SI: each is a column with `_analytic` behind its name and one with `_engine`. Angles are
/// from −π to π.
pub const COLUMNS: [Column; 15] = [
    ("q11_rad", |s| turned(s.q11_rad)),
    ("q21_rad", |s| turned(s.q21_rad)),
    ("q22_rad", |s| turned(s.q22_rad)),
    ("qd11_rad_s", |s| s.qd11_rad_s),
    ("qd21_rad_s", |s| s.qd21_rad_s),
    ("qd22_rad_s", |s| s.qd22_rad_s),
    ("proximal_gap_m", |s| s.proximal.gap_m),
    ("distal_gap_m", |s| s.distal.gap_m),
    ("proximal_normal_n", |s| s.proximal.normal_n),
    ("distal_normal_n", |s| s.distal.normal_n),
    ("proximal_tangential_n", |s| s.proximal.tangential_n),
    ("distal_tangential_n", |s| s.distal.tangential_n),
    ("limit_torque_n_m", |s| s.limit.torque_n_m),
    ("kinetic_j", |s| s.energy.kinetic_j),
    ("balance_j", |s| s.energy.balance_j),
];

/// Writes both runs at every multiple of 1/`numeric_hz` and at the end. What is infinite (a gap to no object) is empty.
pub fn series(out: &mut impl Write, analytic: &Recording, engine: &Recording, numeric_hz: f64) -> io::Result<()> {
    let heads = COLUMNS.iter().map(|(name, _)| format!(",{name}_analytic,{name}_engine"));
    writeln!(out, "time_s{}", heads.collect::<String>())?;
    let end_s = analytic.outcome.last.time_s;
    let (mut ours, mut theirs) = (0, 0);
    let mut index = 0_u64;
    loop {
        let time_s = (index as f64 / numeric_hz).min(end_s);
        let (Some(a), Some(e)) = (analytic.at(time_s, &mut ours), engine.at(time_s, &mut theirs)) else {
            return Ok(());
        };
        write!(out, "{time_s:?}")?;
        for (_, value) in COLUMNS {
            write!(out, ",{},{}", cell(value(&a)), cell(value(&e)))?;
        }
        writeln!(out)?;
        if time_s >= end_s {
            return Ok(());
        }
        index += 1;
    }
}

fn cell(value: f64) -> String {
    if value.is_finite() { format!("{value:?}") } else { String::new() }
}
