//! Reports of studies of one gripper or finger: captured positioning errors, withstood accelerations, and sizing.

use serde::{Serialize, Serializer};
use serde_json::json;

use super::named::Object;
use super::rows_csv;
use super::samples::cell;
use super::tables::milliseconds;
use crate::format::format_duration;
use crate::format::numbers::{G_M_S2, format_number, or_dash, row, zero_below_resolution};
use crate::format::report::{Report, Table, ToReport, table};
use crate::gripper::Placement;
use crate::sizing::{Profile, ProfilePoint, Rule, Sizing};
use crate::statics::MechanismLimit;
use crate::study::capture::{Capture, Edge, ObjectPlacement};
use crate::study::hold::{Hold, LoadBracket, LoadCase, LoadResult, LoadSize, Loads, StartReason, axis_name};
use crate::study::size::FingerSizing;
use crate::units::Dimension;

impl ToReport for Capture {
    fn report(&self) -> Report {
        let mut text = Report::from(format!(
            "{}: {} model, palm {} mm wide, designed for errors up to ±{} mm\n\n",
            crate::scene::one_line(&self.scene),
            self.plan.model.name(),
            resolved_mm(self.palm_width_m),
            resolved_mm(self.plan.error_m)
        ));
        let mut rows = vec![
            row(["start", "form-closed", "fate", "end", "", "speed,", "tts,", "slip,", "form-closed"]),
            row(["x, mm", "at start", "", "x, mm", "y, mm", "mm/s", "ms", "mm", "at the end"]),
        ];
        let length = |value: Option<f64>| or_dash(value, resolved_mm);
        for found in &self.placements {
            rows.push(row([
                &signed_mm(found.offset_m),
                yes_or_no(found.geometric_form_closed),
                found.fate.unwrap_or("failed"),
                &or_dash(found.x_m, signed_mm),
                &length(found.y_m),
                &length(found.speed_m_s),
                &milliseconds(found.tts_s),
                &length(found.slip.map(|slip| slip.displacement_m)),
                yes_or_no(found.form_closed),
            ]));
        }
        text.push(Table::new(&rows).header_rows(2));
        for line in [captured_range(self), centring(self), form_closure(self)] {
            text.push(Report::paragraph(&format!("\n{line}\n")));
        }
        for ObjectPlacement { offset_m, reason, .. } in &self.placements {
            if let Some(reason) = reason {
                text.push_str(&format!("at {} mm: {reason}\n", signed_mm(*offset_m)));
            }
        }
        text
    }
}

/// Formats a length in mm; lengths below the resolution are 0.
fn resolved_mm(metres: f64) -> String {
    format_number(zero_below_resolution(metres, Dimension::Length) * 1e3, 4)
}

fn signed_mm(metres: f64) -> String {
    let sign = match zero_below_resolution(metres, Dimension::Length) {
        metres if metres > 0.0 => "+",
        metres if metres < 0.0 => "−",
        _ => "",
    };
    format!("{sign}{}", resolved_mm(metres.abs()))
}

fn yes_or_no(flag: Option<bool>) -> &'static str {
    flag.map_or("–", |flag| if flag { "yes" } else { "no" })
}

fn captured_range(study: &Capture) -> String {
    let Some(edges) = study.captured_range else {
        return "Captured: no range; an object in the middle of the palm is not held.".to_string();
    };
    let [from, to] = edges.map(|Edge { captured_m, lost_m }| match lost_m {
        Some(lost_m) => format!("{} mm (not at {} mm)", signed_mm(captured_m), signed_mm(lost_m)),
        None => format!("{} mm (the requested limit)", signed_mm(captured_m)),
    });
    format!("Captured: from {from} to {to}.")
}

fn centring(study: &Capture) -> String {
    let held = study.placements.iter().filter(|placement| placement.is_captured() && placement.offset_m != 0.0);
    let ends = held.filter_map(|it| Some((it.offset_m.abs(), it.x_m?.abs())));
    let Some(worst_m) = ends.clone().map(|(_, end)| end).max_by(f64::total_cmp) else {
        return "Centred: no object that starts away from the middle is held.".to_string();
    };
    format!(
        "Centred: {} of {} held objects that start away from the middle end closer to it; all end within {} mm of it.",
        ends.clone().filter(|(start, end)| end < start).count(),
        ends.count(),
        format_number(worst_m * 1e3, 4)
    )
}

