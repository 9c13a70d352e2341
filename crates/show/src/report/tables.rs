//! Tables in the summaries of runs and of logs.

use super::contacts::Contacts;
use super::grasp::{GraspReport, opening_s};
use super::named::Named;
use super::states::{BodyReport, State, States};
use crate::criteria::{Criteria, CycleCriteria, Fate};
use crate::format::format_duration;
use crate::format::numbers::{format_number, row, zero_below_resolution};
use crate::format::report::{Report, table};
use crate::trace::{Energy, FingerState};
use crate::units::Dimension;

/// Factor from rad to degrees.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// Formats a result in SI units times a factor; a result below the resolution of its dimension is 0.
fn resolved(value_si: f64, dimension: Dimension, factor: f64, digits: usize) -> String {
    format_number(zero_below_resolution(value_si, dimension) * factor, digits)
}

fn or_dash<T>(value: Option<T>, format: impl FnOnce(T) -> String) -> String {
    value.map_or("–".to_string(), format)
}

pub fn milliseconds(time_s: Option<f64>) -> String {
    or_dash(time_s, |time_s| format!("{:.6}", time_s * 1e3))
}

/// Final states of fingers and bodies: a table for each key of the document.
pub fn states(states: &States, end_s: f64) -> Vec<Report> {
    let heading = format!("at {}", format_duration(end_s));
    let state_table = |(key, state): (&str, Option<State<'_>>)| match state? {
        State::Finger(last) => Some(finger(last, &heading)),
        State::Fingers(all) => all.first().map(|_| fingers(all, &heading)),
        State::Body(body) => Some(bodies([(key, body)], &heading)),
        State::Bodies(all) => {
            all.first().map(|_| bodies(all.iter().map(|(name, body)| (name.as_str(), body)), &heading))
        }
    };
    states.entries().into_iter().filter_map(state_table).collect()
}

/// Joint angles, deg, and rates of the driven joints, rad/s.
fn joints(last: &FingerState) -> ([String; 3], [String; 2]) {
    let angles = [last.q11_rad, last.q21_rad, last.q22_rad].map(|angle| format!("{:.6}", angle.to_degrees()));
    (angles, [last.qd11_rad_s, last.qd21_rad_s].map(|rate| resolved(rate, Dimension::AngularRate, 1.0, 5)))
}

fn finger(last: &FingerState, heading: &str) -> Report {
    let ([q11, q21, q22], [qd11, qd21]) = joints(last);
    table(&[
        row([heading, "q11", "q21", "q22"]),
        row(["angle, deg", &q11, &q21, &q22]),
        row(["rate, rad/s", &qd11, &qd21]),
    ])
}

fn fingers(fingers: &Named<FingerState>, heading: &str) -> Report {
    let mut rows = vec![row([heading, "q11, deg", "q21, deg", "q22, deg", "qd11, rad/s", "qd21, rad/s"])];
    for (name, last) in fingers.iter() {
        let ([q11, q21, q22], [qd11, qd21]) = joints(last);
        rows.push(row([&format!("{name} finger"), &q11, &q21, &q22, &qd11, &qd21]));
    }
    table(&rows)
}

fn bodies<'a>(bodies: impl IntoIterator<Item = (&'a str, &'a BodyReport)>, heading: &str) -> Report {
    let mut rows = vec![row([heading, "", "x, mm", "y, mm", "angle, deg", "vx, m/s", "vy, m/s", "spin, rad/s"])];
    for (name, body) in bodies {
        rows.push(row([
            name,
            body.motion,
            &resolved(body.state.centre_m[0], Dimension::Length, 1e3, 7),
            &resolved(body.state.centre_m[1], Dimension::Length, 1e3, 7),
            &resolved(body.state.angle_rad, Dimension::Angle, DEGREES, 6),
            &resolved(body.state.velocity_m_s[0], Dimension::Speed, 1.0, 6),
            &resolved(body.state.velocity_m_s[1], Dimension::Speed, 1.0, 6),
            &resolved(body.state.spin_rad_s, Dimension::AngularRate, 1.0, 6),
        ]));
    }
    table(&rows)
}

/// Table of the contacts; `None` if the scene has none.
pub fn contacts(contacts: &Contacts) -> Option<Report> {
    let has_rebounds = contacts.surfaces().any(|(_, contact)| contact.rebound.is_some());
    let mut surfaces = vec![row([
        "contact",
        "first, ms",
        "touch-downs",
        "normal, N",
        "friction, N",
        "peak, N",
        "depth, µm",
        "impulse, mN·s",
    ])];
    surfaces[0].extend(has_rebounds.then(|| "restitution".to_string()));
    for (name, contact) in contacts.surfaces() {
        let mut cells = row([
            &name,
            &milliseconds(contact.first_s),
            &contact.touchdowns.to_string(),
            &resolved(contact.final_normal_n, Dimension::Force, 1.0, 6),
            &resolved(contact.final_tangential_n, Dimension::Force, 1.0, 6),
            &format_number(contact.peak_normal_n, 5),
            &or_dash(contact.max_penetration_m, |depth_m| format_number(depth_m * 1e6, 5)),
            &format_number(contact.impulse_n_s * 1e3, 5),
        ]);
        cells.extend(
            contact.rebound.map(|rebound| or_dash(rebound.restitution, |restitution| format_number(restitution, 5))),
        );
        surfaces.push(cells);
    }
    let mut limits =
        vec![row(["", "first, ms", "touch-downs", "torque, N·m", "peak, N·m", "depth, µrad", "impulse, mN·m·s"])];
    limits.extend(contacts.limits().map(|(name, contact)| {
        row([
            &name,
            &milliseconds(contact.first_s),
            &contact.touchdowns.to_string(),
            &resolved(contact.final_torque_n_m, Dimension::Torque, 1.0, 6),
            &format_number(contact.peak_torque_n_m, 5),
            &format_number(contact.max_penetration_rad * 1e6, 5),
            &format_number(contact.impulse_n_m_s * 1e3, 5),
        ])
    }));
    let tables = [surfaces, limits].into_iter().filter(|rows| rows.len() > 1);
    let mut text = Report::join(tables.map(|rows| table(&rows)));
    for (name, _) in contacts.surfaces().filter(|(_, contact)| contact.passed_through) {
        text.push(format!(
            "WARNING: {name}: the bodies passed through each other because the steps were too long to detect their contact; use shorter steps.\n"
        ));
    }
    (!text.is_empty()).then_some(text)
}

