//! Tables in the summaries of runs and of logs.

use super::contacts::{Contacts, SurfaceReport};
use super::named::Named;
use super::states::{BodyReport, JointReport, State, States};
use crate::criteria::{CableEvent, CableEventKind, Criteria};
use crate::format::format_duration;
use crate::format::numbers::{format_number, or_dash, row, zero_below_resolution};
use crate::format::report::{Column, Report, table, table_of};
use crate::trace::{Energy, FingerState};
use crate::units::Dimension;

/// Factor from rad to degrees.
pub(super) const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// Formats a result in SI units times a factor; a result below the resolution of its dimension is 0.
pub(super) fn resolved(value_si: f64, dimension: Dimension, factor: f64, digits: usize) -> String {
    format_number(zero_below_resolution(value_si, dimension) * factor, digits)
}

pub fn milliseconds(time_s: Option<f64>) -> String {
    or_dash(time_s, |time_s| format!("{:.6}", time_s * 1e3))
}

/// Tables of the final states of fingers and bodies, one for each key of the document.
pub fn states(states: &States, end_s: f64) -> Vec<Report> {
    let heading = format!("at {}", format_duration(end_s));
    let state_table = |(key, state): (&str, Option<State<'_>>)| match state? {
        State::Finger(last) => Some(finger(last, &heading)),
        State::Fingers(all) => all.first().map(|_| fingers(all, &heading)),
        State::Body(body) => Some(bodies([(key, body)], &heading)),
        State::Bodies(all) => {
            all.first().map(|_| bodies(all.iter().map(|(name, body)| (name.as_str(), body)), &heading))
        }
        State::Joints(all) => {
            let (sliders, others): (Vec<_>, Vec<_>) = all.iter().partition(|(_, joint)| is_slider(joint));
            // Drives have different quantities.
            let keys = |joint: &JointReport| joint.0.iter().map(|(quantity, _)| quantity.key).collect::<Vec<_>>();
            let groups = [others, sliders].into_iter().flat_map(|mut group| {
                group.sort_by_key(|(_, joint)| keys(joint));
                let parts = group.chunk_by(|(_, a), (_, b)| keys(a) == keys(b));
                parts.map(|part| joint_table(part, &heading).into()).collect::<Vec<_>>()
            });
            Some(Report::join(groups))
        }
    };
    states.entries().into_iter().filter_map(state_table).collect()
}

/// Final states of some bodies.
pub(super) fn bodies_of(all: &[(&str, &BodyReport)], end_s: f64) -> Report {
    let heading = format!("at {}", format_duration(end_s));
    if all.is_empty() { Report::default() } else { bodies(all.iter().copied(), &heading) }
}

fn is_slider(joint: &JointReport) -> bool {
    joint.0.iter().any(|(quantity, _)| ["position_m", "force_n"].contains(&quantity.key))
}

/// Quantities of joints, actuators or tendons of the same kind; `None` without any.
fn joint_table(all: &[&(String, JointReport)], heading: &str) -> Option<Report> {
    let (_, first) = all.first()?;
    let unit = |unit: &'static str| match unit {
        "rad" => ("deg", DEGREES),
        "m" => ("mm", 1e3),
        other => (other, 1.0),
    };
    let mut head = row([heading]);
    head.extend(first.0.iter().map(|(quantity, _)| {
        let word = quantity.key.split('_').next().unwrap_or_default();
        let axis = ["_x_", "_y_"].into_iter().find(|axis| quantity.key.contains(axis)).unwrap_or("_");
        format!("{word}{}, {}", axis.trim_end_matches('_').replace('_', " "), unit(quantity.unit).0)
    }));
    let mut rows = vec![head];
    for (name, joint) in all {
        let values = joint.0.iter().map(|(quantity, value)| format_number(value * unit(quantity.unit).1, 7));
        rows.push([name.clone()].into_iter().chain(values).collect());
    }
    Some(table(&rows))
}