/// Reports whether grasps that are not form-closed become so, which is a question of the thesis.
fn form_closure(study: &Capture) -> String {
    let held = study.placements.iter().filter(|placement| placement.is_captured());
    let is_closed = |it: &&ObjectPlacement| it.form_closed == Some(true);
    let initially_open = held.clone().filter(|placement| placement.geometric_form_closed != Some(true));
    format!(
        "Form closure: {} of {} held objects start where no form-closed grasp with all phalanges exists; {} of them \
         are form-closed at the end.\nAt the end, {} of {} are form-closed.",
        initially_open.clone().count(),
        held.clone().count(),
        initially_open.filter(is_closed).count(),
        held.clone().filter(is_closed).count(),
        held.count()
    )
}

/// Returns all initial positions as CSV, one per line. Unknown values are empty.
pub(crate) fn capture_csv(study: &Capture) -> String {
    const COLUMNS: &str = "offset_m form_closed_there fate tts_s x_m y_m angle_rad speed_m_s slip_m=slip/displacement_m \
                           slip_rad=slip/rotation_rad form_closed steps reason";
    rows_csv(study.placements.iter().map(|placement| json!(placement)), COLUMNS)
}

impl ToReport for Hold {
    fn report(&self) -> Report {
        let start = match self.start_reason {
            StartReason::Requested => "as requested",
            StartReason::AtRest => "when the object is at rest",
            StartReason::StillMoving => "at the end of the scene, while the object still moves",
            StartReason::MoveCompleted => "after the first of the scene's moves",
            StartReason::OwnMove => "at the start of the scene's own moves",
        };
        let loads = match self.plan.loads {
            Loads::Pulses { length_s, .. } => format!("pulses of {}", format_duration(length_s)),
            Loads::Vibrations { .. } => "vibrations".to_string(),
            Loads::Move => "moves".to_string(),
        };
        let base = self.base.as_ref().map_or("the palm".to_string(), |base| format!("the base `{base}`"));
        let removed = match &self.removed[..] {
            [] => String::new(),
            [one] => format!("From then on, `{one}` is removed, which they would hit. "),
            several => format!("From then on, `{}` are removed, which they would hit. ", several.join("`, `")),
        };
        let assumed = match &self.assumed_hand[..] {
            [] => String::new(),
            names => format!(
                "\n`{}` moves with the base as part of the hand; list it under [grasp] surroundings if it is a table.",
                names.join("`, `")
            ),
        };
        let mut text = Report::from(format!(
            "{}: {} model, {loads}\n",
            crate::scene::one_line(&self.scene),
            self.plan.model.name()
        ));
        if let Some(line) = smallest_limit(self) {
            text.push(Report::paragraph(&format!("{line}\n")));
        }
        text.push(Report::paragraph(&format!(
            "Loads start at {}, {start}. {removed}Without a load, the object slips by {} mm in the same time. {} runs.{assumed}\nResults by \
             load and peak acceleration of {base}:\n\n",
            format_duration(self.setup.start_s),
            millimetres(self.unloaded.slip.displacement_m),
            self.results.iter().map(|load| load.evaluations.len()).sum::<usize>()
        )));
        for load in &self.results {
            text.push_str(&format!("{}: {}\n", load_name(&load.case, self), describe_load(load, self)));
        }
        text.push_str("\n");
        if self.results.iter().any(|load| load.static_limit.is_some()) {
            text.push(Report::paragraph(
                "Balance at rest refers to the contacts that are active at the start of the loads, in both directions.\n",
            ));
        }
        for line in unreached_limits(self).into_iter().chain(self.results.iter().flat_map(|load| remarks(load, self))) {
            text.push(Report::paragraph(&format!("{line}\n")));
        }
        text
    }
}

