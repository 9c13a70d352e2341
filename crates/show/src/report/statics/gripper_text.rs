//! Statics of a gripper for people.

use super::gripper::{
    AnglesReport, BalanceReport, DirectionReport, GripperClosureReport, GripperContactReport, GripperPostureReport,
    GripperStaticsReport, HoldsReport, MotorReport,
};
use super::text::closure;
use crate::units::Dimension;
use crate::wording::figures::{G_M_S2, duration, figure, resolved, row};
use crate::wording::report::{Report, Reported, table};

/// The whole report, with a line end.
impl Reported for GripperStaticsReport {
    fn report(&self) -> Report {
        let mut sections = vec![
            Report::from(format!("{}: how its object is held at rest\n", self.scene)),
            posture(&self.posture),
            Report::from(self.motors.iter().map(motor).collect::<String>()),
            contacts(&self.contacts),
        ];
        sections.extend(self.form_closure.iter().map(form_closure));
        sections.extend(self.holds.iter().map(holds));
        if let Some(path) = &self.svg {
            sections.push(Report::from(format!("picture: {path}\n")));
        }
        Report::join(sections)
    }
}

fn number(value: f64) -> String {
    figure(value, 4)
}

fn millimetres(length_m: f64) -> String {
    format!("{:.4}", length_m * 1e3)
}

fn posture(of: &GripperPostureReport) -> Report {
    let head = match (of.source, of.time_s) {
        ("run", Some(time_s)) => {
            format!("posture at {} of the run, {}\n", duration(time_s), of.fate.unwrap_or_default())
        }
        ("geometric", _) => "posture: all phalanges on the object where the scene has it\n".to_string(),
        _ => "posture as given\n".to_string(),
    };
    let line = |name: &str, of: &AnglesReport| {
        let angles = [of.q11_rad, of.q21_rad, of.q12_rad, of.q22_rad].map(|angle| format!("{:.4}", angle.to_degrees()));
        std::iter::once(name.to_string()).chain(angles).collect::<Vec<_>>()
    };
    let rows =
        [row(["finger", "q11, °", "q21, °", "q12, °", "q22, °"]), line("right", &of.right), line("left", &of.left)];
    let [gx, gy] = of.gravity_m_s2;
    Report::from(head).and(table(&rows)).and(Report::from(format!(
        "object of {} g at ({}, {}) mm, gravity ({}, {}) m/s² in the palm's frame\n",
        number(of.mass_kg * 1e3),
        millimetres(of.x_m),
        millimetres(of.y_m),
        number(gx),
        number(gy)
    )))
}

fn motor(of: &MotorReport) -> String {
    let milli = |torque_n_m: f64| number(torque_n_m * 1e3);
    let name = if of.motor == "input" { "input of the differential" } else { of.motor };
    let blocked = match (of.brake_min_n_m, of.brake_max_n_m) {
        (Some(least), Some(most)) if least < 0.0 => format!("a brake that holds {} N·mm", milli(most)),
        (Some(_), Some(most)) => format!("a brake that holds {} N·mm against opening only", milli(most)),
        _ => "no brake in the scene, so blocked means whatever it takes".to_string(),
    };
    format!("motor, {name}: {} N·mm; {blocked}\n", milli(of.torque_n_m))
}

