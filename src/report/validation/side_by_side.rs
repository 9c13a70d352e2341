//! Both models side by side, and how far they are apart.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::super::contacts::{Contacts, FingerContacts, PairReport};
use super::super::discs::DiscReport;
use super::super::document::Final;
use super::differences::{DifferencesReport, DiscDifferences, JointDifferences, PairDifference};
use super::document::ValidationReport;
use super::figures::{number, percent};
use crate::validate::turned;
use crate::wording::duration;
use crate::wording::figures::{figure, row};
use crate::wording::sheet::{Sheet, table};

/// The state at the end, the contacts and the energies of both models, and their difference.
pub(super) fn side_by_side(report: &ValidationReport) -> Sheet {
    let (a, e) = (&report.analytic, &report.engine);
    match ((&a.contacts, &e.contacts), (&a.last, &e.last), (&a.discs, &e.discs)) {
        ((Contacts::Finger(ours), Contacts::Finger(theirs)), (Some(last), Some(other)), _) => {
            of_finger(report, [last, other], [ours, theirs])
        }
        ((Contacts::Pairs(ours), Contacts::Pairs(theirs)), _, (Some(discs), Some(others))) => {
            of_discs(report, [discs, others], [ours, theirs])
        }
        _ => Sheet::default(),
    }
}

/// How far apart they are along the way.
pub(super) fn differences(found: &DifferencesReport) -> Sheet {
    match found {
        DifferencesReport::Finger(found) => of_joints(found),
        DifferencesReport::Discs(found) => of_places(found),
    }
}

/// A figure of both models, and their difference.
fn line(name: &str, analytic: f64, engine: f64, digits: usize) -> Vec<String> {
    row([name, &figure(analytic, digits), &figure(engine, digits), &figure(engine - analytic, 3)])
}

fn of_finger(report: &ValidationReport, [last, other]: [&Final; 2], [contacts, others]: [&FingerContacts; 2]) -> Sheet {
    let (a, e) = (&report.analytic, &report.engine);
    let angle = |name: &str, analytic: f64, engine: f64| {
        let (analytic, difference) = (turned(analytic), turned(engine - analytic));
        line(name, analytic.to_degrees(), (analytic + difference).to_degrees(), 8)
    };
    let mut rows = vec![
        row([&format!("at {}", duration(report.duration_s)), "analytic", "engine", "difference"]),
        angle("q11, deg", last.q11_rad, other.q11_rad),
        angle("q21, deg", last.q21_rad, other.q21_rad),
        angle("q22, deg", last.q22_rad, other.q22_rad),
        line("qd11, rad/s", last.qd11_rad_s, other.qd11_rad_s, 4),
        line("qd21, rad/s", last.qd21_rad_s, other.qd21_rad_s, 4),
    ];
    let contacts = [("proximal", &contacts.proximal, &others.proximal), ("distal", &contacts.distal, &others.distal)];
    for (name, ours, theirs) in contacts {
        rows.push(line(&format!("{name} normal, N"), ours.final_normal_n, theirs.final_normal_n, 7));
        rows.push(line(&format!("{name} friction, N"), ours.final_tangential_n, theirs.final_tangential_n, 4));
    }
    for (name, ours, theirs) in contacts {
        if let (Some(ours), Some(theirs)) = (ours.first_s, theirs.first_s) {
            rows.push(line(&format!("{name} first touch, ms"), ours * 1e3, theirs * 1e3, 8));
        }
        let touchdowns = |count: u32| count.to_string();
        rows.push(row([&format!("{name} touch-downs"), &touchdowns(ours.touchdowns), &touchdowns(theirs.touchdowns)]));
        rows.push(line(&format!("{name} impulse, mN·s"), ours.impulse_n_s * 1e3, theirs.impulse_n_s * 1e3, 6));
        rows.push(line(&format!("{name} peak, N"), ours.peak_normal_n, theirs.peak_normal_n, 4));
    }
    rows.push(line("kinetic energy, mJ", a.energy.kinetic_j * 1e3, e.energy.kinetic_j * 1e3, 4));
    rows.push(line("dissipated, mJ", a.energy.dissipated_j * 1e3, e.energy.dissipated_j * 1e3, 6));
    rows.push(line("motor work, mJ", a.energy.motor_work_j * 1e3, e.energy.motor_work_j * 1e3, 6));
    rows.push(line("balance, mJ", a.energy.balance_j * 1e3, e.energy.balance_j * 1e3, 3));
    table(&rows)
}

/// Discs that move, pairs that touch, energies: of both models and their difference.
fn of_discs(
    report: &ValidationReport,
    [discs, others]: [&BTreeMap<String, DiscReport>; 2],
    [pairs, their_pairs]: [&BTreeMap<String, PairReport>; 2],
) -> Sheet {
    let (a, e) = (&report.analytic, &report.engine);
    let mut rows = vec![row([&format!("at {}", duration(report.until_s)), "analytic", "engine", "difference"])];
    for (name, ours) in discs.iter().filter(|(_, disc)| disc.motion != "fixed") {
        let Some(theirs) = others.get(name) else { continue };
        rows.push(line(&format!("{name} x, mm"), ours.x_m * 1e3, theirs.x_m * 1e3, 8));
        rows.push(line(&format!("{name} y, mm"), ours.y_m * 1e3, theirs.y_m * 1e3, 8));
        rows.push(line(&format!("{name} vx, m/s"), ours.vx_m_s, theirs.vx_m_s, 6));
        rows.push(line(&format!("{name} vy, m/s"), ours.vy_m_s, theirs.vy_m_s, 6));
        rows.push(line(&format!("{name} spin, rad/s"), ours.spin_rad_s, theirs.spin_rad_s, 6));
    }
    for (name, ours) in pairs {
        let Some(theirs) = their_pairs.get(name) else { continue };
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

fn of_joints(found: &JointDifferences) -> Sheet {
    let mut rows = vec![row(["difference", "max, rad", "at, ms", "RMS, rad", "at the end, rad", "rate RMS, rad/s"])];
    for (name, joint) in &found.joints {
        rows.push(row([
            name,
            &figure(joint.max_rad, 3),
            &figure(joint.max_at_s * 1e3, 5),
            &figure(joint.rms_rad, 3),
            &figure(joint.end_rad, 3),
            &figure(joint.rate_rms_rad_s, 3),
        ]));
    }
    let mut text = table(&rows);
    let _ = writeln!(
        text,
        "energy that came from nowhere: {} mJ, {} of the motor's work",
        figure(found.energy_created_j * 1e3, 3),
        figure(found.energy_created, 3)
    );
    text
}

fn of_places(found: &DiscDifferences) -> Sheet {
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
    let touching = |pair: &PairDifference| pair.first_touch_s.or(pair.impulse).or(pair.peak_force).is_some();
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