fn millimetres(metres: f64) -> String {
    format_number(metres * 1e3, 3)
}

fn describe_load(load: &LoadResult, study: &Hold) -> String {
    let bound = millimetres(study.plan.slip_m);
    let up_to = |limit: &LoadBracket, size: &str| {
        let mark = if limit.held_above.is_none() && limit.unknown == 0 { "" } else { " *" };
        let largest = if limit.failed.is_none() { ", the largest load" } else { "" };
        limit.held.map(|held| format!("up to {}{mark}{largest}", peak(held, size)))
    };
    let size = load.held_size(&load.slips).map_or(String::new(), |size| format!(", {}", format_size(size)));
    let fate = load.ended_by(&load.drops).unwrap_or("dropped");
    let slips = match (up_to(&load.slips, &size), load.slips.failed) {
        (Some(up_to), _) => format!("the object slips less than {bound} mm {up_to}"),
        (None, Some(failed)) => {
            format!("the object slips by more than {bound} mm at {}, the smallest load,", peak(failed, ""))
        }
        (None, None) => return "no run under this load was completed *".to_string(),
    };
    let drops = match (up_to(&load.drops, ""), load.drops.failed) {
        (Some(_), None) if load.slips.failed.is_none() => ", and is held".to_string(),
        (Some(up_to), None) => format!(" and is held {up_to}"),
        (Some(up_to), Some(_)) => format!(" and is held {up_to}, above which it is {fate}"),
        (None, Some(_)) => format!(" and is {fate} there"),
        (None, None) => String::new(),
    };
    let balanced = match &load.static_limit {
        None => return format!("{slips}{drops}"),
        Some(MechanismLimit::Infeasible { .. }) => "nothing".to_string(),
        Some(MechanismLimit::Limited { acceleration_m_s2, .. }) => acceleration(*acceleration_m_s2),
        Some(MechanismLimit::Unlimited) => "any acceleration".to_string(),
    };
    format!("{slips}{drops}; contacts at rest balance {balanced}")
}

fn acceleration(m_s2: f64) -> String {
    format!("{} m/s²", format_number(m_s2, 4))
}

fn peak(m_s2: f64, size: &str) -> String {
    format!("{} ({} g{size})", acceleration(m_s2), format_number(m_s2 / G_M_S2, 3))
}

fn format_size(LoadSize { key, value }: LoadSize) -> String {
    match key {
        "distance_m" => format!("over {} mm", millimetres(value)),
        "amplitude_m" => format!("amplitude {} mm", millimetres(value)),
        "amplitude_rad" => format!("amplitude {}°", format_number(value.to_degrees(), 3)),
        _ => format!("in {} ms", millimetres(value)),
    }
}

fn load_name(case: &LoadCase, study: &Hold) -> String {
    match *case {
        LoadCase::Pulse { direction_rad, .. } => {
            let degrees = (direction_rad.to_degrees() * 10.0).round() / 10.0;
            let [out, into] = if study.base.is_none() { [" (out of the palm)", " (into it)"] } else { [""; 2] };
            let axes = [(0.0, ", +x", ""), (90.0, ", +y", out), (180.0, ", −x", ""), (270.0, ", −y", into)];
            let name = axes.iter().find(|(angle, ..)| *angle == degrees);
            name.map_or(format!("{degrees}°"), |(_, axis, side)| format!("{degrees}°{axis}{side}"))
        }
        LoadCase::Vibration { axis, frequency_hz } => {
            format!("{}, {} Hz", axis_name(axis), format_number(frequency_hz, 4))
        }
        LoadCase::Move => "move".to_string(),
    }
}

fn smallest_limit(study: &Hold) -> Option<String> {
    let failed = study.results.iter().filter_map(|load| Some((load, load.slips.failed?)));
    let Some((load, failed)) = failed.min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Some("No load makes the object slip by more than the bound.".to_string());
    };
    let name = load_name(&load.case, study);
    match load.slips.held {
        Some(_) if study.results.len() == 1 => None,
        Some(held) => Some(format!("Smallest limit: {}, {name}.", peak(held, ""))),
        None => Some(format!(
            "Smallest limit: below {}, {name}; start at a smaller load with --from.",
            acceleration(failed)
        )),
    }
}