/// Joint angles, deg, and rates of the driven joints, rad/s.
fn joints(last: &FingerState) -> [String; 5] {
    let [q11, q21, q22] = [last.q11_rad, last.q21_rad, last.q22_rad].map(|rad| format!("{:.6}", rad.to_degrees()));
    let [qd11, qd21] = [last.qd11_rad_s, last.qd21_rad_s].map(|rate| resolved(rate, Dimension::AngularRate, 1.0, 5));
    [q11, q21, q22, qd11, qd21]
}

fn finger(last: &FingerState, heading: &str) -> Report {
    let [q11, q21, q22, qd11, qd21] = joints(last);
    table(&[
        row([heading, "q11", "q21", "q22"]),
        row(["angle, deg", &q11, &q21, &q22]),
        row(["rate, rad/s", &qd11, &qd21]),
    ])
}

fn fingers(fingers: &Named<FingerState>, heading: &str) -> Report {
    let mut rows = vec![row([heading, "q11, deg", "q21, deg", "q22, deg", "qd11, rad/s", "qd21, rad/s"])];
    rows.extend(fingers.iter().map(|(name, last)| [&[format!("{name} finger")], &joints(last)[..]].concat()));
    table(&rows)
}

fn bodies<'a>(bodies: impl IntoIterator<Item = (&'a str, &'a BodyReport)>, heading: &str) -> Report {
    table_of(
        bodies,
        &[
            (heading, &|(name, _)| name.to_string()),
            ("", &|(_, body)| body.motion.to_string()),
            ("x, mm", &|(_, body)| resolved(body.state.centre_m[0], Dimension::Length, 1e3, 7)),
            ("y, mm", &|(_, body)| resolved(body.state.centre_m[1], Dimension::Length, 1e3, 7)),
            ("angle, deg", &|(_, body)| resolved(body.state.angle_rad, Dimension::Angle, DEGREES, 6)),
            ("vx, m/s", &|(_, body)| resolved(body.state.velocity_m_s[0], Dimension::Speed, 1.0, 6)),
            ("vy, m/s", &|(_, body)| resolved(body.state.velocity_m_s[1], Dimension::Speed, 1.0, 6)),
            ("spin, rad/s", &|(_, body)| resolved(body.state.spin_rad_s, Dimension::AngularRate, 1.0, 6)),
        ],
    )
}

/// Tables of the contacts; empty if the scene has none.
pub fn contacts(contacts: &Contacts) -> Report {
    let (surfaces, limits): (Vec<_>, Vec<_>) = (contacts.surfaces().collect(), contacts.limits().collect());
    let restitution = |contact: &SurfaceReport| {
        contact.rebound.map_or(String::new(), |rebound| or_dash(rebound.restitution, |ratio| format_number(ratio, 5)))
    };
    let columns: [Column<'_, &(String, &SurfaceReport)>; 9] = [
        ("contact", &|(name, _)| name.clone()),
        ("first, ms", &|(_, contact)| milliseconds(contact.first_s)),
        ("touch-downs", &|(_, contact)| contact.touchdowns.to_string()),
        ("normal, N", &|(_, contact)| resolved(contact.final_normal_n, Dimension::Force, 1.0, 6)),
        ("friction, N", &|(_, contact)| resolved(contact.final_tangential_n, Dimension::Force, 1.0, 6)),
        ("peak, N", &|(_, contact)| format_number(contact.peak_normal_n, 5)),
        ("depth, µm", &|(_, contact)| or_dash(contact.max_penetration_m, |depth_m| format_number(depth_m * 1e6, 5))),
        ("impulse, mN·s", &|(_, contact)| format_number(contact.impulse_n_s * 1e3, 5)),
        ("restitution", &|(_, contact)| restitution(contact)),
    ];
    let has_rebounds = surfaces.iter().any(|(_, contact)| contact.rebound.is_some());
    let surface_table = || table_of(&surfaces, if has_rebounds { &columns } else { &columns[..8] });
    let limit_table = || {
        table_of(
            &limits,
            &[
                ("", &|(name, _)| name.clone()),
                ("first, ms", &|(_, contact)| milliseconds(contact.first_s)),
                ("touch-downs", &|(_, contact)| contact.touchdowns.to_string()),
                ("torque, N·m", &|(_, contact)| resolved(contact.final_torque_n_m, Dimension::Torque, 1.0, 6)),
                ("peak, N·m", &|(_, contact)| format_number(contact.peak_torque_n_m, 5)),
                ("depth, µrad", &|(_, contact)| format_number(contact.max_penetration_rad * 1e6, 5)),
                ("impulse, mN·m·s", &|(_, contact)| format_number(contact.impulse_n_m_s * 1e3, 5)),
            ],
        )
    };
    let tables = [surfaces.first().map(|_| surface_table()), limits.first().map(|_| limit_table())];
    let mut text = Report::join(tables.map(Report::from));
    for (name, _) in surfaces.iter().filter(|(_, contact)| contact.passed_through) {
        text.push(format!(
            "WARNING: {name}: the bodies passed through each other because the steps were too long to detect their contact; use shorter steps.\n"
        ));
    }
    text
}

