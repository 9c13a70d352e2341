//! Both models side by side, and how far they are apart.

use super::super::contacts::{Contacts, SurfaceReport};
use super::super::named::Named;
use super::super::states::BodyReport;
use super::differences::{AngleDifference, ContactDifference, DifferencesReport, PlaceDifference};
use super::document::ValidationReport;
use super::figures::{number, percent};
use crate::trace::FingerState;
use crate::units::Dimension;
use crate::validate::turned;
use crate::wording::duration;
use crate::wording::figures::{figure, resolved, row};
use crate::wording::report::{Report, table};

/// The state at the end, the contacts and the energies of both models, and their difference.
pub(super) fn side_by_side(report: &ValidationReport) -> Report {
    let (a, e) = (&report.analytic, &report.engine);
    let end_s = if report.is_of_discs() { report.until_s } else { report.duration_s };
    let mut rows = vec![row([&format!("at {}", duration(end_s)), "analytic", "engine", "difference"])];
    let alone = a.states.fingers.0.len() == 1;
    for (name, ours, theirs) in in_both(&a.states.fingers, &e.states.fingers) {
        rows.extend(finger(name, alone, ours, theirs));
    }
    let moving = in_both(&a.states.bodies, &e.states.bodies).filter(|(_, ours, _)| ours.motion != "fixed");
    for (name, ours, theirs) in moving {
        rows.extend(body(name, report.is_of_discs(), ours, theirs));
    }
    rows.extend(contacts(report, [&a.contacts, &e.contacts]));
    rows.extend(energies(report));
    table(&rows)
}

/// What both models have, by its name.
fn in_both<'a, T>(ours: &'a Named<T>, theirs: &'a Named<T>) -> impl Iterator<Item = (&'a str, &'a T, &'a T)> {
    ours.iter().filter_map(|(name, ours)| Some((name.as_str(), ours, theirs.get(name)?)))
}

/// A figure of both models in SI, and their difference, in a unit of so much; 0 below the resolution of its dimension.
fn resolved_line(name: &str, of: Dimension, scale: f64, values: [f64; 2], digits: usize) -> Vec<String> {
    let [analytic, engine] = values.map(|value| resolved(value, of) * scale);
    line(name, analytic, engine, digits)
}

/// A figure of both models, and their difference.
fn line(name: &str, analytic: f64, engine: f64, digits: usize) -> Vec<String> {
    row([name, &figure(analytic, digits), &figure(engine, digits), &figure(engine - analytic, 3)])
}

/// The same of an angle in rad, whole turns aside, in degrees.
fn angle(name: &str, analytic: f64, engine: f64) -> Vec<String> {
    let (analytic, difference) = (turned(analytic), turned(engine - analytic));
    resolved_line(name, Dimension::Angle, 1f64.to_degrees(), [analytic, analytic + difference], 8)
}

/// Of a finger that is `alone` its rates too.
fn finger(name: &str, alone: bool, ours: &FingerState, theirs: &FingerState) -> Vec<Vec<String>> {
    let called = |what: &str| if alone { what.to_string() } else { format!("{name} {what}") };
    let mut rows = vec![
        angle(&called("q11, deg"), ours.q11_rad, theirs.q11_rad),
        angle(&called("q21, deg"), ours.q21_rad, theirs.q21_rad),
        angle(&called("q22, deg"), ours.q22_rad, theirs.q22_rad),
    ];
    if alone {
        rows.push(line("qd11, rad/s", ours.qd11_rad_s, theirs.qd11_rad_s, 4));
        rows.push(line("qd21, rad/s", ours.qd21_rad_s, theirs.qd21_rad_s, 4));
    }
    rows
}

/// Of a disc its rates, of what is grasped how it is turned.
fn body(name: &str, disc: bool, ours: &BodyReport, theirs: &BodyReport) -> Vec<Vec<String>> {
    let mut rows = vec![
        resolved_line(&format!("{name} x, mm"), Dimension::Length, 1e3, [ours.x_m, theirs.x_m], 8),
        resolved_line(&format!("{name} y, mm"), Dimension::Length, 1e3, [ours.y_m, theirs.y_m], 8),
    ];
    if disc {
        let (speed, spin) = (Dimension::Speed, Dimension::AngularRate);
        rows.push(resolved_line(&format!("{name} vx, m/s"), speed, 1.0, [ours.vx_m_s, theirs.vx_m_s], 6));
        rows.push(resolved_line(&format!("{name} vy, m/s"), speed, 1.0, [ours.vy_m_s, theirs.vy_m_s], 6));
        rows.push(resolved_line(&format!("{name} spin, rad/s"), spin, 1.0, [ours.spin_rad_s, theirs.spin_rad_s], 6));
    } else {
        rows.push(angle(&format!("{name} angle, deg"), ours.angle_rad, theirs.angle_rad));
    }
    rows
}

