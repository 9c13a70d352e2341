//! Time series of both models on a common grid, as comma-separated values.

use std::io::{self, Write};

use super::super::samples::cell;
use crate::scene::Scene;
use crate::scene::keywords::SceneKind;
use crate::trace::Channel;
use crate::trace::{Sample, Schema};
use crate::validate::{Recording, wrap_angle};

/// The columns of a single finger, in their order.
const FINGER_COLUMNS: [&str; 15] = [
    "q11_rad",
    "q21_rad",
    "q22_rad",
    "qd11_rad_s",
    "qd21_rad_s",
    "qd22_rad_s",
    "proximal_gap_m",
    "distal_gap_m",
    "proximal_normal_n",
    "distal_normal_n",
    "proximal_tangential_n",
    "distal_tangential_n",
    "limit_torque_n_m",
    "kinetic_j",
    "balance_j",
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
/// Each quantity in SI units has two columns, with the suffixes `_analytic` and `_engine`. A finger has angles between
/// −π and π, rates, gaps, forces and energies; scenes of discs have positions and rates of every disc, gap and forces of
/// every pair, and energies; a gripper has all quantities of a sample. Quantities of a contact without an object are
/// empty.
pub(crate) fn write_series(out: &mut impl Write, scene: &Scene, [analytic, engine]: [&Recording; 2]) -> io::Result<()> {
    let is_finger = scene.kind() == SceneKind::Finger;
    // The first column is the time.
    let all = Schema::from_system(&scene.system).channels().into_iter().skip(1);
    let all: Vec<Channel> = match scene.kind() {
        SceneKind::Finger => {
            let position = |column: &Channel| FINGER_COLUMNS.iter().position(|name| *name == column.name);
            let mut shown: Vec<Channel> = all.filter(|column| position(column).is_some()).collect();
            shown.sort_by_key(position);
            shown
        }
        SceneKind::Bodies => {
            all.filter(|column| !OMITTED_FOR_DISCS.iter().any(|suffix| column.name.ends_with(suffix))).collect()
        }
        SceneKind::Gripper => all.collect(),
    };
    let value = |column: &Channel, sample: &Sample| match column.value(sample) {
        angle_rad if is_finger && column.name.starts_with('q') && column.name.ends_with("_rad") => {
            wrap_angle(angle_rad)
        }
        value => value,
    };
    let headers = all.iter().map(|Channel { name, .. }| format!(",{name}_analytic,{name}_engine"));
    writeln!(out, "time_s{}", headers.collect::<String>())?;
    let (numeric_hz, end_s) = (scene.log.numeric_hz, analytic.outcome.last.time_s);
    let mut cursors = [0, 0];
    for index in 0_u64.. {
        let time_s = (index as f64 / numeric_hz).min(end_s);
        let samples = (analytic.interpolate(time_s, &mut cursors[0]), engine.interpolate(time_s, &mut cursors[1]));
        let (Some(analytic), Some(engine)) = samples else { break };
        write!(out, "{time_s:?}")?;
        for column in &all {
            write!(out, ",{},{}", cell(value(column, &analytic)), cell(value(column, &engine)))?;
        }
        writeln!(out)?;
        if time_s >= end_s {
            break;
        }
    }
    Ok(())
}
