//! Results of both models side by side, and their differences.

use super::super::contacts::{Contacts, SurfaceReport};
use super::super::named::Named;
use super::super::states::BodyReport;
use super::differences::{AngleDifference, ContactDifference, DifferencesReport, PositionDifference};
use super::document::ValidationReport;
use super::numbers::{number, percent};
use crate::format::format_duration;
use crate::format::numbers::{format_number, row, zero_below_resolution};
use crate::format::report::{Report, table};
use crate::trace::FingerState;
use crate::units::Dimension;
use crate::validate::wrap_angle;

/// Returns a table of the final state, the contacts and the energies of both models, with their differences.
pub(super) fn side_by_side(report: &ValidationReport) -> Report {
    let (a, e) = (&report.analytic, &report.engine);
    let end_s = if report.has_discs_only() { report.until_s } else { report.duration_s };
    let mut rows = vec![row([&format!("at {}", format_duration(end_s)), "analytic", "engine", "difference"])];
    let is_single = a.states.fingers.0.len() == 1;
    for (name, analytic_state, engine_state) in in_both(&a.states.fingers, &e.states.fingers) {
        rows.extend(finger(name, is_single, analytic_state, engine_state));
    }
    let moving =
        in_both(&a.states.bodies, &e.states.bodies).filter(|(_, analytic_state, _)| analytic_state.motion != "fixed");
    for (name, analytic_state, engine_state) in moving {
        rows.extend(body(name, report.has_discs_only(), analytic_state, engine_state));
    }
    rows.extend(contacts(report, [&a.contacts, &e.contacts]));
    rows.extend(energies(report));
    table(&rows)
}

/// Pairs the entries of both models by name.
fn in_both<'a, T>(
    analytic_state: &'a Named<T>,
    engine_state: &'a Named<T>,
) -> impl Iterator<Item = (&'a str, &'a T, &'a T)> {
    analytic_state
        .iter()
        .filter_map(|(name, analytic_state)| Some((name.as_str(), analytic_state, engine_state.get(name)?)))
}

/// Returns a row with a quantity of both models and its difference. SI values are multiplied by `scale`; values below
/// the resolution of their dimension are shown as 0.
fn resolved_line(name: &str, dimension: Dimension, scale: f64, values: [f64; 2], digits: usize) -> Vec<String> {
    let [analytic, engine] = values.map(|value| zero_below_resolution(value, dimension) * scale);
    line(name, analytic, engine, digits)
}

/// Returns a row with a quantity of both models and its difference.
fn line(name: &str, analytic: f64, engine: f64, digits: usize) -> Vec<String> {
    row([name, &format_number(analytic, digits), &format_number(engine, digits), &format_number(engine - analytic, 3)])
}

/// Returns a row with an angle of both models in degrees, modulo a full turn. The arguments are in rad.
fn angle(name: &str, analytic: f64, engine: f64) -> Vec<String> {
    let (analytic, difference) = (wrap_angle(analytic), wrap_angle(engine - analytic));
    resolved_line(name, Dimension::Angle, 1f64.to_degrees(), [analytic, analytic + difference], 8)
}

/// Returns the rows of a finger. They include rates if it is the only finger.
fn finger(name: &str, is_single: bool, analytic_state: &FingerState, engine_state: &FingerState) -> Vec<Vec<String>> {
    let label = |quantity: &str| if is_single { quantity.to_string() } else { format!("{name} {quantity}") };
    let mut rows = vec![
        angle(&label("q11, deg"), analytic_state.q11_rad, engine_state.q11_rad),
        angle(&label("q21, deg"), analytic_state.q21_rad, engine_state.q21_rad),
        angle(&label("q22, deg"), analytic_state.q22_rad, engine_state.q22_rad),
    ];
    if is_single {
        rows.push(line("qd11, rad/s", analytic_state.qd11_rad_s, engine_state.qd11_rad_s, 4));
        rows.push(line("qd21, rad/s", analytic_state.qd21_rad_s, engine_state.qd21_rad_s, 4));
    }
    rows
}