fn unreached_limits(study: &Hold) -> Option<String> {
    let is_unreached = |load: &&LoadResult| {
        load.to_m_s2 == study.plan.to_m_s2 && (load.slips.failed.is_none() || load.drops.failed.is_none())
    };
    let count = study.results.iter().filter(is_unreached).count();
    let plural = if count == 1 { "" } else { "s" };
    (count > 0).then(|| {
        format!(
            "{count} load{plural} of {}: a limit is not reached at {}, the largest load; raise --to.",
            study.results.len(),
            acceleration(study.plan.to_m_s2)
        )
    })
}

fn remarks(load: &LoadResult, study: &Hold) -> Vec<String> {
    let (mut notes, name) = (Vec::new(), load_name(&load.case, study));
    for (limit, fails) in [(&load.slips, "the object slips or is dropped"), (&load.drops, "the object is dropped")] {
        if let Some((failed, above)) = limit.failed.zip(limit.held_above) {
            notes.push(format!(
                "* {name}: not monotone: {fails} at {}, but not at {}; the limit is the first failure of {} loads, refined by \
                 bisection.",
                acceleration(failed),
                acceleration(above),
                study.plan.scan
            ));
        }
        if limit.unknown > 0 {
            let ends: Vec<String> = [limit.held, limit.failed].into_iter().flatten().map(acceleration).collect();
            notes.push(format!(
                "* {name}: runs not completed: {}, next to {}; the limit is not refined there.",
                limit.unknown,
                ends.join(" and ")
            ));
        }
    }
    if load.to_m_s2 < study.plan.to_m_s2 {
        notes.push(format!(
            "{name}: loads end at {}, because a larger load would press the object against the table.",
            acceleration(load.to_m_s2)
        ));
    }
    // Both limits often give the same note.
    notes.dedup();
    let reasons = load.evaluations.iter().filter_map(|run| Some((run.peak_m_s2, run.outcome.as_ref().err()?)));
    notes.extend(reasons.map(|(peak, reason)| format!("{name}, {}: {reason}", acceleration(peak))));
    notes
}

/// Returns all runs as CSV, one per line. Unknown values are empty.
pub(crate) fn hold_csv(study: &Hold) -> String {
    const COLUMNS: &str = "load direction_rad axis frequency_hz peak_m_s2=run/peak_m_s2 distance_m=run/distance_m \
                           amplitude_m=run/amplitude_m amplitude_rad=run/amplitude_rad time_s=run/time_s fate=run/fate \
                           slip_m=run/slip/displacement_m slip_rad=run/slip/rotation_rad \
                           brake_slip_rad=run/brake_slip_rad end_s=run/end_s steps=run/steps reason=run/reason";
    let runs = study.results.iter().flat_map(|load| load.evaluations.iter().map(|run| (&load.case, run)));
    let rows = runs.map(|(case, run)| {
        let mut row = json!(case.object());
        row["run"] = json!(run);
        row
    });
    rows_csv(rows, COLUMNS)
}

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
            "{}: test trajectory of {}, q11 over {} deg, proximal contact at {}\n\n",
            crate::scene::one_line(scene),
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

        text.push("\n");
        let line = |name: &str, rule: Rule, sizing: &Sizing| {
            let marker = if rule == self.options.rule { "<-" } else { "" };
            row([name, &torque(sizing.motor_n_m), &torque(sizing.spring_n_m), marker])
        };
        text.push(table(&[
            row(["", "motor τ11, N·mm", "spring k_s, N·mm", ""]),
            line("rigid: RMS until the contact", Rule::Rigid, &profile.rigid),
            line("whole: RMS of the whole trajectory", Rule::Whole, &profile.whole),
            row(["in the scene", &or_dash(self.given_motor_n_m, torque), &or_dash(self.given_spring_n_m, torque), ""]),
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
        text.push("\n");
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
