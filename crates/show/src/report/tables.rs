//! Tables in the summaries of runs and of logs.

use super::contacts::Contacts;
use super::grasp::{CycleReport, GraspReport};
use super::named::Named;
use super::states::{BodyReport, State, States};
use crate::criteria::{Criteria, Fate};
use crate::format::format_duration;
use crate::format::numbers::{format_number, row, zero_below_resolution};
use crate::format::report::{Report, table};
use crate::trace::{Energy, FingerState};
use crate::units::Dimension;

/// Final states of fingers and bodies: a table for each key of the document.
pub fn states(states: &States, end_s: f64) -> Vec<Report> {
    let present = states.entries().into_iter().filter_map(|(key, state)| Some((key, state?)));
    let has_rows = |state: &State<'_>| match state {
        State::Fingers(all) => all.first().is_some(),
        State::Bodies(all) => all.first().is_some(),
        State::Finger(_) | State::Body(_) => true,
    };
    present
        .filter(|(_, state)| has_rows(state))
        .map(|(key, state)| match state {
            State::Finger(last) => finger(last, end_s),
            State::Fingers(all) => fingers(all, end_s),
            State::Body(body) => bodies([(key, body)], end_s),
            State::Bodies(all) => bodies(all.iter().map(|(name, body)| (name.as_str(), body)), end_s),
        })
        .collect()
}

/// Converts an angle to degrees; an angle below the resolution becomes 0.
fn to_degrees_resolved(angle_rad: f64) -> f64 {
    zero_below_resolution(angle_rad, Dimension::Angle).to_degrees()
}

fn finger(last: &FingerState, end_s: f64) -> Report {
    let degrees = |angle: f64| format!("{:.6}", angle.to_degrees());
    table(&[
        row([&format!("at {}", format_duration(end_s)), "q11", "q21", "q22"]),
        row(["angle, deg", &degrees(last.q11_rad), &degrees(last.q21_rad), &degrees(last.q22_rad)]),
        row([
            "rate, rad/s",
            &format_number(zero_below_resolution(last.qd11_rad_s, Dimension::AngularRate), 5),
            &format_number(zero_below_resolution(last.qd21_rad_s, Dimension::AngularRate), 5),
        ]),
    ])
}

fn fingers(fingers: &Named<FingerState>, end_s: f64) -> Report {
    let degrees = |angle: f64| format!("{:.6}", angle.to_degrees());
    let heading = format!("at {}", format_duration(end_s));
    let mut rows = vec![row([&heading, "q11, deg", "q21, deg", "q22, deg", "qd11, rad/s", "qd21, rad/s"])];
    for (name, last) in fingers.iter() {
        rows.push(row([
            &format!("{name} finger"),
            &degrees(last.q11_rad),
            &degrees(last.q21_rad),
            &degrees(last.q22_rad),
            &format_number(zero_below_resolution(last.qd11_rad_s, Dimension::AngularRate), 5),
            &format_number(zero_below_resolution(last.qd21_rad_s, Dimension::AngularRate), 5),
        ]));
    }
    table(&rows)
}

fn bodies<'a>(bodies: impl IntoIterator<Item = (&'a str, &'a BodyReport)>, end_s: f64) -> Report {
    let heading = format!("at {}", format_duration(end_s));
    let mut rows = vec![row([&heading, "", "x, mm", "y, mm", "angle, deg", "vx, m/s", "vy, m/s", "spin, rad/s"])];
    for (name, body) in bodies {
        rows.push(row([
            name,
            body.motion,
            &format_number(zero_below_resolution(body.x_m, Dimension::Length) * 1e3, 7),
            &format_number(zero_below_resolution(body.y_m, Dimension::Length) * 1e3, 7),
            &format_number(to_degrees_resolved(body.angle_rad), 6),
            &format_number(zero_below_resolution(body.vx_m_s, Dimension::Speed), 6),
            &format_number(zero_below_resolution(body.vy_m_s, Dimension::Speed), 6),
            &format_number(zero_below_resolution(body.spin_rad_s, Dimension::AngularRate), 6),
        ]));
    }
    table(&rows)
}

