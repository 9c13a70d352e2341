//! Both models side by side, and how far they are apart.

use std::collections::BTreeMap;

use super::super::contacts::{Contacts, FingerContacts, PairReport, PhalanxReport, PlaceReport};
use super::super::discs::DiscReport;
use super::super::named::Named;
use super::differences::{
    AngleDifference, DifferencesReport, DiscDifference, DiscDifferences, GripperDifferences, JointDifferences,
    PairDifference,
};
use super::document::ValidationReport;
use super::figures::{number, percent};
use crate::trace::FingerState;
use crate::validate::turned;
use crate::wording::duration;
use crate::wording::figures::{figure, row};
use crate::wording::report::{Report, table};

/// The state at the end, the contacts and the energies of both models, and their difference.
pub(super) fn side_by_side(report: &ValidationReport) -> Report {
    let (a, e) = (&report.analytic, &report.engine);
    match ((&a.contacts, &e.contacts), (&a.last, &e.last), (&a.discs, &e.discs)) {
        ((Contacts::Finger(ours), Contacts::Finger(theirs)), (Some(last), Some(other)), _) => {
            of_finger(report, [last, other], [ours, theirs])
        }
        ((Contacts::Pairs(ours), Contacts::Pairs(theirs)), _, (Some(discs), Some(others))) => {
            of_discs(report, [discs, others], [ours, theirs])
        }
        ((Contacts::Gripper(ours), Contacts::Gripper(theirs)), ..) => of_gripper(report, [ours, theirs]),
        _ => Report::default(),
    }
}

/// How far apart they are along the way.
pub(super) fn differences(found: &DifferencesReport) -> Report {
    match found {
        DifferencesReport::Finger(found) => of_joints(found),
        DifferencesReport::Discs(found) => of_places(found),
        DifferencesReport::Gripper(found) => of_joints_and_object(found),
    }
}

/// A figure of both models, and their difference.
fn line(name: &str, analytic: f64, engine: f64, digits: usize) -> Vec<String> {
    row([name, &figure(analytic, digits), &figure(engine, digits), &figure(engine - analytic, 3)])
}

/// The same of an angle in rad, whole turns aside, in degrees.
fn angle(name: &str, analytic: f64, engine: f64) -> Vec<String> {
    let (analytic, difference) = (turned(analytic), turned(engine - analytic));
    line(name, analytic.to_degrees(), (analytic + difference).to_degrees(), 8)
}

/// Rows on a contact of a phalanx, or of the object: where it touched first, how often and how hard.
fn touches(name: &str, ours: &PhalanxReport, theirs: &PhalanxReport) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    if let (Some(ours), Some(theirs)) = (ours.first_s, theirs.first_s) {
        rows.push(line(&format!("{name} first touch, ms"), ours * 1e3, theirs * 1e3, 8));
    }
    let touchdowns = |count: u32| count.to_string();
    rows.push(row([&format!("{name} touch-downs"), &touchdowns(ours.touchdowns), &touchdowns(theirs.touchdowns)]));
    rows.push(line(&format!("{name} impulse, mN·s"), ours.impulse_n_s * 1e3, theirs.impulse_n_s * 1e3, 6));
    rows.push(line(&format!("{name} peak, N"), ours.peak_normal_n, theirs.peak_normal_n, 4));
    rows
}

/// Energies of a scene with fingers.
fn energies(report: &ValidationReport) -> [Vec<String>; 4] {
    let (a, e) = (&report.analytic.energy, &report.engine.energy);
    [
        line("kinetic energy, mJ", a.kinetic_j * 1e3, e.kinetic_j * 1e3, 4),
        line("dissipated, mJ", a.dissipated_j * 1e3, e.dissipated_j * 1e3, 6),
        line("motor work, mJ", a.motor_work_j * 1e3, e.motor_work_j * 1e3, 6),
        line("balance, mJ", a.balance_j * 1e3, e.balance_j * 1e3, 3),
    ]
}