/// Largest number of rows of the table of the events of cables.
const MAX_CABLE_EVENTS: usize = 12;

/// Builds the table of the first events of cables; `None` without any.
pub fn cable_events(events: &[CableEvent]) -> Option<Report> {
    events.first()?;
    let line = |event: &CableEvent| {
        let verb = match event.event {
            CableEventKind::Leaves => "leaves the pulley",
            CableEventKind::Returns => "returns",
        };
        row([&event.place, verb, &milliseconds(Some(event.time_s))])
    };
    let rows: Vec<_> =
        [row(["cable", "", "at, ms"])].into_iter().chain(events.iter().take(MAX_CABLE_EVENTS).map(line)).collect();
    let more = events.len().saturating_sub(MAX_CABLE_EVENTS);
    let rest = if more > 0 { format!("and {more} more events, which --json lists\n") } else { String::new() };
    Some(table(&rows).with(rest))
}

/// Builds the table of the energies. `has_motor` is true for fingers, which have a motor and a spring, and false for
/// driven discs.
pub fn energies(energy: &Energy, has_motor: bool) -> Report {
    let energies = [
        ("kinetic", energy.kinetic_j),
        ("gravity", energy.gravity_j),
        ("spring", energy.spring_j),
        ("contact", energy.elastic_j),
        ("dissipated", energy.dissipated_j),
        (if has_motor { "motor work" } else { "drive work" }, energy.motor_work_j),
        ("balance", energy.balance_j),
    ];
    let of_cables = (energy.cable_friction_j != 0.0).then_some(("cable friction", energy.cable_friction_j));
    // Energies below the rounding error of the largest one have no valid digits.
    let rounding_j = energies.iter().fold(0.0f64, |most, (_, joule)| most.max(joule.abs())) * f64::EPSILON;
    let (mut names, mut figures) = (row(["energy"]), row(["mJ"]));
    let shown = energies.into_iter().filter(|(name, _)| has_motor || *name != "spring").chain(of_cables);
    for (name, joule) in shown {
        names.push(name.to_string());
        figures.push(format_number(if joule.abs() < rounding_j { 0.0 } else { joule * 1e3 }, 5));
    }
    table(&[names, figures])
}

pub fn criteria(criteria: &Criteria) -> Report {
    let rebound = or_dash(criteria.rebound_percent, |percent| format!("{} %", format_number(percent, 4)));
    table(&[
        row(["criteria", "class", "tts, ms", "rebound", "first in position, ms"]),
        row(["", criteria.class.name(), &milliseconds(criteria.tts_s), &rebound, &milliseconds(criteria.t_geo_s)]),
    ])
    .with(format!("{}\n", criteria.verdict()))
}
