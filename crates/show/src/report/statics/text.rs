//! The statics of a finger as text: short tables with units.

use super::closure::{ClosureReport, MultiplierReport};
use super::document::{BirglenReport, DriveReport, FinalPostureReport, ForcesReport, StaticsReport};
use super::motion::MotionReport;
use crate::format::numbers::{format_number, row};
use crate::format::report::{Report, ToReport, list, table};
use crate::grasp::finger::Contact;

/// Builds the complete report.
impl ToReport for StaticsReport {
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
    format_number(value, 5)
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
    let line = |name: &str, contact: &Contact| {
        let [x, y] = contact.point_m;
        let lengths = [contact.from_joint_m, contact.phalanx_m, x, y].map(millimetres);
        std::iter::once(name.to_string()).chain(lengths).collect::<Vec<_>>()
    };
    let rows = [
        row(["contact", "from joint, mm", "phalanx length, mm", "x, mm", "y, mm"]),
        line("proximal", &end.proximal),
        line("distal", &end.distal),
    ];
    Report::from(format!("final posture: {}\n", angles.join(", "))).with(table(&rows))
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
        Some(min_n_m) if min_n_m > 0.0 => {
            text.push_str(&format!(
                "the distal phalanx pushes the object at motor torques above {} N·mm\n",
                milli(min_n_m)
            ));
        }
        Some(_) => {}
        None => text.push_str(
            "the distal phalanx pushes the object only at a negative motor torque: q22 decreases as q11 increases\n",
        ),
    }
    text
}

fn yes_or_no(value: bool) -> String {
    if value { "yes" } else { "no" }.to_string()
}

fn friction([proximal, distal]: [f64; 2]) -> String {
    if proximal == distal { proximal.to_string() } else { format!("{proximal}, {distal}") }
}

fn forces(all: &[ForcesReport]) -> Report {
    let head = row(["μ_s", "F21, N", "F22, N", "force positive", "PFP, N", "palm force positive"]);
    let line = |report: &ForcesReport| {
        vec![
            friction(report.mu_static),
            number(report.f21_n),
            number(report.f22_n),
            yes_or_no(report.force_positive),
            number(report.pfp_n),
            yes_or_no(report.palm_force_positive),
        ]
    };
    let rows: Vec<_> = std::iter::once(head).chain(all.iter().map(line)).collect();
    let mut text = Report::from("contact forces at rest, without weight\n").with(table(&rows));
    for report in all {
        let cause = match report.ejection {
            "proximal" => {
                "the proximal phalanx would have to pull: it loses contact, and the object slides along the distal phalanx (ejection)"
            }
            "distal" => {
                "the distal phalanx would have to pull: the spring opens it against the motor, and the object is released"
            }
            "both" => "both phalanges would have to pull: the finger opens",
            _ => continue,
        };
        text.push_str(&format!("μ_s {}: {cause}\n", friction(report.mu_static)));
    }
    text
}

fn birglen(all: &[ForcesReport]) -> Report {
    let mut text = Report::from("Birglen's frame: phalanges of zero width, θ = (q21, q22)\n");
    let Some(BirglenReport { transmission, torques_n_m, .. }) = all.first().map(|report| &report.birglen) else {
        return text;
    };
    text.push_str(&format!(
        "transmission T = {}, torques t = ({}, {}) N·mm\n",
        matrix(transmission, 1.0),
        number(torques_n_m[0] * 1e3),
        number(torques_n_m[1] * 1e3)
    ));
    let head = row(["μ_s", "Jacobian J, mm", "f1, N", "f2, N", "f1 − F21, N", "f2 − F22, N"]);
    let line = |report: &ForcesReport| {
        let b = &report.birglen;
        let difference = |i: usize| {
            let rounding = 1e-9 * b.forces_n[i].abs().max(1.0);
            if b.difference_n[i].abs() <= rounding { "0".to_string() } else { format_number(b.difference_n[i], 3) }
        };
        vec![
            friction(report.mu_static),
            matrix(&b.jacobian_m, 1e3),
            number(b.forces_n[0]),
            number(b.forces_n[1]),
            difference(0),
            difference(1),
        ]
    };
    let rows: Vec<_> = std::iter::once(head).chain(all.iter().map(line)).collect();
    text.push(table(&rows));
    if all.iter().any(|report| report.mu_static != [0.0; 2]) {
        text.push_str(
            "(f differs from F by the friction on the surface of a phalanx, whose lever arm is the half width)\n",
        );
    }
    text
}

