//! Motor and spring of a finger, given or sized.

use super::super::error::Problem;
use super::super::section_input::SectionInput;
use super::super::settings::{InitialSettings, MotorSettings, SpringSettings};
use super::super::{Actuation, Motor, Spring, SpringKind};
use super::finger::{FingerLengths, geometry};
use super::object::Target;
use crate::gripper::{Finger, contact_angle_proximal};
use crate::shape::PlacedShape;
use crate::sizing::{INTERVALS, Sizing, SizingError, Task, size_with};

/// Result of the sizing of motor and spring: `Some(None)` if the scene does not request it, `None` if it failed.
pub(crate) type SizingResult = Option<Option<Sizing>>;

/// Combines the sizings of two tasks: the spring has the larger torque, the motor the one that `motors` selects.
pub fn combine(first: Sizing, second: Sizing, motors: fn(f64, f64) -> f64) -> Sizing {
    Sizing { motor_n_m: motors(first.motor_n_m, second.motor_n_m), spring_n_m: first.spring_n_m.max(second.spring_n_m) }
}

/// Resolves the motor, with the torque of the sizing if there is one.
pub fn motor(input: &SectionInput<'_>, sized: SizingResult) -> Option<Motor> {
    let settings: MotorSettings = input.read();
    // If the profile is invalid, the required keys are unknown.
    input.is_valid("profile").then_some(())?;
    let actuation = match (&settings.profile.0, sized) {
        (Actuation::Table { .. }, _) => {
            Actuation::Table { points: table(input, &settings)?, interpolation: settings.interpolation.0 }
        }
        (_, Some(None)) if !input.has("torque") => {
            input.report_missing("torque", "add the motor's torque on l11: [motor] torque = \"480 N*mm\"");
            return None;
        }
        _ => settings
            .actuation(sized.flatten().map_or(*settings.torque.unwrap_or_default(), |sizing| sizing.motor_n_m))?,
    };
    let motor = settings.motor(actuation)?;
    if let Some(brake) = motor.brake
        && brake.release_s.is_some_and(|release_s| release_s < brake.start_s + brake.rise_s)
    {
        let message = "`motor.brake_release` is before the brake is fully engaged, at brake_at + brake_rise";
        let help = "release the brake later, or remove this key: then the brake is never released";
        input.report("brake_release", message, "too early", help);
    }
    Some(motor)
}

/// Returns the points of a table.
fn table(input: &SectionInput<'_>, settings: &MotorSettings) -> Option<Vec<(f64, f64)>> {
    for key in ["times", "torques"].into_iter().filter(|key| !input.has(key)) {
        let help = "a table requires both: times = [\"0 ms\", \"5 ms\"] and torques = [\"0 N*mm\", \"480 N*mm\"]";
        input.report_missing(key, help);
    }
    let (times, torques) = (settings.times.as_ref()?, settings.torques.as_ref()?);
    if times.is_empty() {
        input.report("times", "the table of the motor is empty", "no times", "give at least one time and torque");
        return None;
    }
    if times.len() != torques.len() {
        let message = format!("the table of the motor has {} times, but {} torques", times.len(), torques.len());
        input.report("torques", message, "different number", "give one torque per time");
        return None;
    }
    if let Some(i) = (1..times.len()).find(|&i| *times[i] <= *times[i - 1]) {
        let message = format!("the times of the motor's table do not increase: value {} is not after value {i}", i + 1);
        let help = "put the times in increasing order, without duplicates";
        let label = "not later than the preceding time";
        input.checker.push(Problem::new(input.item_span("times", i), message, label, help));
        return None;
    }
    Some(times.iter().zip(torques).map(|(time, torque)| (**time, **torque)).collect())
}

/// Resolves the spring: `Some(None)` without a spring, `None` if it is invalid.
pub fn spring(input: &SectionInput<'_>, sized: SizingResult) -> Option<Option<Spring>> {
    let settings: SpringSettings = input.read();
    input.is_valid("type").then_some(())?;
    let preload_rad = *settings.preload;
    let kind = match (settings.r#type.0, sized) {
        (None, _) => return Some(None),
        (Some(SpringKind::Constant { .. }), Some(None)) => {
            if !input.has("torque") {
                let help = "add the spring's torque: [spring] torque = \"132.6 N*mm\"; or remove the spring: [spring] type = \"none\"";
                input.report_missing("torque", help);
            }
            SpringKind::Constant { torque_n_m: *settings.torque? }
        }
        (Some(SpringKind::Torsional { .. }), Some(None)) => {
            if !input.has("stiffness") {
                input.report_missing("stiffness", "add the spring's stiffness: stiffness = \"100 N*mm/rad\"");
            }
            SpringKind::Torsional { stiffness_n_m_per_rad: *settings.stiffness?, preload_rad }
        }
        (Some(SpringKind::Constant { .. }), _) => SpringKind::Constant { torque_n_m: sized.flatten()?.spring_n_m },
        // c_s q_p = k_s (2.30): the same torque in the straight configuration.
        (Some(SpringKind::Torsional { .. }), _) => {
            if !input.has("preload") {
                let help = "add the preload, by which the sizing determines the stiffness: preload = \"90 deg\"";
                input.report_missing("preload", help);
            } else if input.is_valid("preload") && preload_rad == 0.0 {
                input.report_out_of_range("preload", "above 0");
            }
            SpringKind::Torsional { stiffness_n_m_per_rad: sized.flatten()?.spring_n_m / preload_rad, preload_rad }
        }
    };
    Some(Some(Spring { kind, placement: settings.placement.0 }))
}

