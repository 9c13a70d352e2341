//! Statics for people: short tables with units.

use super::closure::{ClosureReport, MultiplierReport};
use super::document::{BirglenReport, DriveReport, FinalPostureReport, ForcesReport, StaticsReport};
use super::motion::MotionReport;
use crate::grasp::finger::Contact;
use crate::wording::figures::{figure, row};
use crate::wording::report::{Report, Reported, list, table};

/// The whole report, with a line end.
impl Reported for StaticsReport {
    fn report(&self) -> Report {
        let mut sections = vec![
            Report::from(format!("{}: the grasp at rest\n", self.scene)),
            posture(&self.end),
            Report::from(drive(&self.drive)),
            forces(&self.forces),
            birglen(&self.forces),
            closure(&self.form_closure, "form closure of two fingers", Some(self.forces_per_n_m)),
        ];
        if let Some(path) = &self.svg {
            sections.push(Report::from(format!("picture: {path}\n")));
        }
        Report::join(sections)
    }
}

fn number(value: f64) -> String {
    figure(value, 5)
}

fn degrees(angle_rad: f64) -> String {
    format!("{:.4}°", angle_rad.to_degrees())
}

fn millimetres(length_m: f64) -> String {
    format!("{:.4}", length_m * 1e3)
}

fn posture(end: &FinalPostureReport) -> Report {
    let angles = [
        ("q11", end.q11_rad),
        ("q21", end.q21_rad),
        ("q12", end.q12_rad),
        ("q22", end.q22_rad),
        ("phi_c", end.phi_c_rad),
    ];
    let angles: Vec<String> = angles.iter().map(|(name, angle)| format!("{name} {}", degrees(*angle))).collect();
    let line = |name: &str, at: &Contact| {
        let [x, y] = at.point_m;
        let lengths = [at.from_joint_m, at.phalanx_m, x, y].map(millimetres);
        std::iter::once(name.to_string()).chain(lengths).collect::<Vec<_>>()
    };
    let rows = [
        row(["contact", "from joint, mm", "of, mm", "x, mm", "y, mm"]),
        line("proximal", &end.proximal),
        line("distal", &end.distal),
    ];
    Report::from(format!("final posture: {}\n", angles.join(", "))).and(table(&rows))
}

fn drive(drive: &DriveReport) -> String {
    let milli = |torque: f64| number(torque * 1e3);
    let pair = |[a, b]: [f64; 2]| format!("({}, {})", milli(a), milli(b));
    let spring = match &drive.spring {
        Some(spring) => {
            format!("{} spring {} N·mm at {}", spring.kind, milli(spring.torque_n_m), spring.placement)
        }
        None => "no spring".to_string(),
    };
    let mut text = format!(
        "motor {} N·mm, {spring}: together {} N·mm on (q11, q21)\n",
        milli(drive.motor_n_m),
        pair(drive.loads_n_m)
    );
    match drive.motor_min_n_m {
        Some(least) if least > 0.0 => {
            text.push_str(&format!("the distal phalanx pushes from a motor torque of {} N·mm on\n", milli(least)));
        }
        Some(_) => {}
        None => {
            text.push_str("the distal phalanx pushes only if the motor pulls backwards: q22 shrinks as q11 grows\n")
        }
    }
    text
}

fn yes(value: bool) -> String {
    if value { "yes" } else { "no" }.to_string()
}

fn friction([proximal, distal]: [f64; 2]) -> String {
    if proximal == distal { proximal.to_string() } else { format!("{proximal}, {distal}") }
}

fn forces(all: &[ForcesReport]) -> Report {
    let head = row(["μ_s", "F21, N", "F22, N", "force positive", "PFP, N", "palm force positive"]);
    let line = |of: &ForcesReport| {
        vec![
            friction(of.mu_static),
            number(of.f21_n),
            number(of.f22_n),
            yes(of.force_positive),
            number(of.pfp_n),
            yes(of.palm_force_positive),
        ]
    };
    let rows: Vec<_> = std::iter::once(head).chain(all.iter().map(line)).collect();
    let mut text = Report::from("contact forces at rest, without weight\n").and(table(&rows));
    for of in all {
        let cause = match of.ejection {
            "proximal" => {
                "the proximal phalanx would have to pull: it lets go, and the object slides along the distal one (ejection)"
            }
            "distal" => {
                "the distal phalanx would have to pull: the spring opens it against the motor, and the object is let go"
            }
            "both" => "both phalanges would have to pull: the finger opens",
            _ => continue,
        };
        text.push_str(&format!("μ_s {}: {cause}\n", friction(of.mu_static)));
    }
    text
}

