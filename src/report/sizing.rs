//! A sizing as tables, JSON and CSV.

use serde::Serialize;

use super::csv;
use crate::gripper::Placement;
use crate::sizing::{Profile, ProfilePoint, Rule, Sizing};
use crate::study::size::Sized;
use crate::wording::duration;
use crate::wording::figures::{figure, row};
use crate::wording::report::{Report, Reported, table};

/// A finger's sizing, with what its scene has now.
#[derive(Clone, Debug, Serialize)]
#[serde(into = "SizingDocument")]
pub struct SizingReport<'a> {
    pub scene: &'a str,
    pub profile: &'a Profile,
    pub rule: Rule,
    /// Preload of the torsional spring it is compared with.
    pub preload_rad: f64,
    /// Torques that the scene itself has, where it has constant ones.
    pub given_motor_n_m: Option<f64>,
    pub given_spring_n_m: Option<f64>,
}

impl<'a> From<&'a Sized> for SizingReport<'a> {
    fn from(found: &'a Sized) -> Self {
        SizingReport {
            scene: &found.scene,
            profile: &found.profile,
            rule: found.asked.rule,
            preload_rad: found.preload_rad,
            given_motor_n_m: found.given_motor_n_m,
            given_spring_n_m: found.given_spring_n_m,
        }
    }
}

/// Largest and root mean square of the motor's torque after the contact, against either spring: constant, torsional.
fn after_contact(profile: &Profile) -> [[f64; 2]; 2] {
    let after = || profile.points.iter().filter(|point| point.net_n_m.is_none());
    let of = |torque: fn(&ProfilePoint) -> f64| {
        let largest = after().map(|point| torque(point).abs()).fold(0.0, f64::max);
        // By the trapezoidal rule: the first and the last point count half, for steps of time are even in between.
        let squares: f64 = after()
            .zip(after().skip(1))
            .map(|(a, b)| (b.time_s - a.time_s) * 0.5 * (torque(a).powi(2) + torque(b).powi(2)))
            .sum();
        let span = profile.closing.trajectory.length_s - profile.closing.contact_s();
        [largest, (squares / span).sqrt()]
    };
    [of(|point| point.constant_n_m), of(|point| point.torsional_n_m)]
}

/// Tables for people.
impl Reported for SizingReport<'_> {
    fn report(&self) -> Report {
        let SizingReport { scene, profile, .. } = self;
        let closing = &profile.closing;
        let deg = |rad: f64| figure(rad.to_degrees(), 5);
        let torque = |n_m: f64| figure(n_m * 1e3, 5);
        let end = &closing.end.posture;
        let mut text = Report::from(format!(
            "{scene}: test trajectory of {}, q11 over {} deg, proximal contact at {}\n\n",
            duration(closing.trajectory.length_s),
            deg(closing.trajectory.stroke_rad),
            duration(closing.contact_s())
        ));
        let q11_contact = closing.trajectory.at(closing.contact_x).angle_rad;
        text.push(table(&[
            row(["", "q11, deg", "q21, deg", "q22, deg"]),
            row(["start", &deg(closing.start.q11_rad), &deg(closing.start.q21_rad), &deg(closing.start.q22_rad)]),
            row(["contact", &deg(q11_contact), &deg(closing.q21_contact_rad), &deg(closing.start.q22_rad)]),
            row(["end", &deg(end.q11_rad), &deg(end.q21_rad), &deg(end.q22_rad)]),
        ]));

        text.push('\n');
        let given = |n_m: Option<f64>| n_m.map_or("–".to_string(), torque);
        let line = |name: &str, rule: Rule, sizing: &Sizing| {
            let chosen = if rule == self.rule { "  <-" } else { "" };
            row([name, &torque(sizing.motor_n_m), &torque(sizing.spring_n_m), chosen])
        };
        text.push(table(&[
            row(["", "motor τ11, N·mm", "spring k_s, N·mm", ""]),
            line("rigid: RMS until the contact", Rule::Rigid, &profile.rigid),
            line("whole: RMS of all the trajectory", Rule::Whole, &profile.whole),
            row(["the scene has", &given(self.given_motor_n_m), &given(self.given_spring_n_m), ""]),
        ]));
        text.push_str(&format!(
            "Twice the samples change these by {} at most, relatively.\n\n",
            figure(profile.convergence, 2)
        ));

        let mut rows = vec![row(["spring at", "k_s, N·mm", "of q22's"])];
        for (placement, n_m) in Placement::ALL.into_iter().zip(profile.placements_n_m) {
            let share = figure(n_m / profile.rigid.spring_n_m, 3);
            rows.push(row([placement.name(), &torque(n_m), &share]));
        }
        text.push(table(&rows));

        let [constant, torsional] = after_contact(profile).map(|torques| torques.map(torque));
        text.push('\n');
        text.push(table(&[
            row(["motor after the contact, against", "largest, N·mm", "RMS, N·mm"]),
            row(["a constant spring", &constant[0], &constant[1]]),
            row(["a torsional spring", &torsional[0], &torsional[1]]),
        ]));
        text.push_str(&format!(
            "The torsional spring, at q22, has {} N·mm/rad and a preload of {} deg: k_s where the finger is straight.\n",
            figure(profile.torsional_n_m_per_rad * 1e3, 5),
            deg(self.preload_rad)
        ));
        text
    }
}

