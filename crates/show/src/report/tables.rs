//! The tables that summaries of runs and of logs are made of.

use super::contacts::Contacts;
use super::grasp::{CycleReport, GraspReport};
use super::named::Named;
use super::states::{BodyReport, State, States};
use crate::criteria::{Criteria, Fate};
use crate::trace::{Energy, FingerState};
use crate::units::Dimension;
use crate::wording::duration;
use crate::wording::figures::{figure, resolved, row};
use crate::wording::report::{Report, table};

/// What moves, as it is at the end: a table for each key of the document.
pub fn states(states: &States, end_s: f64) -> Vec<Report> {
    let told = states.entries().into_iter().filter_map(|(key, state)| Some((key, state?)));
    let is_some = |state: &State<'_>| match state {
        State::Fingers(all) => all.first().is_some(),
        State::Bodies(all) => all.first().is_some(),
        State::Finger(_) | State::Body(_) => true,
    };
    told.filter(|(_, state)| is_some(state))
        .map(|(key, state)| match state {
            State::Finger(last) => finger(last, end_s),
            State::Fingers(all) => fingers(all, end_s),
            State::Body(body) => bodies([(key, body)], end_s),
            State::Bodies(all) => bodies(all.iter().map(|(name, body)| (name.as_str(), body)), end_s),
        })
        .collect()
}

/// An angle in degrees.
fn turned(angle_rad: f64) -> f64 {
    resolved(angle_rad, Dimension::Angle).to_degrees()
}

fn finger(last: &FingerState, end_s: f64) -> Report {
    let degrees = |angle: f64| format!("{:.6}", angle.to_degrees());
    table(&[
        row([&format!("at {}", duration(end_s)), "q11", "q21", "q22"]),
        row(["angle, deg", &degrees(last.q11_rad), &degrees(last.q21_rad), &degrees(last.q22_rad)]),
        row([
            "rate, rad/s",
            &figure(resolved(last.qd11_rad_s, Dimension::AngularRate), 5),
            &figure(resolved(last.qd21_rad_s, Dimension::AngularRate), 5),
        ]),
    ])
}

fn fingers(fingers: &Named<FingerState>, end_s: f64) -> Report {
    let degrees = |angle: f64| format!("{:.6}", angle.to_degrees());
    let at = format!("at {}", duration(end_s));
    let mut rows = vec![row([&at, "q11, deg", "q21, deg", "q22, deg", "qd11, rad/s", "qd21, rad/s"])];
    for (name, last) in fingers.iter() {
        rows.push(row([
            &format!("{name} finger"),
            &degrees(last.q11_rad),
            &degrees(last.q21_rad),
            &degrees(last.q22_rad),
            &figure(resolved(last.qd11_rad_s, Dimension::AngularRate), 5),
            &figure(resolved(last.qd21_rad_s, Dimension::AngularRate), 5),
        ]));
    }
    table(&rows)
}

fn bodies<'a>(bodies: impl IntoIterator<Item = (&'a str, &'a BodyReport)>, end_s: f64) -> Report {
    let at = format!("at {}", duration(end_s));
    let mut rows = vec![row([&at, "", "x, mm", "y, mm", "angle, deg", "vx, m/s", "vy, m/s", "spin, rad/s"])];
    for (name, body) in bodies {
        rows.push(row([
            name,
            body.motion,
            &figure(resolved(body.x_m, Dimension::Length) * 1e3, 7),
            &figure(resolved(body.y_m, Dimension::Length) * 1e3, 7),
            &figure(turned(body.angle_rad), 6),
            &figure(resolved(body.vx_m_s, Dimension::Speed), 6),
            &figure(resolved(body.vy_m_s, Dimension::Speed), 6),
            &figure(resolved(body.spin_rad_s, Dimension::AngularRate), 6),
        ]));
    }
    table(&rows)
}

