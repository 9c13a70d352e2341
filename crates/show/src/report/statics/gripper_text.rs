//! The statics of a gripper as text.

use super::gripper::{
    AnglesReport, BalanceReport, DirectionReport, FrictionCaseReport, GripperClosureReport, GripperContactReport,
    GripperPostureReport, GripperStaticsReport, MotorReport,
};
use super::text::closure;
use crate::format::numbers::{G_M_S2, format_duration, format_number, row, zero_below_resolution};
use crate::format::report::{Report, ToReport, table};
use crate::units::Dimension;

/// The complete report, with a final line end.
impl ToReport for GripperStaticsReport {
    fn report(&self) -> Report {
        let mut sections = vec![
            Report::from(format!("{}: the grasp of its object at rest\n", self.scene)),
            posture(&self.posture),
            Report::from(self.motors.iter().map(motor).collect::<String>()),
            contacts(&self.contacts),
        ];
        sections.extend(self.form_closure.iter().map(form_closure));
        sections.extend(self.friction_cases.iter().map(friction_case));
        if let Some(path) = &self.svg {
            sections.push(Report::from(format!("picture: {path}\n")));
        }
        Report::join(sections)
    }
}

fn number(value: f64) -> String {
    format_number(value, 4)
}

fn millimetres(length_m: f64) -> String {
    format!("{:.4}", length_m * 1e3)
}

fn posture(report: &GripperPostureReport) -> Report {
    let head = match (report.source, report.time_s) {
        ("run", Some(time_s)) => {
            format!("posture at {} of the run; object {}\n", format_duration(time_s), report.fate.unwrap_or_default())
        }
        ("geometric", _) => {
            "posture: all phalanges in contact with the object at its position in the scene\n".to_string()
        }
        _ => "posture as given\n".to_string(),
    };
    let line = |name: &str, report: &AnglesReport| {
        let angles = [report.q11_rad, report.q21_rad, report.q12_rad, report.q22_rad]
            .map(|angle| format!("{:.4}", angle.to_degrees()));
        std::iter::once(name.to_string()).chain(angles).collect::<Vec<_>>()
    };
    let rows = [
        row(["finger", "q11, °", "q21, °", "q12, °", "q22, °"]),
        line("right", &report.right),
        line("left", &report.left),
    ];
    let [gx, gy] = report.gravity_m_s2;
    Report::from(head).with(table(&rows)).with(Report::from(format!(
        "object of {} g at ({}, {}) mm, gravity ({}, {}) m/s² in the palm's frame\n",
        number(report.mass_kg * 1e3),
        millimetres(report.x_m),
        millimetres(report.y_m),
        number(gx),
        number(gy)
    )))
}

fn motor(report: &MotorReport) -> String {
    let milli = |torque_n_m: f64| number(torque_n_m * 1e3);
    let name = if report.motor == "input" { "input of the differential" } else { report.motor };
    let blocked = match (report.brake_min_n_m, report.brake_max_n_m) {
        (Some(min_n_m), Some(max_n_m)) if min_n_m < 0.0 => format!("a brake that holds {} N·mm", milli(max_n_m)),
        (Some(_), Some(max_n_m)) => format!("a brake that holds {} N·mm against opening only", milli(max_n_m)),
        _ => "no brake in the scene, so \"blocked\" means unlimited torque".to_string(),
    };
    format!("motor, {name}: {} N·mm; {blocked}\n", milli(report.torque_n_m))
}

/// Short name of a contact; that of a phalanx contains its link.
fn short_name(contact: &str) -> &str {
    match contact {
        "right_proximal" => "R21",
        "right_distal" => "R22",
        "right_limit" => "R limit",
        "left_proximal" => "L21",
        "left_distal" => "L22",
        "left_limit" => "L limit",
        other => other,
    }
}

