//! Report of a sizing: tables, JSON and CSV.

use serde::{Serialize, Serializer};

use super::named::Object;
use super::samples::cell;
use crate::format::format_duration;
use crate::format::numbers::{format_number, row};
use crate::format::report::{Report, ToReport, table};
use crate::gripper::Placement;
use crate::sizing::{Profile, ProfilePoint, Rule, Sizing};
use crate::study::size::FingerSizing;

/// Returns the maximum and the RMS of the motor torque after the contact, for a constant and for a torsional spring.
fn torques_after_contact(profile: &Profile) -> [[f64; 2]; 2] {
    let after = || profile.points.iter().filter(|point| point.net_n_m.is_none());
    let max_and_rms = |torque: fn(&ProfilePoint) -> f64| {
        let largest = after().map(|point| torque(point).abs()).fold(0.0, f64::max);
        // Trapezoidal rule.
        let squares: f64 = after()
            .zip(after().skip(1))
            .map(|(a, b)| (b.time_s - a.time_s) * 0.5 * (torque(a).powi(2) + torque(b).powi(2)))
            .sum();
        let span = profile.closing.trajectory.length_s - profile.closing.contact_s();
        [largest, (squares / span).sqrt()]
    };
    [max_and_rms(|point| point.constant_n_m), max_and_rms(|point| point.torsional_n_m)]
}

impl ToReport for FingerSizing {
    fn report(&self) -> Report {
        let FingerSizing { scene, profile, .. } = self;
        let closing = &profile.closing;
        let deg = |rad: f64| format_number(rad.to_degrees(), 5);
        let torque = |n_m: f64| format_number(n_m * 1e3, 5);
        let end = &closing.end.posture;
        let mut text = Report::from(format!(
            "{scene}: test trajectory of {}, q11 over {} deg, proximal contact at {}\n\n",
            format_duration(closing.trajectory.length_s),
            deg(closing.trajectory.stroke_rad),
            format_duration(closing.contact_s())
        ));
        let q11_contact = closing.trajectory.at(closing.contact_x).angle_rad;
        text.push(table(&[
            row(["", "q11, deg", "q21, deg", "q22, deg"]),
            row(["start", &deg(closing.start.q11_rad), &deg(closing.start.q21_rad), &deg(closing.start.q22_rad)]),
            row(["contact", &deg(q11_contact), &deg(closing.q21_contact_rad), &deg(closing.start.q22_rad)]),
            row(["end", &deg(end.q11_rad), &deg(end.q21_rad), &deg(end.q22_rad)]),
        ]));

        text.push('\n');
        let or_dash = |n_m: Option<f64>| n_m.map_or("–".to_string(), torque);
        let line = |name: &str, rule: Rule, sizing: &Sizing| {
            let marker = if rule == self.options.rule { "<-" } else { "" };
            row([name, &torque(sizing.motor_n_m), &torque(sizing.spring_n_m), marker])
        };
        text.push(table(&[
            row(["", "motor τ11, N·mm", "spring k_s, N·mm", ""]),
            line("rigid: RMS until the contact", Rule::Rigid, &profile.rigid),
            line("whole: RMS of the whole trajectory", Rule::Whole, &profile.whole),
            row(["in the scene", &or_dash(self.given_motor_n_m), &or_dash(self.given_spring_n_m), ""]),
        ]));
        text.push_str(&format!(
            "Doubling the number of samples changes these torques by at most {} (relative).\n\n",
            format_number(profile.convergence, 2)
        ));

        let mut rows = vec![row(["spring at", "k_s, N·mm", "relative to q22"])];
        for (placement, n_m) in Placement::ALL.into_iter().zip(profile.placements_n_m) {
            let ratio = format_number(n_m / profile.rigid.spring_n_m, 3);
            rows.push(row([placement.name(), &torque(n_m), &ratio]));
        }
        text.push(table(&rows));

        let [constant, torsional] = torques_after_contact(profile).map(|torques| torques.map(torque));
        text.push('\n');
        text.push(table(&[
            row(["motor after the contact, with", "largest, N·mm", "RMS, N·mm"]),
            row(["a constant spring", &constant[0], &constant[1]]),
            row(["a torsional spring", &torsional[0], &torsional[1]]),
        ]));
        text.push_str(&format!(
            "Torsional spring at q22: stiffness {} N·mm/rad, preload {} deg; it gives k_s when the finger is straight.\n",
            format_number(profile.torsional_n_m_per_rad * 1e3, 5),
            deg(self.preload_rad)
        ));
        text
    }
}