/// The short name of a place: of a phalanx its link.
fn short(place: &str) -> &str {
    match place {
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
    let ran = all.iter().any(|of| of.normal_n.is_some());
    let mut head = row(["contact", "x, mm", "y, mm", "normal, °", "gap, µm", "μ_s"]);
    if ran {
        head.extend(row(["normal, N", "friction, N"]));
    }
    let line = |of: &GripperContactReport| {
        let [x, y] = of.point_m.map(millimetres);
        let [nx, ny] = of.normal;
        let name = format!("{} {}", short(&of.place), of.place.replace('_', " "));
        let name = if of.place == "palm" { "palm".to_string() } else { name };
        let angle = format!("{:.2}", ny.atan2(nx).to_degrees());
        let mut cells = vec![name, x, y, angle, figure(of.gap_m * 1e6, 4), of.mu_static.to_string()];
        let forces = [of.normal_n, of.tangential_n].into_iter().flatten();
        cells.extend(forces.map(|force_n| number(resolved(force_n, Dimension::Force))));
        cells
    };
    let rows: Vec<_> = std::iter::once(head).chain(all.iter().map(line)).collect();
    let mut text = Report::from("contacts in the palm's frame; normals into the object\n").and(table(&rows));
    if ran {
        text.push_str(
            "(forces are those of the run; friction on phalanx and palm along t = (n_y, −n_x), mirrored on the left)\n",
        );
    }
    text
}

fn form_closure(of: &GripperClosureReport) -> Report {
    let what = match of.blocked {
        "outputs" => "both driven links blocked",
        _ => "the differential's input blocked",
    };
    match (&of.closure, &of.reason) {
        (Some(found), _) => closure(found, &format!("form closure, {what}"), None),
        (None, reason) => {
            let reason = reason.as_deref().unwrap_or_default();
            Report::from(format!("form closure, {what}: not decided\n")).and(Report::paragraph(&format!("{reason}\n")))
        }
    }
}

fn holds(of: &HoldsReport) -> Report {
    let friction = match of.mu_static {
        Some(mu) => format!("μ_s {mu} in all contacts"),
        None => "friction of the scene".to_string(),
    };
    let closure = &of.force_closure;
    let [x, y, moment] = closure.weakest.map(number);
    let verdict = match closure.closed {
        true => format!(
            "closed, Q1 {} (normal forces of 1 in sum), {} (of 1 each)",
            number(closure.q1_l1),
            number(closure.q1_linf)
        ),
        false => "not closed".to_string(),
    };
    let weakest = if closure.closed { "least can be balanced along" } else { "nothing can be balanced along" };
    let mut text = Report::from(format!(
        "force closure with {friction}: {verdict}\n{weakest} the wrench ({x}, {y}; {moment}), force and moment over radius\n"
    ));
    text.push_str("\nlargest acceleration of the palm that contact forces can balance\n");
    let heads = ["towards", "", "blocked, g", "gives way", "at torque, g", "gives way"];
    let line = |of: &DirectionReport| {
        vec![
            format!("{}°", format!("{:.2}", of.angle_rad.to_degrees()).trim_end_matches('0').trim_end_matches('.')),
            word(of.direction).to_string(),
            reach(&of.blocked),
            way(&of.blocked),
            reach(&of.at_torque),
            way(&of.at_torque),
        ]
    };
    let rows: Vec<_> = std::iter::once(row(heads)).chain(of.accelerations.iter().map(line)).collect();
    text.push(table(&rows));
    text.push(Report::paragraph(
        "(0° is x, along the palm to the right, 90° y, out of it; a gripper that hangs is lifted towards 270°. Forces that balance it \
         exist; which of them come about depends on how the hand was closed.)\n",
    ));
    text
}

/// What a robot calls a direction.
fn word([x, y]: [f64; 2]) -> &'static str {
    match (x, y) {
        (1.0, 0.0) => "right",
        (-1.0, 0.0) => "left",
        (0.0, 1.0) => "down",
        (0.0, -1.0) => "up",
        _ => "",
    }
}

fn reach(of: &BalanceReport) -> String {
    match of.acceleration_m_s2 {
        Some(acceleration) => figure(acceleration / G_M_S2, 4),
        None if of.balanced == "any" => "any".to_string(),
        None => "not at rest".to_string(),
    }
}

/// What gives way, by the short names of places.
fn way(of: &BalanceReport) -> String {
    let all = |verb: &str, names: Vec<&str>| (!names.is_empty()).then(|| format!("{verb} {}", names.join(" ")));
    let places = |of: &'_ [String]| of.iter().map(|place| short(place).to_string()).collect::<Vec<_>>();
    let (slips, leaves) = (places(&of.slips), places(&of.leaves));
    let parts = [
        all("slip", slips.iter().map(String::as_str).collect()),
        all("leave", leaves.iter().map(String::as_str).collect()),
        all("brake", of.brakes_slip.clone()),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    if parts.is_empty() { "–".to_string() } else { parts.join(", ") }
}