fn birglen(all: &[ForcesReport]) -> Report {
    let mut text = Report::from("Birglen's frame: phalanges without width, θ = (q21, q22)\n");
    let Some(BirglenReport { transmission, torques_n_m, .. }) = all.first().map(|of| &of.birglen) else {
        return text;
    };
    text.push_str(&format!(
        "transmission T = {}, torques t = ({}, {}) N·mm\n",
        matrix(transmission, 1.0),
        number(torques_n_m[0] * 1e3),
        number(torques_n_m[1] * 1e3)
    ));
    let head = row(["μ_s", "Jacobian J, mm", "f1, N", "f2, N", "f1 − F21, N", "f2 − F22, N"]);
    let line = |of: &ForcesReport| {
        let b = &of.birglen;
        let difference = |i: usize| {
            let rounding = 1e-9 * b.forces_n[i].abs().max(1.0);
            if b.difference_n[i].abs() <= rounding { "0".to_string() } else { figure(b.difference_n[i], 3) }
        };
        vec![
            friction(of.mu_static),
            matrix(&b.jacobian_m, 1e3),
            number(b.forces_n[0]),
            number(b.forces_n[1]),
            difference(0),
            difference(1),
        ]
    };
    let rows: Vec<_> = std::iter::once(head).chain(all.iter().map(line)).collect();
    text.push(table(&rows));
    if all.iter().any(|of| of.mu_static != [0.0; 2]) {
        text.push_str(
            "(f differs from F by friction on the surface of a phalanx, which has a lever of its half width)\n",
        );
    }
    text
}

fn matrix([[a, b], [c, d]]: &[[f64; 2]; 2], factor: f64) -> String {
    let n = |value: f64| number(value * factor);
    format!("[{} {}; {} {}]", n(*a), n(*b), n(*c), n(*d))
}

/// What form closure says, `of` what; `pure` are forces of 1 N·m where their signs decide.
pub(super) fn closure(found: &ClosureReport, of: &str, pure: Option<[f64; 3]>) -> Report {
    let n = &found.necessary;
    let mut text = Report::from(format!(
        "{of}{}: {}\n",
        match found.palm {
            "rests" | "within" => " and the palm",
            _ => "",
        },
        if found.closed { "closed" } else { "not closed" }
    ));
    match (found.palm, found.palm_gap_m) {
        ("apart", Some(gap)) => {
            text.push_str(&format!("the object is {} mm above the palm, which does not hold it\n", millimetres(gap)));
        }
        ("within", Some(gap)) => {
            text.push_str(&format!(
                "the object reaches {} mm into the palm; it counts as resting on it\n",
                millimetres(-gap)
            ));
        }
        ("none", _) if pure.is_some() => text.push_str("the scene has no palm\n"),
        _ => {}
    }
    text.push_str(&format!(
        "necessary count: {} contacts + {} motors {} {} freedoms of the fingers + {} of the object + 1, {}\n",
        n.contacts,
        n.motors,
        if n.met { "≥" } else { "<" },
        n.hand,
        n.object,
        if n.met { "met" } else { "not met" }
    ));
    if let Some(pure) = pure.filter(|_| matches!(found.palm, "rests" | "within")) {
        let [f21, f22, pfp] = pure.map(number);
        text.push_str(&format!(
            "without spring and friction, 1 N·m makes F21 {f21} N, F22 {f22} N, PFP {pfp} N; closed if all are positive\n"
        ));
    }
    if let Some(multipliers) = &found.multipliers {
        text.push(balance(multipliers, found));
    }
    if let Some(motion) = &found.motion {
        text.push(free(motion, found));
    }
    text
}

fn balance(multipliers: &[MultiplierReport], found: &ClosureReport) -> Report {
    let line = |of: &MultiplierReport| {
        let value = match (of.force_n, of.torque_n_m) {
            (Some(force), _) => [number(force), "N".to_string()],
            (None, torque) => [torque.map_or_else(String::new, number), "N·m".to_string()],
        };
        std::iter::once(of.constraint.clone()).chain(value).collect::<Vec<_>>()
    };
    let rows: Vec<_> = multipliers.iter().map(line).collect();
    let (rank, residual) = (found.rank, figure(found.residual, 1));
    let head = format!("certificate: U has full rank {rank} and these, all positive, are in balance (to {residual})\n");
    Report::from(head).and(list(&rows))
}

fn free(motion: &MotionReport, found: &ClosureReport) -> Report {
    let residual = figure(found.residual, 1);
    let mut text = Report::from(format!("certificate: a motion that breaks no constraint (to {residual})\n"));
    for sentence in &motion.words {
        text.push_str(&format!("  {sentence}\n"));
    }
    let rows: Vec<Vec<String>> = motion
        .rates
        .iter()
        .map(|of| {
            let value = match (of.rate_m_s, of.rate_rad_s) {
                (Some(rate), _) => [figure(rate * 1e3, 4), "mm/s".to_string()],
                (None, rate) => [rate.map_or_else(String::new, |rate| figure(rate, 4)), "rad/s".to_string()],
            };
            std::iter::once(of.constraint.clone()).chain(value).collect()
        })
        .collect();
    text.push_str("how fast each constraint opens\n");
    text.push(list(&rows));
    text
}