/// Both fingers, the object, and the contacts that touch.
fn of_gripper(report: &ValidationReport, [contacts, others]: [&Named<PlaceReport>; 2]) -> Report {
    let (a, e) = (&report.analytic, &report.engine);
    let mut rows = vec![row([&format!("at {}", duration(report.duration_s)), "analytic", "engine", "difference"])];
    for (name, last) in a.fingers.iter().flat_map(Named::iter) {
        let Some(other) = e.fingers.as_ref().and_then(|fingers| fingers.get(name)) else { continue };
        rows.push(angle(&format!("{name} q11, deg"), last.q11_rad, other.q11_rad));
        rows.push(angle(&format!("{name} q21, deg"), last.q21_rad, other.q21_rad));
        rows.push(angle(&format!("{name} q22, deg"), last.q22_rad, other.q22_rad));
    }
    if let (Some(ours), Some(theirs)) = (&a.object, &e.object) {
        rows.push(line("object x, mm", ours.x_m * 1e3, theirs.x_m * 1e3, 8));
        rows.push(line("object y, mm", ours.y_m * 1e3, theirs.y_m * 1e3, 8));
        rows.push(angle("object angle, deg", ours.angle_rad, theirs.angle_rad));
    }
    for (name, place) in contacts.iter() {
        let (PlaceReport::Surface(ours), Some(PlaceReport::Surface(theirs))) = (place, others.get(name)) else {
            continue;
        };
        if ours.touchdowns == 0 && theirs.touchdowns == 0 {
            continue;
        }
        let name = name.replace('_', " ");
        rows.push(line(&format!("{name} normal, N"), ours.final_normal_n, theirs.final_normal_n, 7));
        rows.push(line(&format!("{name} friction, N"), ours.final_tangential_n, theirs.final_tangential_n, 4));
        rows.extend(touches(&name, ours, theirs));
    }
    rows.extend(energies(report));
    table(&rows)
}

fn of_finger(
    report: &ValidationReport,
    [last, other]: [&FingerState; 2],
    [contacts, others]: [&FingerContacts; 2],
) -> Report {
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
        rows.extend(touches(name, ours, theirs));
    }
    rows.extend(energies(report));
    table(&rows)
}

/// Discs that move, pairs that touch, energies: of both models and their difference.
fn of_discs(
    report: &ValidationReport,
    [discs, others]: [&BTreeMap<String, DiscReport>; 2],
    [pairs, their_pairs]: [&BTreeMap<String, PairReport>; 2],
) -> Report {
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
        let Some(theirs) = their_pairs.get(name).map(|pair| &pair.surface) else { continue };
        let ours = &ours.surface;
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

fn joint(name: &str, joint: &AngleDifference) -> Vec<String> {
    row([
        name,
        &figure(joint.max_rad, 3),
        &figure(joint.max_at_s * 1e3, 5),
        &figure(joint.rms_rad, 3),
        &figure(joint.end_rad, 3),
        &figure(joint.rate_rms_rad_s, 3),
    ])
}

fn place(name: &str, disc: &DiscDifference) -> Vec<String> {
    row([
        name,
        &figure(disc.max_m * 1e6, 3),
        &figure(disc.max_at_s * 1e3, 5),
        &figure(disc.rms_m * 1e6, 3),
        &figure(disc.end_m * 1e6, 3),
        &figure(disc.angle_end_rad, 3),
    ])
}

const JOINTS: [&str; 6] = ["difference", "max, rad", "at, ms", "RMS, rad", "at the end, rad", "rate RMS, rad/s"];
const PLACES: [&str; 6] = ["difference", "max, µm", "at, ms", "RMS, µm", "at the end, µm", "angle at the end, rad"];

/// What came from nowhere, and a part of what that is.
fn created(energy_j: f64, part: f64, of: &str) -> String {
    format!("energy that came from nowhere: {} mJ, {} of {of}\n", figure(energy_j * 1e3, 3), figure(part, 3))
}

fn of_joints(found: &JointDifferences) -> Report {
    let mut rows = vec![row(JOINTS)];
    rows.extend(found.joints.iter().map(|(name, of)| joint(name, of)));
    let mut text = table(&rows);
    text.push_str(&created(found.energy_created_j, found.energy_created, "the motor's work"));
    text
}

fn of_joints_and_object(found: &GripperDifferences) -> Report {
    let mut rows = vec![row(JOINTS)];
    for (finger, joints) in found.fingers.iter() {
        rows.extend(joints.iter().map(|(name, of)| joint(&format!("{finger} {name}"), of)));
    }
    let mut text = table(&rows);
    text.push('\n');
    text.push(table(&[row(PLACES), place("object", &found.object)]));
    text.push_str(&created(found.energy_created_j, found.energy_created, "the motors' work"));
    text
}

fn of_places(found: &DiscDifferences) -> Report {
    let mut rows = vec![row(PLACES)];
    rows.extend(found.discs.iter().map(|(name, disc)| place(name, disc)));
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
    text.push_str(&created(found.energy_created_j, found.energy_created, "the largest energy"));
    text
}