fn contacts(all: &[GripperContactReport]) -> Report {
    let has_forces = all.iter().any(|report| report.normal_n.is_some());
    let mut head = row(["contact", "x, mm", "y, mm", "normal, °", "gap, µm", "μ_s"]);
    if has_forces {
        head.extend(row(["normal, N", "friction, N"]));
    }
    let line = |report: &GripperContactReport| {
        let [x, y] = report.point_m.map(millimetres);
        let [nx, ny] = report.normal;
        let name = format!("{} {}", short_name(&report.contact), report.contact.replace('_', " "));
        let name = if report.contact == "palm" { "palm".to_string() } else { name };
        let angle = format!("{:.2}", ny.atan2(nx).to_degrees());
        let mut cells = vec![name, x, y, angle, format_number(report.gap_m * 1e6, 4), report.mu_static.to_string()];
        let forces = [report.normal_n, report.tangential_n].into_iter().flatten();
        cells.extend(forces.map(|force_n| number(zero_below_resolution(force_n, Dimension::Force))));
        cells
    };
    let rows: Vec<_> = std::iter::once(head).chain(all.iter().map(line)).collect();
    let mut text = Report::from("contacts in the palm's frame; normals into the object\n").with(table(&rows));
    if has_forces {
        text.push_str(
            "(forces of the run; friction on phalanx and palm is along t = (n_y, −n_x), mirrored on the left)\n",
        );
    }
    text
}

fn form_closure(report: &GripperClosureReport) -> Report {
    let what = match report.blocked {
        "outputs" => "both driven links blocked",
        _ => "the differential's input blocked",
    };
    match (&report.closure, &report.reason) {
        (Some(found), _) => closure(found, &format!("form closure, {what}"), None),
        (None, reason) => {
            let reason = reason.as_deref().unwrap_or_default();
            Report::from(format!("form closure, {what}: not decided\n")).with(Report::paragraph(&format!("{reason}\n")))
        }
    }
}

fn friction_case(report: &FrictionCaseReport) -> Report {
    let friction = match report.mu_static {
        Some(mu) => format!("μ_s {mu} in all contacts"),
        None => "friction of the scene".to_string(),
    };
    let closure = &report.force_closure;
    let [x, y, moment] = closure.weakest.map(number);
    let verdict = match closure.closed {
        true => format!(
            "closed, Q1 {} (sum of normal forces 1) or {} (each at most 1)",
            number(closure.q1_l1),
            number(closure.q1_linf)
        ),
        false => "not closed".to_string(),
    };
    let weakest = if closure.closed { "weakest direction: " } else { "cannot be balanced: " };
    let mut text = Report::from(format!(
        "force closure with {friction}: {verdict}\n{weakest}wrench ({x}, {y}; {moment}) of force and moment divided by radius\n"
    ));
    text.push_str("\nlargest acceleration of the palm that contact forces can balance\n");
    let heads = ["towards", "", "blocked, g", "limited by", "at torque, g", "limited by"];
    let line = |report: &DirectionReport| {
        vec![
            format!("{}°", format!("{:.2}", report.angle_rad.to_degrees()).trim_end_matches('0').trim_end_matches('.')),
            direction_name(report.direction).to_string(),
            acceleration_text(&report.blocked),
            limiting_contacts(&report.blocked),
            acceleration_text(&report.at_torque),
            limiting_contacts(&report.at_torque),
        ]
    };
    let rows: Vec<_> = std::iter::once(row(heads)).chain(report.accelerations.iter().map(line)).collect();
    text.push(table(&rows));
    text.push(Report::paragraph(
        "(0° is x, along the palm to the right; 90° is y, out of the palm; a hanging gripper is lifted towards 270°. Balancing forces \
         exist; which of them occur depends on how the hand was closed.)\n",
    ));
    text
}

/// Name of a direction for a hanging gripper.
fn direction_name([x, y]: [f64; 2]) -> &'static str {
    match (x, y) {
        (1.0, 0.0) => "right",
        (-1.0, 0.0) => "left",
        (0.0, 1.0) => "down",
        (0.0, -1.0) => "up",
        _ => "",
    }
}

fn acceleration_text(report: &BalanceReport) -> String {
    match report.acceleration_m_s2 {
        Some(acceleration) => format_number(acceleration / G_M_S2, 4),
        None if report.balanced == "any" => "any".to_string(),
        None => "not at rest".to_string(),
    }
}

/// Contacts and brakes at their limits, by their short names.
fn limiting_contacts(report: &BalanceReport) -> String {
    let all = |verb: &str, names: Vec<&str>| (!names.is_empty()).then(|| format!("{verb} {}", names.join(" ")));
    let names = |report: &'_ [String]| report.iter().map(|contact| short_name(contact).to_string()).collect::<Vec<_>>();
    let (slips, leaves) = (names(&report.slips), names(&report.leaves));
    let parts = [
        all("slip", slips.iter().map(String::as_str).collect()),
        all("leave", leaves.iter().map(String::as_str).collect()),
        all("brake", report.brakes_slip.clone()),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    if parts.is_empty() { "–".to_string() } else { parts.join(", ") }
}