/// Returns the rows of a body: position and rates of a disc, position and angle of a grasped object.
fn body(name: &str, is_disc: bool, analytic_state: &BodyReport, engine_state: &BodyReport) -> Vec<Vec<String>> {
    let mut rows = vec![
        resolved_line(&format!("{name} x, mm"), Dimension::Length, 1e3, [analytic_state.x_m, engine_state.x_m], 8),
        resolved_line(&format!("{name} y, mm"), Dimension::Length, 1e3, [analytic_state.y_m, engine_state.y_m], 8),
    ];
    if is_disc {
        let (speed, spin) = (Dimension::Speed, Dimension::AngularRate);
        rows.push(resolved_line(
            &format!("{name} vx, m/s"),
            speed,
            1.0,
            [analytic_state.vx_m_s, engine_state.vx_m_s],
            6,
        ));
        rows.push(resolved_line(
            &format!("{name} vy, m/s"),
            speed,
            1.0,
            [analytic_state.vy_m_s, engine_state.vy_m_s],
            6,
        ));
        rows.push(resolved_line(
            &format!("{name} spin, rad/s"),
            spin,
            1.0,
            [analytic_state.spin_rad_s, engine_state.spin_rad_s],
            6,
        ));
    } else {
        rows.push(angle(&format!("{name} angle, deg"), analytic_state.angle_rad, engine_state.angle_rad));
    }
    rows
}

/// Returns the rows of the contacts: final forces, first contact, number of touch-downs, impulse and peak force. A single
/// finger shows all contacts, other scenes those that occurred. Discs show the maximum depth instead of the final
/// forces, because they separate again.
fn contacts(report: &ValidationReport, [analytic_state, engine_state]: [&Contacts; 2]) -> Vec<Vec<String>> {
    let is_single_finger = report.analytic.states.fingers.0.len() == 1;
    let pairs = analytic_state
        .surfaces()
        .zip(engine_state.surfaces())
        .map(|((name, analytic_state), (_, engine_state))| (name, analytic_state, engine_state));
    let mut rows = Vec::new();
    for (name, analytic_state, engine_state) in
        pairs.filter(|(_, a, e)| is_single_finger || a.touchdowns > 0 || e.touchdowns > 0)
    {
        if !report.has_discs_only() {
            rows.push(line(
                &format!("{name} normal, N"),
                analytic_state.final_normal_n,
                engine_state.final_normal_n,
                7,
            ));
            rows.push(line(
                &format!("{name} friction, N"),
                analytic_state.final_tangential_n,
                engine_state.final_tangential_n,
                4,
            ));
        }
        rows.extend(contact_summary(&name, analytic_state, engine_state, if report.has_discs_only() { 6 } else { 4 }));
        if report.has_discs_only() {
            let depths = analytic_state.max_penetration_m.zip(engine_state.max_penetration_m);
            rows.extend(depths.map(|(analytic_state, engine_state)| {
                line(&format!("{name} depth, µm"), analytic_state * 1e6, engine_state * 1e6, 6)
            }));
        }
    }
    rows
}

fn contact_summary(
    name: &str,
    analytic_state: &SurfaceReport,
    engine_state: &SurfaceReport,
    digits: usize,
) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    if let (Some(analytic_state), Some(engine_state)) = (analytic_state.first_s, engine_state.first_s) {
        rows.push(line(&format!("{name} first contact, ms"), analytic_state * 1e3, engine_state * 1e3, 8));
    }
    let touchdowns = |count: u32| count.to_string();
    rows.push(row([
        &format!("{name} touch-downs"),
        &touchdowns(analytic_state.touchdowns),
        &touchdowns(engine_state.touchdowns),
    ]));
    rows.push(line(
        &format!("{name} impulse, mN·s"),
        analytic_state.impulse_n_s * 1e3,
        engine_state.impulse_n_s * 1e3,
        6,
    ));
    rows.push(line(&format!("{name} peak, N"), analytic_state.peak_normal_n, engine_state.peak_normal_n, digits));
    rows
}