fn matrix([[a, b], [c, d]]: &[[f64; 2]; 2], factor: f64) -> String {
    let n = |value: f64| number(value * factor);
    format!("[{} {}; {} {}]", n(*a), n(*b), n(*c), n(*d))
}

/// Describes the form closure `mechanism` a mechanism. `pure` are the forces per 1 N·m if their signs decide form
/// closure.
pub(super) fn closure(found: &ClosureReport, mechanism: &str, pure: Option<[f64; 3]>) -> Report {
    let n = &found.necessary;
    let mut text = Report::from(format!(
        "{mechanism}{}: {}\n",
        match found.palm {
            "rests" | "within" => " and the palm",
            _ => "",
        },
        if found.closed { "closed" } else { "not closed" }
    ));
    match (found.palm, found.palm_gap_m) {
        ("apart", Some(gap)) => {
            text.push_str(&format!(
                "the object is {} mm above the palm, which does not support it\n",
                millimetres(gap)
            ));
        }
        ("within", Some(gap)) => {
            text.push_str(&format!(
                "the object penetrates the palm by {} mm and counts as resting on it\n",
                millimetres(-gap)
            ));
        }
        ("none", _) if pure.is_some() => text.push_str("the scene has no palm\n"),
        _ => {}
    }
    text.push_str(&format!(
        "necessary count: {} contacts + {} motors {} {} degrees of freedom of the fingers + {} of the object + 1, {}\n",
        n.contacts,
        n.motors,
        if n.is_met { "≥" } else { "<" },
        n.hand,
        n.object,
        if n.is_met { "met" } else { "not met" }
    ));
    if let Some(pure) = pure.filter(|_| matches!(found.palm, "rests" | "within")) {
        let [f21, f22, pfp] = pure.map(number);
        text.push_str(&format!(
            "without spring and friction, 1 N·m causes F21 {f21} N, F22 {f22} N, PFP {pfp} N; closed if all are positive\n"
        ));
    }
    if let Some(multipliers) = &found.multipliers {
        text.push(balance(multipliers, found));
    }
    if let Some(motion) = &found.motion {
        text.push(free_motion(motion, found));
    }
    text
}

fn balance(multipliers: &[MultiplierReport], found: &ClosureReport) -> Report {
    let line = |multiplier: &MultiplierReport| {
        let value = match (multiplier.force_n, multiplier.torque_n_m) {
            (Some(force), _) => [number(force), "N".to_string()],
            (None, torque) => [torque.map_or_else(String::new, number), "N·m".to_string()],
        };
        std::iter::once(multiplier.constraint.clone()).chain(value).collect::<Vec<_>>()
    };
    let rows: Vec<_> = multipliers.iter().map(line).collect();
    let (rank, residual) = (found.rank, format_number(found.residual, 1));
    let head = format!(
        "certificate: U has full rank {rank}, and these positive forces are in equilibrium (residual {residual})\n"
    );
    Report::from(head).with(list(&rows))
}

fn free_motion(motion: &MotionReport, found: &ClosureReport) -> Report {
    let residual = format_number(found.residual, 1);
    let mut text = Report::from(format!("certificate: a motion that violates no constraint (residual {residual})\n"));
    for sentence in &motion.sentences {
        text.push_str(&format!("  {sentence}\n"));
    }
    let rows: Vec<Vec<String>> = motion
        .rates
        .iter()
        .map(|rate_report| {
            let value = match (rate_report.rate_m_s, rate_report.rate_rad_s) {
                (Some(rate), _) => [format_number(rate * 1e3, 4), "mm/s".to_string()],
                (None, rate) => [rate.map_or_else(String::new, |rate| format_number(rate, 4)), "rad/s".to_string()],
            };
            std::iter::once(rate_report.constraint.clone()).chain(value).collect()
        })
        .collect();
    text.push_str("opening rate of each constraint\n");
    text.push(list(&rows));
    text
}