/// `None` where nothing can touch.
pub fn contacts(contacts: &Contacts) -> Option<Report> {
    let rebounds = contacts.surfaces().any(|(_, of)| of.rebound.is_some());
    let mut heads = row(SURFACES);
    heads.extend(rebounds.then(|| "restitution".to_string()));
    let mut surfaces = vec![heads];
    for (name, of) in contacts.surfaces() {
        let mut cells = row([
            &name,
            &milliseconds(of.first_s),
            &of.touchdowns.to_string(),
            &figure(resolved(of.final_normal_n, Dimension::Force), 6),
            &figure(resolved(of.final_tangential_n, Dimension::Force), 6),
            &figure(of.peak_normal_n, 5),
            &of.max_penetration_m.map_or("–".to_string(), |depth_m| figure(depth_m * 1e6, 5)),
            &figure(of.impulse_n_s * 1e3, 5),
        ]);
        let restitution = |ratio: Option<f64>| ratio.map_or("–".to_string(), |ratio| figure(ratio, 5));
        cells.extend(of.rebound.map(|rebound| restitution(rebound.restitution)));
        surfaces.push(cells);
    }
    let mut limits = vec![row(LIMITS)];
    limits.extend(contacts.limits().map(|(name, of)| {
        row([
            &name,
            &milliseconds(of.first_s),
            &of.touchdowns.to_string(),
            &figure(resolved(of.final_torque_n_m, Dimension::Torque), 6),
            &figure(of.peak_torque_n_m, 5),
            &figure(of.max_penetration_rad * 1e6, 5),
            &figure(of.impulse_n_m_s * 1e3, 5),
        ])
    }));
    let tables = [surfaces, limits].into_iter().filter(|rows| rows.len() > 1);
    let tables: Vec<Report> = tables.map(|rows| table(&rows)).collect();
    if tables.is_empty() {
        return None;
    }
    let mut text = Report::join(tables);
    for (name, _) in contacts.surfaces().filter(|(_, of)| of.passed_through) {
        text.push_str(&format!(
            "WARNING: {name}: the bodies passed through each other, for the steps were too long to find their contact; take shorter steps.\n"
        ));
    }
    Some(text)
}

const SURFACES: [&str; 8] =
    ["contact", "first, ms", "touch-downs", "normal, N", "friction, N", "peak, N", "depth, µm", "impulse, mN·s"];
const LIMITS: [&str; 7] =
    ["", "first, ms", "touch-downs", "torque, N·m", "peak, N·m", "depth, µrad", "impulse, mN·m·s"];

/// Of a finger, whose `motor` works against its spring, or of what is driven.
pub fn energies(energy: &Energy, motor: bool) -> Report {
    let spring = |cell: &str| motor.then(|| cell.to_string());
    let line = |first: &str, [kinetic, gravity, spring_of, rest @ ..]: [&str; 7]| {
        let spring = spring(spring_of);
        let cells = [first, kinetic, gravity].into_iter().map(String::from).chain(spring);
        cells.chain(rest.map(String::from)).collect::<Vec<String>>()
    };
    let work = if motor { "motor work" } else { "drive work" };
    let figures = [
        energy.kinetic_j,
        energy.gravity_j,
        energy.spring_j,
        energy.elastic_j,
        energy.dissipated_j,
        energy.motor_work_j,
        energy.balance_j,
    ];
    // Below the rounding of the largest energy there are no digits.
    let rounding_j = figures.iter().fold(0.0f64, |most, joule| most.max(joule.abs())) * f64::EPSILON;
    let figures = figures.map(|joule| figure(if joule.abs() < rounding_j { 0.0 } else { joule * 1e3 }, 5));
    table(&[
        line("energy", ["kinetic", "gravity", "spring", "contact", "dissipated", work, "balance"]),
        line("mJ", figures.each_ref().map(String::as_str)),
    ])
}