/// Table of the contacts; `None` if the scene has none.
pub fn contacts(contacts: &Contacts) -> Option<Report> {
    let rebounds = contacts.surfaces().any(|(_, contact)| contact.rebound.is_some());
    let mut heads = row(SURFACE_HEADER);
    heads.extend(rebounds.then(|| "restitution".to_string()));
    let mut surfaces = vec![heads];
    for (name, contact) in contacts.surfaces() {
        let mut cells = row([
            &name,
            &milliseconds(contact.first_s),
            &contact.touchdowns.to_string(),
            &format_number(zero_below_resolution(contact.final_normal_n, Dimension::Force), 6),
            &format_number(zero_below_resolution(contact.final_tangential_n, Dimension::Force), 6),
            &format_number(contact.peak_normal_n, 5),
            &contact.max_penetration_m.map_or("–".to_string(), |depth_m| format_number(depth_m * 1e6, 5)),
            &format_number(contact.impulse_n_s * 1e3, 5),
        ]);
        let restitution = |ratio: Option<f64>| ratio.map_or("–".to_string(), |ratio| format_number(ratio, 5));
        cells.extend(contact.rebound.map(|rebound| restitution(rebound.restitution)));
        surfaces.push(cells);
    }
    let mut limits = vec![row(LIMIT_HEADER)];
    limits.extend(contacts.limits().map(|(name, contact)| {
        row([
            &name,
            &milliseconds(contact.first_s),
            &contact.touchdowns.to_string(),
            &format_number(zero_below_resolution(contact.final_torque_n_m, Dimension::Torque), 6),
            &format_number(contact.peak_torque_n_m, 5),
            &format_number(contact.max_penetration_rad * 1e6, 5),
            &format_number(contact.impulse_n_m_s * 1e3, 5),
        ])
    }));
    let tables = [surfaces, limits].into_iter().filter(|rows| rows.len() > 1);
    let tables: Vec<Report> = tables.map(|rows| table(&rows)).collect();
    if tables.is_empty() {
        return None;
    }
    let mut text = Report::join(tables);
    for (name, _) in contacts.surfaces().filter(|(_, contact)| contact.passed_through) {
        text.push_str(&format!(
            "WARNING: {name}: the bodies passed through each other because the steps were too long to detect their contact; use shorter steps.\n"
        ));
    }
    Some(text)
}

const SURFACE_HEADER: [&str; 8] =
    ["contact", "first, ms", "touch-downs", "normal, N", "friction, N", "peak, N", "depth, µm", "impulse, mN·s"];
const LIMIT_HEADER: [&str; 7] =
    ["", "first, ms", "touch-downs", "torque, N·m", "peak, N·m", "depth, µrad", "impulse, mN·m·s"];

/// Builds the table of the energies. `has_motor` distinguishes fingers, which have a motor and a spring, from driven
/// discs.
pub fn energies(energy: &Energy, has_motor: bool) -> Report {
    let spring = |cell: &str| has_motor.then(|| cell.to_string());
    let line = |first: &str, [kinetic, gravity, spring_of, rest @ ..]: [&str; 7]| {
        let spring = spring(spring_of);
        let cells = [first, kinetic, gravity].into_iter().map(String::from).chain(spring);
        cells.chain(rest.map(String::from)).collect::<Vec<String>>()
    };
    let work = if has_motor { "motor work" } else { "drive work" };
    let figures = [
        energy.kinetic_j,
        energy.gravity_j,
        energy.spring_j,
        energy.elastic_j,
        energy.dissipated_j,
        energy.motor_work_j,
        energy.balance_j,
    ];
    // Energies below the rounding error of the largest one have no valid digits.
    let rounding_j = figures.iter().fold(0.0f64, |most, joule| most.max(joule.abs())) * f64::EPSILON;
    let figures = figures.map(|joule| format_number(if joule.abs() < rounding_j { 0.0 } else { joule * 1e3 }, 5));
    table(&[
        line("energy", ["kinetic", "gravity", "spring", "contact", "dissipated", work, "balance"]),
        line("mJ", figures.each_ref().map(String::as_str)),
    ])
}

pub fn criteria_table(criteria: &Criteria) -> Report {
    let rebound = match criteria.rebound_percent {
        Some(percent) => format!("{} %", format_number(percent, 4)),
        None => "–".to_string(),
    };
    let mut text = table(&[
        row(["criteria", "class", "tts, ms", "rebound", "first in position, ms"]),
        row(["", criteria.class.name(), &milliseconds(criteria.tts_s), &rebound, &milliseconds(criteria.t_geo_s)]),
    ]);
    text.push_str(&format!("{}\n", criteria.verdict()));
    text
}

