//! The report of a validation of discs for people: short tables with units.

use std::fmt::Write;

use super::bodies_document::{BodiesModelReport, BodiesValidationReport, DiscDifferences, DiscErrors};
use super::text::{Columns, Heading, broken, checks, cost_of, heading, number, percent, settings};
use crate::wording::duration;
use crate::wording::figures::{figure, row};
use crate::wording::sheet::{Sheet, table};

/// The whole report, with a line end.
pub fn bodies_validation_text(report: &BodiesValidationReport) -> Sheet {
    let model = |model: &BodiesModelReport| cost_of(&model.setting, model.steps, model.wall_s);
    let heading = heading(&Heading {
        scene: &report.scene,
        passed: report.passed,
        analytic: model(&report.analytic),
        engine: model(&report.engine),
        until_s: report.until_s,
        duration_s: report.duration_s,
        ensemble_runs: report.ensemble_runs,
        ensemble_step: report.ensemble_speed_step,
        apart: "speeds and gravity",
        directory: report.directory.as_deref(),
        files: report.files.as_deref(),
    });
    let left_out = report.quick.then_some("fixed steps below 1e-5 s");
    let mut sections = vec![Sheet::from(heading), checks(&report.verdict)];
    let broken = broken([("analytic", &report.analytic.invariants), ("engine", &report.engine.invariants)]);
    if !broken.is_empty() {
        sections.push(Sheet::from(broken));
    }
    sections.push(side_by_side(report));
    sections.push(differences(&report.differences));
    sections.push(settings(&report.settings, &columns(), left_out));
    Sheet::join(sections)
}

/// Discs that move, pairs that touch, energies: of both models and their difference.
fn side_by_side(report: &BodiesValidationReport) -> Sheet {
    let (a, e) = (&report.analytic, &report.engine);
    let line = |name: &str, analytic: f64, engine: f64, digits: usize| {
        row([name, &figure(analytic, digits), &figure(engine, digits), &figure(engine - analytic, 3)])
    };
    let mut rows = vec![row([&format!("at {}", duration(report.until_s)), "analytic", "engine", "difference"])];
    for (name, ours) in a.discs.iter().filter(|(_, disc)| disc.motion != "fixed") {
        let Some(theirs) = e.discs.get(name) else { continue };
        rows.push(line(&format!("{name} x, mm"), ours.x_m * 1e3, theirs.x_m * 1e3, 8));
        rows.push(line(&format!("{name} y, mm"), ours.y_m * 1e3, theirs.y_m * 1e3, 8));
        rows.push(line(&format!("{name} vx, m/s"), ours.vx_m_s, theirs.vx_m_s, 6));
        rows.push(line(&format!("{name} vy, m/s"), ours.vy_m_s, theirs.vy_m_s, 6));
        rows.push(line(&format!("{name} spin, rad/s"), ours.spin_rad_s, theirs.spin_rad_s, 6));
    }
    for (name, ours) in &a.contacts {
        let Some(theirs) = e.contacts.get(name) else { continue };
        if ours.touchdowns == 0 && theirs.touchdowns == 0 {
            continue;
        }
        if let (Some(ours), Some(theirs)) = (ours.first_s, theirs.first_s) {
            rows.push(line(&format!("{name} first touch, ms"), ours * 1e3, theirs * 1e3, 8));
        }
        let (own, other) = (ours.touchdowns.to_string(), theirs.touchdowns.to_string());
        rows.push(row([&format!("{name} touch-downs"), &own, &other]));
        rows.push(line(&format!("{name} impulse, mN·s"), ours.impulse_n_s * 1e3, theirs.impulse_n_s * 1e3, 6));
        rows.push(line(&format!("{name} peak, N"), ours.peak_normal_n, theirs.peak_normal_n, 6));
        let micrometres = |metres: f64| metres * 1e6;
        let depths = [ours.max_penetration_m, theirs.max_penetration_m].map(micrometres);
        rows.push(line(&format!("{name} depth, µm"), depths[0], depths[1], 6));
    }
    rows.push(line("kinetic energy, mJ", a.energy.kinetic_j * 1e3, e.energy.kinetic_j * 1e3, 6));
    rows.push(line("dissipated, mJ", a.energy.dissipated_j * 1e3, e.energy.dissipated_j * 1e3, 6));
    rows.push(line("drive work, mJ", a.energy.motor_work_j * 1e3, e.energy.motor_work_j * 1e3, 6));
    rows.push(line("balance, mJ", a.energy.balance_j * 1e3, e.energy.balance_j * 1e3, 3));
    table(&rows)
}

fn differences(found: &DiscDifferences) -> Sheet {
    let mut rows = vec![row(["difference", "max, µm", "at, ms", "RMS, µm", "at the end, µm", "angle at the end, rad"])];
    for (name, disc) in &found.discs {
        rows.push(row([
            name,
            &figure(disc.max_m * 1e6, 3),
            &figure(disc.max_at_s * 1e3, 5),
            &figure(disc.rms_m * 1e6, 3),
            &figure(disc.end_m * 1e6, 3),
            &figure(disc.angle_end_rad, 3),
        ]));
    }
    let mut text = table(&rows);
    let mut rows = vec![row(["", "first touch, µs", "impulse, %", "peak force, %"])];
    let touching = |pair: &super::PairDifference| pair.first_touch_s.or(pair.impulse).or(pair.peak_force).is_some();
    for (name, pair) in found.pairs.iter().filter(|(_, pair)| touching(pair)) {
        let touch = number(pair.first_touch_s.map(|time_s| time_s * 1e6), 3);
        rows.push(row([name, &touch, &percent(pair.impulse), &percent(pair.peak_force)]));
    }
    if rows.len() > 1 {
        text.push(table(&rows));
    }
    let _ = writeln!(
        text,
        "energy that came from nowhere: {} mJ, {} of the largest energy",
        figure(found.energy_created_j * 1e3, 3),
        figure(found.energy_created, 3)
    );
    text
}

fn columns() -> Columns<DiscErrors, 5> {
    Columns {
        heads: [["place,", "touch,", "impulse,", "peak,", "energy,"], ["µm", "µs", "%", "%", "%"]],
        cells: |errors| {
            [
                number(errors.position_max_m.map(|metres| metres * 1e6), 2),
                number(errors.first_touch_s.map(|time_s| time_s * 1e6), 2),
                percent(errors.impulse),
                percent(errors.peak_force),
                percent(errors.energy_created),
            ]
        },
    }
}