pub fn dynamics(criteria: &Criteria) -> Report {
    let rebound = match criteria.rebound_percent {
        Some(percent) => format!("{} %", figure(percent, 4)),
        None => "–".to_string(),
    };
    let mut text = table(&[
        row(["criteria", "class", "tts, ms", "rebound", "in position first, ms"]),
        row(["", criteria.class.name(), &milliseconds(criteria.tts_s), &rebound, &milliseconds(criteria.t_geo_s)]),
    ]);
    text.push_str(&format!("{}\n", criteria.verdict()));
    text
}

/// What became of the object of a gripper.
pub fn grasp(report: &GraspReport) -> Report {
    let closed = match report.form_closed {
        Some(true) => "yes",
        Some(false) => "no",
        None => "–",
    };
    let [displacement, rotation] = match report.slip {
        Some(slip) => {
            [figure(resolved(slip.displacement_m, Dimension::Length) * 1e3, 4), figure(turned(slip.rotation_rad), 4)]
        }
        None => ["–".to_string(), "–".to_string()],
    };
    let lost: u32 = report.contacts.iter().map(|(_, contact)| contact.times_lost).sum();
    let mut text = table(&[
        row(["grasp", "held first, ms", "tts, ms", "form-closed", "contacts lost", "slip since, mm", "turn, deg"]),
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
            "The grasp {what} the object: from {} mm off the middle to {} mm.\n",
            figure(start, 4),
            figure(end, 4)
        ));
    }
    if let Some(reason) = report.fate_reason.as_ref().filter(|_| report.fate != Fate::Held.name()) {
        let fate = report.fate;
        text.push_str(&format!("{}{}: {reason}.\n", fate[..1].to_uppercase(), &fate[1..]));
    }
    if let Some(closure) = report.force_closure {
        let (one, each) = (figure(closure.q1_l1, 3), figure(closure.q1_linf, 3));
        text.push_str(&match closure.closed {
            true => format!("With friction it is force-closed: Q1 = {one} (normal forces that add up to 1), {each} (of up to 1 each).\n"),
            false => "Not force-closed, even with friction.\n".to_string(),
        });
    }
    report.cycle.iter().for_each(|cycle| text.push_str(&carried(cycle)));
    text
}

/// What a gripper carries, and how it lets go, in words.
fn carried(cycle: &CycleReport) -> String {
    let mut text = String::new();
    if let Some((from_s, slip)) = cycle.carries_s.zip(cycle.carried) {
        let until = cycle
            .releases_s
            .map_or("to the end".to_string(), |until_s| format!("to {} ms", milliseconds(Some(until_s))));
        let (slip, turn) =
            (figure(resolved(slip.displacement_m, Dimension::Length) * 1e6, 4), figure(turned(slip.rotation_rad), 4));
        text.push_str(&format!(
            "Carried from {} ms {until}: slip in the hand {slip} µm and {turn} deg.\n",
            milliseconds(Some(from_s))
        ));
    }
    if let Some(most) = cycle.brake_slip_rad.into_iter().flatten().reduce(f64::max) {
        text.push_str(&format!("Blocked driven links turn by up to {} deg.\n", figure(turned(most), 4)));
    }
    match (cycle.releases_s, cycle.opened_s.zip(cycle.opening_s)) {
        (Some(_), Some((opened_s, opening_s))) => {
            let [opening, cycle] = [opening_s, opened_s].map(|time_s| milliseconds(Some(time_s)));
            text.push_str(&format!("Let go, and clear of the object {opening} ms later: a cycle of {cycle} ms.\n"));
        }
        (Some(released_s), None) => {
            text.push_str(&format!("Let go at {} ms, but not clear of the object.\n", milliseconds(Some(released_s))));
        }
        (None, _) => {}
    }
    text
}

pub fn milliseconds(time_s: Option<f64>) -> String {
    time_s.map_or("–".to_string(), |time_s| format!("{:.6}", time_s * 1e3))
}