/// Of a finger that is alone all contacts, otherwise those that touched: what presses in the end, where it touched first, how often
/// and how hard. Discs part again, and how deep they were counts more than what is left of it.
fn contacts(report: &ValidationReport, [ours, theirs]: [&Contacts; 2]) -> Vec<Vec<String>> {
    let alone = report.analytic.states.fingers.0.len() == 1;
    let pairs = ours.surfaces().zip(theirs.surfaces()).map(|((name, ours), (_, theirs))| (name, ours, theirs));
    let mut rows = Vec::new();
    for (name, ours, theirs) in pairs.filter(|(_, a, e)| alone || a.touchdowns > 0 || e.touchdowns > 0) {
        if !report.is_of_discs() {
            rows.push(line(&format!("{name} normal, N"), ours.final_normal_n, theirs.final_normal_n, 7));
            rows.push(line(&format!("{name} friction, N"), ours.final_tangential_n, theirs.final_tangential_n, 4));
        }
        rows.extend(touches(&name, ours, theirs, if report.is_of_discs() { 6 } else { 4 }));
        if report.is_of_discs() {
            let depths = ours.max_penetration_m.zip(theirs.max_penetration_m);
            rows.extend(depths.map(|(own, other)| line(&format!("{name} depth, µm"), own * 1e6, other * 1e6, 6)));
        }
    }
    rows
}

fn touches(name: &str, ours: &SurfaceReport, theirs: &SurfaceReport, digits: usize) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    if let (Some(ours), Some(theirs)) = (ours.first_s, theirs.first_s) {
        rows.push(line(&format!("{name} first touch, ms"), ours * 1e3, theirs * 1e3, 8));
    }
    let touchdowns = |count: u32| count.to_string();
    rows.push(row([&format!("{name} touch-downs"), &touchdowns(ours.touchdowns), &touchdowns(theirs.touchdowns)]));
    rows.push(line(&format!("{name} impulse, mN·s"), ours.impulse_n_s * 1e3, theirs.impulse_n_s * 1e3, 6));
    rows.push(line(&format!("{name} peak, N"), ours.peak_normal_n, theirs.peak_normal_n, digits));
    rows
}

fn energies(report: &ValidationReport) -> [Vec<String>; 4] {
    let (a, e) = (&report.analytic.energy, &report.engine.energy);
    let (work, digits) = if report.is_of_discs() { ("drive work, mJ", 6) } else { ("motor work, mJ", 4) };
    [
        line("kinetic energy, mJ", a.kinetic_j * 1e3, e.kinetic_j * 1e3, digits),
        line("dissipated, mJ", a.dissipated_j * 1e3, e.dissipated_j * 1e3, 6),
        line(work, a.motor_work_j * 1e3, e.motor_work_j * 1e3, 6),
        line("balance, mJ", a.balance_j * 1e3, e.balance_j * 1e3, 3),
    ]
}

/// How far apart they are along the way.
pub(super) fn differences(found: &DifferencesReport) -> Report {
    let mut tables = Vec::new();
    let mut rows = vec![row(JOINTS)];
    for (finger, joints) in found.fingers.iter() {
        let called = |joint: &str| if finger.is_empty() { joint.to_string() } else { format!("{finger} {joint}") };
        rows.extend(joints.iter().map(|(name, of)| joint(&called(name), of)));
    }
    tables.push(rows);
    let mut rows = vec![row(PLACES)];
    rows.extend(found.bodies.iter().map(|(name, of)| place(name, of)));
    tables.push(rows);
    let mut text = Report::join(tables.iter().filter(|rows| rows.len() > 1).map(|rows| table(rows)));
    let forces = pressing(found);
    if forces.len() > 1 {
        text.push(table(&forces));
    }
    let (energy, part) = (figure(found.energy_created_j * 1e3, 3), figure(found.energy_created, 3));
    let of = match found.fingers.0.len() {
        0 => "the largest energy",
        1 => "the motor's work",
        _ => "the motors' work",
    };
    text.push_str(&format!("energy that came from nowhere: {energy} mJ, {part} of {of}\n"));
    text
}

/// Of discs, where nothing is left in the end: what touched, and how hard.
fn pressing(found: &DifferencesReport) -> Vec<Vec<String>> {
    let mut rows = vec![row(["", "first touch, µs", "impulse, %", "peak force, %"])];
    let touching = |of: &ContactDifference, peak: Option<f64>| of.first_touch_s.or(of.impulse).or(peak).is_some();
    for (name, of) in found.contacts.iter() {
        let Some(peak) = of.peak_force else { continue };
        if touching(of, peak) {
            let touch = number(of.first_touch_s.map(|time_s| time_s * 1e6), 3);
            rows.push(row([name, &touch, &percent(of.impulse), &percent(peak)]));
        }
    }
    rows
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

fn place(name: &str, body: &PlaceDifference) -> Vec<String> {
    row([
        name,
        &figure(body.max_m * 1e6, 3),
        &figure(body.max_at_s * 1e3, 5),
        &figure(body.rms_m * 1e6, 3),
        &figure(body.end_m * 1e6, 3),
        &figure(body.angle_end_rad, 3),
    ])
}

const JOINTS: [&str; 6] = ["difference", "max, rad", "at, ms", "RMS, rad", "at the end, rad", "rate RMS, rad/s"];
const PLACES: [&str; 6] = ["difference", "max, µm", "at, ms", "RMS, µm", "at the end, µm", "angle at the end, rad"];
