//! Time series of both models on a common grid, as comma-separated values.

use std::io::{self, Write};

use super::super::csv::cell;
use crate::scene::Scene;
use crate::scene::keywords::SceneKind;
use crate::trace::columns::{Column, columns};
use crate::trace::{FingerContact, Layout, Sample};
use crate::validate::{Recording, wrap_angle};

type NamedQuantity = (&'static str, fn(&Sample) -> f64);

/// The quantities of a finger, in SI units. Each has two columns, with the suffixes `_analytic` and `_engine`. Angles
/// are between −π and π.
pub const COLUMNS: [NamedQuantity; 15] = [
    ("q11_rad", |s| wrap_angle(s.finger().q11_rad)),
    ("q21_rad", |s| wrap_angle(s.finger().q21_rad)),
    ("q22_rad", |s| wrap_angle(s.finger().q22_rad)),
    ("qd11_rad_s", |s| s.finger().qd11_rad_s),
    ("qd21_rad_s", |s| s.finger().qd21_rad_s),
    ("qd22_rad_s", |s| s.finger().qd22_rad_s),
    ("proximal_gap_m", |s| s.contact(FingerContact::Proximal).gap_m),
    ("distal_gap_m", |s| s.contact(FingerContact::Distal).gap_m),
    ("proximal_normal_n", |s| s.contact(FingerContact::Proximal).normal_n),
    ("distal_normal_n", |s| s.contact(FingerContact::Distal).normal_n),
    ("proximal_tangential_n", |s| s.contact(FingerContact::Proximal).tangential_n),
    ("distal_tangential_n", |s| s.contact(FingerContact::Distal).tangential_n),
    ("limit_torque_n_m", |s| s.contact(FingerContact::Limit).normal_n),
    ("kinetic_j", |s| s.energy.kinetic_j),
    ("balance_j", |s| s.energy.balance_j),
];

/// Suffixes of columns that are omitted for scenes of discs: derived quantities, and energies that are mostly zero
/// there.
const OMITTED_FOR_DISCS: [&str; 10] = [
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

/// Writes both runs at every multiple of the scene's log interval and at the end.
///
/// A finger has the columns [`COLUMNS`]; scenes of discs have positions and rates of every disc, gap and forces of
/// every pair, and energies; a gripper has all quantities of a sample. Infinite values (a gap without an object) are
/// empty.
pub fn write_series(out: &mut impl Write, scene: &Scene, [analytic, engine]: [&Recording; 2]) -> io::Result<()> {
    let (kind, layout) = (scene.kind(), Layout::from_system(&scene.system));
    let is_omitted = |column: &Column| {
        kind == SceneKind::Bodies && OMITTED_FOR_DISCS.iter().any(|suffix| column.name.ends_with(suffix))
    };
    // The first column is the time.
    let all: Vec<Column> = columns(&layout).into_iter().skip(1).filter(|column| !is_omitted(column)).collect();
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
    let (mut analytic_cursor, mut engine_cursor) = (0, 0);
    write_rows(out, &names, [scene.log.numeric_hz, analytic.outcome.last.time_s], |t| {
        Some([
            values(&analytic.interpolate(t, &mut analytic_cursor)?),
            values(&engine.interpolate(t, &mut engine_cursor)?),
        ])
    })
}

/// Writes the values of both models at every multiple of 1/`numeric_hz` and at `end_s`. `values_at` returns the values
/// at a time.
fn write_rows(
    out: &mut impl Write,
    names: &[String],
    [numeric_hz, end_s]: [f64; 2],
    mut values_at: impl FnMut(f64) -> Option<[Vec<f64>; 2]>,
) -> io::Result<()> {
    let headers = names.iter().map(|name| format!(",{name}_analytic,{name}_engine"));
    writeln!(out, "time_s{}", headers.collect::<String>())?;
    let mut index = 0_u64;
    loop {
        let time_s = (index as f64 / numeric_hz).min(end_s);
        let Some([analytic, engine]) = values_at(time_s) else { return Ok(()) };
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