fn energies(report: &ValidationReport) -> [Vec<String>; 4] {
    let (a, e) = (&report.analytic.energy, &report.engine.energy);
    let (work, digits) = if report.has_discs_only() { ("drive work, mJ", 6) } else { ("motor work, mJ", 4) };
    [
        line("kinetic energy, mJ", a.kinetic_j * 1e3, e.kinetic_j * 1e3, digits),
        line("dissipated, mJ", a.dissipated_j * 1e3, e.dissipated_j * 1e3, 6),
        line(work, a.motor_work_j * 1e3, e.motor_work_j * 1e3, 6),
        line("balance, mJ", a.balance_j * 1e3, e.balance_j * 1e3, 3),
    ]
}

/// Returns tables of the differences over the run.
pub(super) fn differences(found: &DifferencesReport) -> Report {
    let mut tables = Vec::new();
    let mut rows = vec![row(JOINTS)];
    for (finger, joints) in found.fingers.iter() {
        let label = |joint: &str| if finger.is_empty() { joint.to_string() } else { format!("{finger} {joint}") };
        rows.extend(joints.iter().map(|(name, difference)| joint(&label(name), difference)));
    }
    tables.push(rows);
    let mut rows = vec![row(POSITIONS)];
    rows.extend(found.bodies.iter().map(|(name, difference)| body_difference(name, difference)));
    tables.push(rows);
    let mut text = Report::join(tables.iter().filter(|rows| rows.len() > 1).map(|rows| table(rows)));
    let forces = disc_contacts(found);
    if forces.len() > 1 {
        text.push(table(&forces));
    }
    let (energy, ratio) = (format_number(found.energy_created_j * 1e3, 3), format_number(found.energy_created, 3));
    let base = match found.fingers.0.len() {
        0 => "the largest energy",
        1 => "the motor's work",
        _ => "the motors' work",
    };
    text.push_str(&format!("spurious energy: {energy} mJ, {ratio} of {base}\n"));
    text
}

/// Returns the differences of the contacts that occurred in a scene of discs.
fn disc_contacts(found: &DifferencesReport) -> Vec<Vec<String>> {
    let mut rows = vec![row(["", "first contact, µs", "impulse, %", "peak force, %"])];
    let has_contact =
        |contact: &ContactDifference, peak: Option<f64>| contact.first_touch_s.or(contact.impulse).or(peak).is_some();
    for (name, contact) in found.contacts.iter() {
        let Some(peak) = contact.peak_force else { continue };
        if has_contact(contact, peak) {
            let first_touch = number(contact.first_touch_s.map(|time_s| time_s * 1e6), 3);
            rows.push(row([name, &first_touch, &percent(contact.impulse), &percent(peak)]));
        }
    }
    rows
}

fn joint(name: &str, joint: &AngleDifference) -> Vec<String> {
    row([
        name,
        &format_number(joint.max_rad, 3),
        &format_number(joint.max_at_s * 1e3, 5),
        &format_number(joint.rms_rad, 3),
        &format_number(joint.end_rad, 3),
        &format_number(joint.rate_rms_rad_s, 3),
    ])
}

fn body_difference(name: &str, body: &PositionDifference) -> Vec<String> {
    row([
        name,
        &format_number(body.max_m * 1e6, 3),
        &format_number(body.max_at_s * 1e3, 5),
        &format_number(body.rms_m * 1e6, 3),
        &format_number(body.end_m * 1e6, 3),
        &format_number(body.angle_end_rad, 3),
    ])
}

const JOINTS: [&str; 6] = ["difference", "max, rad", "at, ms", "RMS, rad", "at the end, rad", "rate RMS, rad/s"];
const POSITIONS: [&str; 6] = ["difference", "max, µm", "at, ms", "RMS, µm", "at the end, µm", "angle at the end, rad"];
