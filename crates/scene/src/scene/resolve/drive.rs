//! Motor and spring of a finger.

use super::super::check::{Checker, POSITIVE};
use super::super::entry::item_span;
use super::super::table::drive::{MotorSettings, ShaftSettings, SpringSettings};
use super::super::table::input::SectionInput;
use super::super::table::{SettingsSection, read};
use super::super::value_kinds::{Choice, List, Time, Torque};
use super::super::{self as scene, Actuation, Spring, SpringKind};
use super::sizing::SizingResult;

const TORQUE: &str = "add the motor's torque on l11: [motor] torque = \"480 N*mm\"";

/// Resolves the motor, with the torque of the sizing for [`SizingResult::Sized`].
pub fn motor(checker: &mut Checker<'_>, input: &SectionInput<'_>, sized: SizingResult) -> Option<scene::Motor> {
    let actuation = actuation(checker, input, sized)?;
    let shaft = read(checker, "motor", input, ShaftSettings::defaults());
    if let Some(brake) = shaft.brake
        && shaft.release_s().is_some_and(|release_s| release_s < brake.start_s + brake.rise_s)
    {
        checker.push(
            input.span("brake_release"),
            "`motor.brake_release` is before the brake is fully engaged, at brake_at + brake_rise",
            "too early",
            "release the brake later, or remove this key: then the brake is never released",
        );
    }
    Some(shaft.into_motor(actuation))
}

/// Resolves the motor torque as a function of time.
fn actuation(checker: &mut Checker<'_>, input: &SectionInput<'_>, sized: SizingResult) -> Option<Actuation> {
    let mut motor = read(checker, "motor", input, MotorSettings::defaults());
    // If the profile is invalid, the required keys are unknown.
    input.is_valid::<Choice<Actuation>>("profile").then_some(())?;
    if let Actuation::Table { interpolation, .. } = motor.actuation {
        return Some(Actuation::Table { points: table(checker, input)?, interpolation });
    }
    match sized {
        SizingResult::NotRequested if !input.has("torque") => {
            checker.report_missing_at("motor.torque", input.span.clone(), TORQUE)
        }
        SizingResult::NotRequested | SizingResult::Failed => {}
        SizingResult::Sized(sizing) => motor.torque_n_m().into_iter().for_each(|torque| *torque = sizing.motor_n_m),
    }
    Some(motor.actuation)
}

/// Reads the points of a table.
fn table(checker: &mut Checker<'_>, input: &SectionInput<'_>) -> Option<Vec<(f64, f64)>> {
    for key in ["times", "torques"] {
        if !input.has(key) {
            let help = "a table requires both: times = [\"0 ms\", \"5 ms\"] and torques = [\"0 N*mm\", \"480 N*mm\"]";
            checker.report_missing_at(&format!("motor.{key}"), input.span.clone(), help);
        }
    }
    let (times, torques) = (input.value::<List<Time>>("times")?, input.value::<List<Torque>>("torques")?);
    if times.is_empty() {
        checker.push(
            input.span("times"),
            "the table of the motor is empty",
            "no times",
            "give at least one time and torque",
        );
        return None;
    }
    if times.len() != torques.len() {
        let message = format!("the table of the motor has {} times, but {} torques", times.len(), torques.len());
        checker.push(input.span("torques"), message, "different number", "give one torque per time");
        return None;
    }
    if let Some(i) = (1..times.len()).find(|&i| times[i] <= times[i - 1]) {
        let message = format!("the times of the motor's table do not increase: value {} is not after value {i}", i + 1);
        let time_span = input.get("times").map(|times| item_span(times, i));
        checker.push(
            time_span,
            message,
            "not later than the preceding time",
            "put the times in increasing order, without duplicates",
        );
        return None;
    }
    Some(times.into_iter().zip(torques).collect())
}

/// Resolves the spring: `Some(None)` without a spring, `None` if it is invalid.
pub fn spring(checker: &mut Checker<'_>, input: &SectionInput<'_>, sized: SizingResult) -> Option<Option<Spring>> {
    let problem_count = checker.count();
    let mut spring = read(checker, "spring", input, SpringSettings::defaults());
    let is_valid = checker.count() == problem_count;
    input.is_valid::<Choice<Option<SpringKind>>>("type").then_some(())?;
    match (&mut spring.kind, sized) {
        (None, _) => {}
        (Some(SpringKind::Constant { .. }), SizingResult::NotRequested) if !input.has("torque") => {
            let help = "add the spring's torque: [spring] torque = \"132.6 N*mm\"; or remove the spring: [spring] type = \"none\"";
            checker.report_missing_at("spring.torque", input.span.clone(), help);
        }
        (Some(SpringKind::Torsional { .. }), SizingResult::NotRequested) if !input.has("stiffness") => {
            checker.report_missing_at(
                "spring.stiffness",
                input.span.clone(),
                "add the spring's stiffness: stiffness = \"100 N*mm/rad\"",
            );
        }
        (Some(_), SizingResult::NotRequested) => {}
        (Some(SpringKind::Constant { torque_n_m }), SizingResult::Failed | SizingResult::Sized(_)) => {
            *torque_n_m = sized.sizing()?.spring_n_m;
        }
        // c_s q_p = k_s (2.30): the same torque in the straight configuration.
        (
            Some(SpringKind::Torsional { stiffness_n_m_per_rad, preload_rad }),
            SizingResult::Failed | SizingResult::Sized(_),
        ) => {
            if !input.has("preload") {
                let help = "add the preload, by which the sizing determines the stiffness: preload = \"90 deg\"";
                checker.report_missing_at("spring.preload", input.span.clone(), help);
            } else if is_valid && *preload_rad == 0.0 {
                checker.report_out_of_range("spring.preload", input.span("preload"), POSITIVE);
            }
            *stiffness_n_m_per_rad = sized.sizing()?.spring_n_m / *preload_rad;
        }
    }
    Some(spring.spring())
}
