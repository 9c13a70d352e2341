//! Both models side by side on one grid of times, as comma-separated values.

use std::io::{self, Write};

use super::super::csv::cell;
use crate::scene::Scene;
use crate::scene::words::SceneKind;
use crate::trace::columns::{Column, columns};
use crate::trace::{Layout, Sample, Site};
use crate::validate::{Recording, turned};

type Figure = (&'static str, fn(&Sample) -> f64);

/// The quantities of a finger, in SI: each is a column with `_analytic` behind its name and one with `_engine`. Angles are
/// from −π to π.
pub const COLUMNS: [Figure; 15] = [
    ("q11_rad", |s| turned(s.finger().q11_rad)),
    ("q21_rad", |s| turned(s.finger().q21_rad)),
    ("q22_rad", |s| turned(s.finger().q22_rad)),
    ("qd11_rad_s", |s| s.finger().qd11_rad_s),
    ("qd21_rad_s", |s| s.finger().qd21_rad_s),
    ("qd22_rad_s", |s| s.finger().qd22_rad_s),
    ("proximal_gap_m", |s| s.contact(Site::Proximal).gap_m),
    ("distal_gap_m", |s| s.contact(Site::Distal).gap_m),
    ("proximal_normal_n", |s| s.contact(Site::Proximal).normal_n),
    ("distal_normal_n", |s| s.contact(Site::Distal).normal_n),
    ("proximal_tangential_n", |s| s.contact(Site::Proximal).tangential_n),
    ("distal_tangential_n", |s| s.contact(Site::Distal).tangential_n),
    ("limit_torque_n_m", |s| s.contact(Site::Limit).normal_n),
    ("kinetic_j", |s| s.energy.kinetic_j),
    ("balance_j", |s| s.energy.balance_j),
];

/// What follows from the figures of discs that are there, and energies that they seldom have.
const NOT_OF_DISCS: [&str; 10] = [
    "gap_rate_m_s",
    "impulse_n_s",
    "point_x_m",
    "point_y_m",
    "normal_x",
    "normal_y",
    "gravity_j",
    "spring_j",
    "elastic_j",
    "motor_work_j",
];

/// Writes both runs at every multiple of the interval of the scene's log and at the end: of a finger these columns, of discs
/// places and rates of every disc, gap and forces of every pair, energies; of a gripper all figures of a sample. What is infinite (a gap to no object) is empty.
pub fn series(out: &mut impl Write, scene: &Scene, [analytic, engine]: [&Recording; 2]) -> io::Result<()> {
    let (kind, layout) = (scene.kind(), Layout::of(&scene.system));
    let left_out =
        |column: &Column| kind == SceneKind::Bodies && NOT_OF_DISCS.iter().any(|end| column.name.ends_with(end));
    // Time is the first of them.
    let all: Vec<Column> = columns(&layout).into_iter().skip(1).filter(|column| !left_out(column)).collect();
    let names: Vec<String> = match kind {
        SceneKind::Finger => COLUMNS.iter().map(|(name, _)| name.to_string()).collect(),
        SceneKind::Bodies | SceneKind::Gripper => all.iter().map(|column| column.name.clone()).collect(),
    };
    let values = |sample: &Sample| -> Vec<f64> {
        match kind {
            SceneKind::Finger => COLUMNS.iter().map(|(_, value)| value(sample)).collect(),
            SceneKind::Bodies | SceneKind::Gripper => all.iter().map(|column| column.value(sample)).collect(),
        }
    };
    let (mut ours, mut theirs) = (0, 0);
    write_series(out, &names, [scene.log.numeric_hz, analytic.outcome.last.time_s], |t| {
        Some([values(&analytic.at(t, &mut ours)?), values(&engine.at(t, &mut theirs)?)])
    })
}

/// Writes what `at` gives for both models at every multiple of 1/`numeric_hz` and at `end_s`.
fn write_series(
    out: &mut impl Write,
    names: &[String],
    [numeric_hz, end_s]: [f64; 2],
    mut at: impl FnMut(f64) -> Option<[Vec<f64>; 2]>,
) -> io::Result<()> {
    let heads = names.iter().map(|name| format!(",{name}_analytic,{name}_engine"));
    writeln!(out, "time_s{}", heads.collect::<String>())?;
    let mut index = 0_u64;
    loop {
        let time_s = (index as f64 / numeric_hz).min(end_s);
        let Some([analytic, engine]) = at(time_s) else { return Ok(()) };
        write!(out, "{time_s:?}")?;
        for (a, e) in analytic.into_iter().zip(engine) {
            write!(out, ",{},{}", cell(a), cell(e))?;
        }
        writeln!(out)?;
        if time_s >= end_s {
            return Ok(());
        }
        index += 1;
    }
}