impl Serialize for FingerSizing {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let FingerSizing { scene, profile, .. } = self;
        let (closing, end) = (&profile.closing, &profile.closing.end.posture);
        let torques = |motor_n_m: Option<f64>, spring_n_m: Option<f64>| {
            Object::default().with("motor_n_m", motor_n_m).with("spring_n_m", spring_n_m)
        };
        let sized = |sizing: &Sizing| torques(Some(sizing.motor_n_m), Some(sizing.spring_n_m));
        let chosen = match self.options.rule {
            Rule::Rigid => profile.rigid,
            Rule::Whole => profile.whole,
        };
        let trajectory = Object::default()
            .with("closing_s", closing.trajectory.length_s)
            .with("contact_s", closing.contact_s())
            .with("stroke_rad", closing.trajectory.stroke_rad)
            .with("start_q11_rad", closing.start.q11_rad)
            .with("start_q21_rad", closing.start.q21_rad)
            .with("contact_q11_rad", closing.trajectory.at(closing.contact_x).angle_rad)
            .with("contact_q21_rad", closing.q21_contact_rad)
            .with("end_q11_rad", end.q11_rad)
            .with("end_q21_rad", end.q21_rad)
            .with("end_q22_rad", end.q22_rad);
        let placements = Placement::ALL.into_iter().zip(profile.placements_n_m).map(|(placement, spring_n_m)| {
            Object::default().with("placement", placement.name()).with("spring_n_m", spring_n_m)
        });
        let spring_type = |name: &'static str, stiffness: f64, preload_rad: Option<f64>, [peak, rms]: [f64; 2]| {
            Object::default()
                .with("spring", name)
                .with("stiffness_n_m_per_rad", stiffness)
                .with("preload_rad", preload_rad)
                .with("motor_peak_after_contact_n_m", peak)
                .with("motor_rms_after_contact_n_m", rms)
        };
        let [constant, torsional] = torques_after_contact(profile);
        let spring_types = [
            spring_type("constant", 0.0, None, constant),
            spring_type("torsional", profile.torsional_n_m_per_rad, Some(self.preload_rad), torsional),
        ];
        Object::default()
            .with("scene", scene)
            .with("rule", self.options.rule.name())
            .with("motor_n_m", chosen.motor_n_m)
            .with("spring_n_m", chosen.spring_n_m)
            .with("rigid", sized(&profile.rigid))
            .with("whole", sized(&profile.whole))
            .with("given", torques(self.given_motor_n_m, self.given_spring_n_m))
            .with("convergence_relative", profile.convergence)
            .with("intervals", crate::sizing::INTERVALS)
            .with("trajectory", trajectory)
            .with("placements", placements.collect::<Vec<_>>())
            .with("spring_types", spring_types)
            .serialize(serializer)
    }
}

/// Returns the profile as CSV, one sample per line. Torques of the rigid phase are empty after it.
pub(crate) fn sizing_csv(profile: &Profile) -> String {
    let mut text =
        "time_s,q11_rad,q21_rad,q22_rad,qd11_rad_s,qdd11_rad_s2,spring_q21_q11_n_m,spring_q12_n_m,spring_q22_n_m,\
                    spring_coupler_distal_n_m,motor_net_n_m,motor_constant_spring_n_m,motor_torsional_spring_n_m\n"
            .to_string();
    for point in &profile.points {
        let springs = point.springs_n_m.unwrap_or([f64::NAN; 4]);
        let motion = [point.time_s, point.q11_rad, point.q21_rad, point.q22_rad, point.qd11_rad_s, point.qdd11_rad_s2];
        let motor = [point.net_n_m.unwrap_or(f64::NAN), point.constant_n_m, point.torsional_n_m];
        let cells: Vec<String> = motion.into_iter().chain(springs).chain(motor).map(cell).collect();
        text.extend([&cells.join(","), "\n"]);
    }
    text
}