#[derive(Serialize)]
struct SizingDocument {
    scene: String,
    rule: &'static str,
    motor_n_m: f64,
    spring_n_m: f64,
    rigid: TorquesDocument,
    whole: TorquesDocument,
    given: TorquesDocument,
    convergence_relative: f64,
    intervals: usize,
    trajectory: TrajectoryDocument,
    placements: Vec<PlacementDocument>,
    spring_types: Vec<SpringTypeDocument>,
}

#[derive(Serialize)]
struct TorquesDocument {
    motor_n_m: Option<f64>,
    spring_n_m: Option<f64>,
}

#[derive(Serialize)]
struct TrajectoryDocument {
    closing_s: f64,
    contact_s: f64,
    stroke_rad: f64,
    start_q11_rad: f64,
    start_q21_rad: f64,
    contact_q11_rad: f64,
    contact_q21_rad: f64,
    end_q11_rad: f64,
    end_q21_rad: f64,
    end_q22_rad: f64,
}

#[derive(Serialize)]
struct PlacementDocument {
    placement: &'static str,
    spring_n_m: f64,
}

#[derive(Serialize)]
struct SpringTypeDocument {
    spring: &'static str,
    stiffness_n_m_per_rad: f64,
    preload_rad: Option<f64>,
    motor_peak_after_contact_n_m: f64,
    motor_rms_after_contact_n_m: f64,
}

impl From<SizingReport<'_>> for SizingDocument {
    fn from(report: SizingReport<'_>) -> Self {
        let profile = report.profile;
        let closing = &profile.closing;
        let torques = |sizing: &Sizing| TorquesDocument {
            motor_n_m: Some(sizing.motor_n_m),
            spring_n_m: Some(sizing.spring_n_m),
        };
        let chosen = match report.rule {
            Rule::Rigid => profile.rigid,
            Rule::Whole => profile.whole,
        };
        let [constant, torsional] = after_contact(profile);
        let spring_type = |spring, stiffness_n_m_per_rad, preload_rad, [peak, rms]: [f64; 2]| SpringTypeDocument {
            spring,
            stiffness_n_m_per_rad,
            preload_rad,
            motor_peak_after_contact_n_m: peak,
            motor_rms_after_contact_n_m: rms,
        };
        SizingDocument {
            scene: report.scene.to_string(),
            rule: report.rule.name(),
            motor_n_m: chosen.motor_n_m,
            spring_n_m: chosen.spring_n_m,
            rigid: torques(&profile.rigid),
            whole: torques(&profile.whole),
            given: TorquesDocument { motor_n_m: report.given_motor_n_m, spring_n_m: report.given_spring_n_m },
            convergence_relative: profile.convergence,
            intervals: crate::sizing::INTERVALS,
            trajectory: TrajectoryDocument {
                closing_s: closing.trajectory.length_s,
                contact_s: closing.contact_s(),
                stroke_rad: closing.trajectory.stroke_rad,
                start_q11_rad: closing.start.q11_rad,
                start_q21_rad: closing.start.q21_rad,
                contact_q11_rad: closing.trajectory.at(closing.contact_x).angle_rad,
                contact_q21_rad: closing.q21_contact_rad,
                end_q11_rad: closing.end.posture.q11_rad,
                end_q21_rad: closing.end.posture.q21_rad,
                end_q22_rad: closing.end.posture.q22_rad,
            },
            placements: Placement::ALL
                .into_iter()
                .zip(profile.placements_n_m)
                .map(|(placement, spring_n_m)| PlacementDocument { placement: placement.name(), spring_n_m })
                .collect(),
            spring_types: vec![
                spring_type("constant", 0.0, None, constant),
                spring_type("torsional", profile.torsional_n_m_per_rad, Some(report.preload_rad), torsional),
            ],
        }
    }
}

/// The profile, one sample a line; torques of the rigid phase are empty after it.
pub fn sizing_csv(profile: &Profile) -> String {
    let mut text =
        "time_s,q11_rad,q21_rad,q22_rad,qd11_rad_s,qdd11_rad_s2,spring_q21_q11_n_m,spring_q12_n_m,spring_q22_n_m,\
                    spring_coupler_distal_n_m,motor_net_n_m,motor_constant_spring_n_m,motor_torsional_spring_n_m\n"
            .to_string();
    for point in &profile.points {
        let springs = point.springs_n_m.unwrap_or([f64::NAN; 4]);
        let motion = [point.time_s, point.q11_rad, point.q21_rad, point.q22_rad, point.qd11_rad_s, point.qdd11_rad_s2];
        let motor = [point.net_n_m.unwrap_or(f64::NAN), point.constant_n_m, point.torsional_n_m];
        let cells: Vec<String> = motion.into_iter().chain(springs).chain(motor).map(csv::cell).collect();
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text
}