/// Builds the table of the energies. `has_motor` distinguishes fingers, which have a motor and a spring, from driven
/// discs.
pub fn energies(energy: &Energy, has_motor: bool) -> Report {
    let mut columns = vec![
        ("kinetic", energy.kinetic_j),
        ("gravity", energy.gravity_j),
        ("spring", energy.spring_j),
        ("contact", energy.elastic_j),
        ("dissipated", energy.dissipated_j),
        (if has_motor { "motor work" } else { "drive work" }, energy.motor_work_j),
        ("balance", energy.balance_j),
    ];
    // Energies below the rounding error of the largest one have no valid digits.
    let rounding_j = columns.iter().fold(0.0f64, |most, (_, joule)| most.max(joule.abs())) * f64::EPSILON;
    columns.retain(|(name, _)| has_motor || *name != "spring");
    let (mut names, mut figures) = (row(["energy"]), row(["mJ"]));
    for (name, joule) in columns {
        names.push(name.to_string());
        figures.push(format_number(if joule.abs() < rounding_j { 0.0 } else { joule * 1e3 }, 5));
    }
    table(&[names, figures])
}

pub fn criteria_table(criteria: &Criteria) -> Report {
    let rebound = or_dash(criteria.rebound_percent, |percent| format!("{} %", format_number(percent, 4)));
    table(&[
        row(["criteria", "class", "tts, ms", "rebound", "first in position, ms"]),
        row(["", criteria.class.name(), &milliseconds(criteria.tts_s), &rebound, &milliseconds(criteria.t_geo_s)]),
    ])
    .with(format!("{}\n", criteria.verdict()))
}

/// Fate and criteria of the object of a gripper.
pub fn grasp(report: &GraspReport) -> Report {
    let found = &report.criteria;
    let closed = or_dash(report.form_closed, |closed| if closed { "yes" } else { "no" }.to_string());
    let lost: u32 = found.contacts.iter().map(|contact| contact.times_lost).sum();
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
            found.fate.name(),
            &milliseconds(found.grasped_s),
            &milliseconds(found.tts_s),
            &closed,
            &lost.to_string(),
            &or_dash(found.slip, |slip| resolved(slip.displacement_m, Dimension::Length, 1e3, 4)),
            &or_dash(found.slip, |slip| resolved(slip.rotation_rad, Dimension::Angle, DEGREES, 4)),
        ]),
    ]);
    if let Some(ratio) = found.offset_ratio() {
        let effect = if ratio < 1.0 { "centres" } else { "does not centre" };
        let [start, end] = [found.start, found.end].map(|state| format_number(state.centre_m[0] * 1e3, 4));
        text.push(format!(
            "The grasp {effect} the object: its offset from the middle changes from {start} mm to {end} mm.\n"
        ));
    }
    if let Some(reason) = report.fate_reason.as_ref().filter(|_| found.fate != Fate::Held) {
        let (first, rest) = found.fate.name().split_at(1);
        text.push(format!("{}{rest}: {reason}.\n", first.to_uppercase()));
    }
    if let Some(closure) = report.force_closure {
        let [sum, each] = [closure.q1_l1, closure.q1_linf].map(|quality| format_number(quality, 3));
        text.push(match closure.closed {
            true => {
                format!("Force-closed with friction: Q1 = {sum} (sum of normal forces 1) or {each} (each at most 1).\n")
            }
            false => "Not force-closed, even with friction.\n".to_string(),
        });
    }
    report.cycle().iter().for_each(|cycle| text.push(cycle_text(cycle)));
    text
}

/// Sentences on the transport and the release of the object.
fn cycle_text(cycle: &CycleCriteria) -> String {
    let ms = |time_s: f64| format!("{:.6} ms", time_s * 1e3);
    let mut text = String::new();
    if let Some((from_s, slip)) = cycle.motion_start_s.zip(cycle.motion_travel) {
        let until = cycle.release_s.map_or("to the end".to_string(), |until_s| format!("to {}", ms(until_s)));
        text.push_str(&format!(
            "Transport from {} {until}: the object slips {} µm and rotates {} deg.\n",
            ms(from_s),
            resolved(slip.displacement_m, Dimension::Length, 1e6, 4),
            resolved(slip.rotation_rad, Dimension::Angle, DEGREES, 4)
        ));
    }
    if let Some(max_rad) = cycle.brake_slip_rad.into_iter().flatten().reduce(f64::max) {
        let angle = resolved(max_rad, Dimension::Angle, DEGREES, 4);
        text.push_str(&format!("Blocked driven links rotate by up to {angle} deg.\n"));
    }
    text + &match (cycle.release_s, cycle.opened_s.zip(opening_s(cycle))) {
        (Some(_), Some((opened_s, opening_s))) => format!(
            "Released; the fingers are clear of the object {} later; cycle time {}.\n",
            ms(opening_s),
            ms(opened_s)
        ),
        (Some(released_s), None) => {
            format!("Released at {}; the fingers are not clear of the object at the end.\n", ms(released_s))
        }
        (None, _) => String::new(),
    }
}