/// Sizes motor and spring for both ends of the positioning error (thesis §4.2.1.3), if the scene requests it. One end may
/// be out of reach of the finger, which then touches the object only after the other finger has moved it.
/// `finger_and_target` is the finger with its target, `None` if they are invalid.
pub fn size(
    input: &SectionInput<'_>,
    lengths: &FingerLengths,
    finger_and_target: Option<(&Finger, &Target)>,
    gravity_m_s2: [f64; 2],
) -> SizingResult {
    if !input.has("sizing") {
        input.report_unused("closing_time", "without sizing = \"rigid\" or \"whole\"");
        return Some(None);
    }
    reject_given(input);
    let (finger, target) = finger_and_target?;
    if target.object.is_none() {
        let message = "`sizing` needs the object that the finger closes on, and this scene has none";
        let help = "give [motor] torque and [spring] torque instead, or remove [object] present = false";
        input.report("sizing", message, "requires an object", help);
        return None;
    }
    let has_range = target.ends.windows(2).any(|pair| pair[0] != pair[1]);
    let mut sized = Vec::new();
    for object in &target.ends {
        let trial = input.checker.for_trial();
        let sizing = size_for(&input.with_checker(&trial), lengths, finger, *object, gravity_m_s2);
        let mut problems = trial.into_problems();
        if has_range {
            let base = -object.centre_m[0] * 1e3;
            let details = format!(
                " with the object at the end of the positioning error, {base:.3} mm from the ground joint along the palm"
            );
            let failed = problems.iter_mut().filter(|problem| problem.label == SIZING_LABEL);
            failed.for_each(|problem| problem.message.push_str(&details));
        }
        sized.push((sizing, problems));
    }
    let reachable = sized.iter().filter_map(|(sizing, _)| *sizing);
    let combined = reachable.reduce(|first, second| combine(first, second, f64::max));
    for (sizing, problems) in sized {
        if sizing.is_some() || combined.is_none() {
            input.checker.extend(problems);
        }
    }
    combined.map(Some)
}

/// Sizes motor and spring for one position of the object.
fn size_for(
    input: &SectionInput<'_>,
    lengths: &FingerLengths,
    finger: &Finger,
    object: PlacedShape,
    gravity_m_s2: [f64; 2],
) -> Option<Sizing> {
    let (opening_rad, rule) = (opening(input, finger, object)?, lengths.rule?);
    let placement = input.subsection("spring").read::<SpringSettings>().placement.0;
    let task = Task { object, opening_rad, gravity_m_s2, closing_s: lengths.closing_s };
    geometry(input, "sizing", SIZING_LABEL, size_with(finger, &task, rule, placement, INTERVALS))
}

/// Reports values that are given in addition to the sizing.
fn reject_given(input: &SectionInput<'_>) {
    let (motor, spring) = (input.subsection("motor"), input.subsection("spring"));
    for (section, key) in [(&motor, "torque"), (&spring, "torque"), (&spring, "stiffness")] {
        if section.has(key) {
            let message = format!("`{}` is given, but `sizing` determines it", section.path(key));
            section.report(key, message, "conflicts with `sizing`", "remove this key, or remove `sizing`");
        }
    }
    if motor.is_valid("profile") && matches!(motor.read::<MotorSettings>().profile.0, Actuation::Table { .. }) {
        let message = "`sizing` determines the motor torque, but profile = \"table\" gives all torques";
        let help = "remove `sizing` and give [spring] torque, or choose another profile";
        motor.report("profile", message, "has its own torques", help);
    }
    if spring.read::<SpringSettings>().r#type.0.is_none() {
        let message = "`sizing` sizes motor and spring together, but this scene has no spring";
        spring.report("type", message, "no spring", "remove `sizing` and give [motor] torque, or add a spring");
    }
}

/// q_0, the initial angle before the proximal contact.
fn opening(input: &SectionInput<'_>, finger: &Finger, object: PlacedShape) -> Option<f64> {
    let start = input.subsection("initial");
    if start.has("q11") {
        let message =
            "`sizing` uses a test trajectory with a straight initial configuration, but `q11` may give another one";
        let help = "give only `q21` or `offset` for a straight start, or give [motor] torque and [spring] torque instead of `sizing`";
        start.report("q11", message, "not allowed with sizing", help);
        return None;
    }
    let settings: InitialSettings = start.read();
    if !start.has("q21") {
        // The sizing checks that it is above 0.
        return settings.offset.map(|offset| *offset);
    }
    let q21_rad = *settings.q21?;
    let contact = contact_angle_proximal(finger.lengths.half_width_m, object).map_err(SizingError::from);
    Some(geometry(input, "sizing", SIZING_LABEL, contact)? - q21_rad)
}

/// Label of an impossible sizing.
const SIZING_LABEL: &str = "this finger cannot be sized";