/// Fate and criteria of the object of a gripper.
pub fn grasp(report: &GraspReport) -> Report {
    let closed = match report.form_closed {
        Some(true) => "yes",
        Some(false) => "no",
        None => "–",
    };
    let [displacement, rotation] = match report.slip {
        Some(slip) => [
            format_number(zero_below_resolution(slip.displacement_m, Dimension::Length) * 1e3, 4),
            format_number(to_degrees_resolved(slip.rotation_rad), 4),
        ],
        None => ["–".to_string(), "–".to_string()],
    };
    let lost: u32 = report.contacts.iter().map(|(_, contact)| contact.times_lost).sum();
    let mut text = table(&[
        row([
            "grasp",
            "first held, ms",
            "tts, ms",
            "form-closed",
            "contacts lost",
            "slip after tts, mm",
            "rotation, deg",
        ]),
        row([
            report.fate,
            &milliseconds(report.grasped_s),
            &milliseconds(report.tts_s),
            closed,
            &lost.to_string(),
            &displacement,
            &rotation,
        ]),
    ]);
    if let Some(ratio) = report.offset_ratio {
        let (start, end) = (report.x_start_m * 1e3, report.x_end_m * 1e3);
        let what = if ratio < 1.0 { "centres" } else { "does not centre" };
        text.push_str(&format!(
            "The grasp {what} the object: its offset from the middle changes from {} mm to {} mm.\n",
            format_number(start, 4),
            format_number(end, 4)
        ));
    }
    if let Some(reason) = report.fate_reason.as_ref().filter(|_| report.fate != Fate::Held.name()) {
        let fate = report.fate;
        text.push_str(&format!("{}{}: {reason}.\n", fate[..1].to_uppercase(), &fate[1..]));
    }
    if let Some(closure) = report.force_closure {
        let (one, each) = (format_number(closure.q1_l1, 3), format_number(closure.q1_linf, 3));
        text.push_str(&match closure.closed {
            true => {
                format!("Force-closed with friction: Q1 = {one} (sum of normal forces 1) or {each} (each at most 1).\n")
            }
            false => "Not force-closed, even with friction.\n".to_string(),
        });
    }
    report.cycle.iter().for_each(|cycle| text.push_str(&cycle_text(cycle)));
    text
}

/// Sentences on the transport and the release of the object.
fn cycle_text(cycle: &CycleReport) -> String {
    let mut text = String::new();
    if let Some((from_s, slip)) = cycle.motion_start_s.zip(cycle.motion_travel) {
        let until = cycle
            .release_s
            .map_or("to the end".to_string(), |until_s| format!("to {} ms", milliseconds(Some(until_s))));
        let (slip, turn) = (
            format_number(zero_below_resolution(slip.displacement_m, Dimension::Length) * 1e6, 4),
            format_number(to_degrees_resolved(slip.rotation_rad), 4),
        );
        text.push_str(&format!(
            "Transport from {} ms {until}: the object slips {slip} µm and rotates {turn} deg.\n",
            milliseconds(Some(from_s))
        ));
    }
    if let Some(max_rad) = cycle.brake_slip_rad.into_iter().flatten().reduce(f64::max) {
        text.push_str(&format!(
            "Blocked driven links rotate by up to {} deg.\n",
            format_number(to_degrees_resolved(max_rad), 4)
        ));
    }
    match (cycle.release_s, cycle.opened_s.zip(cycle.opening_s)) {
        (Some(_), Some((opened_s, opening_s))) => {
            let [opening, cycle] = [opening_s, opened_s].map(|time_s| milliseconds(Some(time_s)));
            text.push_str(&format!(
                "Released; the fingers are clear of the object {opening} ms later; cycle time {cycle} ms.\n"
            ));
        }
        (Some(released_s), None) => {
            text.push_str(&format!(
                "Released at {} ms; the fingers are not clear of the object at the end.\n",
                milliseconds(Some(released_s))
            ));
        }
        (None, _) => {}
    }
    text
}

pub fn milliseconds(time_s: Option<f64>) -> String {
    time_s.map_or("–".to_string(), |time_s| format!("{:.6}", time_s * 1e3))
}
