//! Sizing of motor and spring to the finger, if the scene requests it.

use super::super::check::Checker;
use super::super::table::finger::FingerSettings;
use super::super::table::input::SectionInput;
use super::super::value_kinds::Choice;
use super::super::{Actuation, Placement, SpringKind};
use super::finger::geometry;
use crate::gripper::{Finger, contact_angle_proximal};
use crate::shape::PlacedShape;
use crate::sizing::{INTERVALS, Sizing, SizingError, Task, size_with};

/// Result of the sizing of motor and spring.
#[derive(Clone, Copy, Debug)]
pub enum SizingResult {
    /// The scene does not request a sizing.
    NotRequested,
    /// The requested sizing failed; the problem has been reported.
    Failed,
    Sized(Sizing),
}

impl SizingResult {
    /// Sizing for two tasks: the larger torques of motor and spring (thesis §4.2.1.3).
    pub fn max_torques(self, second: Self) -> Self {
        self.combine(second, f64::max, f64::max)
    }

    /// Sizing of one motor that drives two fingers: the sum of both motor torques.
    pub fn sum_motor_torques(self, second: Self) -> Self {
        self.combine(second, |first, second| first + second, f64::max)
    }

    fn combine(self, second: Self, motors: fn(f64, f64) -> f64, springs: fn(f64, f64) -> f64) -> Self {
        match (self, second) {
            (SizingResult::Sized(first), SizingResult::Sized(second)) => SizingResult::Sized(Sizing {
                motor_n_m: motors(first.motor_n_m, second.motor_n_m),
                spring_n_m: springs(first.spring_n_m, second.spring_n_m),
            }),
            (SizingResult::NotRequested, SizingResult::NotRequested) => SizingResult::NotRequested,
            _ => SizingResult::Failed,
        }
    }

    pub fn sizing(self) -> Option<Sizing> {
        match self {
            SizingResult::Sized(sizing) => Some(sizing),
            SizingResult::NotRequested | SizingResult::Failed => None,
        }
    }
}

/// Sizes motor and spring, if the scene requests it. `finger_and_object` is the finger with its object, `None` if they
/// are invalid.
pub fn sizing(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    settings: &FingerSettings,
    finger_and_object: Option<(&Finger, &Option<PlacedShape>)>,
    gravity_m_s2: [f64; 2],
) -> SizingResult {
    if !input.has("sizing") {
        checker.report_unused_at("closing_time", input.span("closing_time"), "without sizing = \"rigid\" or \"whole\"");
        return SizingResult::NotRequested;
    }
    reject_given(checker, input);
    let FingerSettings { sizing: rule, closing_s, .. } = *settings;
    let placement = input.subsection("spring").value::<Choice<Placement>>("placement").unwrap_or(Placement::Phalanges);
    let (Some((finger, object)), Some(rule)) = (finger_and_object, rule) else {
        return SizingResult::Failed;
    };
    let Some(object) = object else {
        checker.push(
            input.span("sizing"),
            "`sizing` needs the object that the finger closes on, and this scene has none",
            "requires an object",
            "give [motor] torque and [spring] torque instead, or remove [object] present = false",
        );
        return SizingResult::Failed;
    };
    let Some(opening_rad) = opening(checker, input, finger, *object) else {
        return SizingResult::Failed;
    };
    let task = Task { object: *object, opening_rad, gravity_m_s2, closing_s };
    match size_with(finger, &task, rule, placement, INTERVALS) {
        Ok(sizing) => SizingResult::Sized(sizing),
        Err(error) => {
            reject(checker, input, &error);
            SizingResult::Failed
        }
    }
}

/// Reports values that are given in addition to the sizing.
fn reject_given(checker: &mut Checker<'_>, input: &SectionInput<'_>) {
    let sized_keys = [
        ("motor.torque", input.subsection("motor").span("torque")),
        ("spring.torque", input.subsection("spring").span("torque")),
        ("spring.stiffness", input.subsection("spring").span("stiffness")),
    ];
    for (key, span) in sized_keys {
        if span.is_some() {
            let message = format!("`{key}` is given, but `sizing` determines it");
            checker.push(span, message, "conflicts with `sizing`", "remove this key, or remove `sizing`");
        }
    }
    if let Some(Actuation::Table { .. }) = input.subsection("motor").value::<Choice<Actuation>>("profile") {
        checker.push(
            input.subsection("motor").span("profile"),
            "`sizing` determines the motor torque, but profile = \"table\" gives all torques",
            "has its own torques",
            "remove `sizing` and give [spring] torque, or choose another profile",
        );
    }
    if input.subsection("spring").value::<Choice<Option<SpringKind>>>("type") == Some(None) {
        checker.push(
            input.subsection("spring").span("type"),
            "`sizing` sizes motor and spring together, but this scene has no spring",
            "no spring",
            "remove `sizing` and give [motor] torque, or add a spring",
        );
    }
}

/// q_0, the initial angle before the proximal contact.
fn opening(checker: &mut Checker<'_>, input: &SectionInput<'_>, finger: &Finger, object: PlacedShape) -> Option<f64> {
    let start = input.subsection("initial");
    if start.has("q11") {
        checker.push(
            start.span("q11"),
            "`sizing` uses a test trajectory with a straight initial configuration, but `q11` may give another one",
            "not allowed with sizing",
            "give only `q21` or `offset` for a straight start, or give [motor] torque and [spring] torque instead of `sizing`",
        );
        return None;
    }
    let (offset, joints) = super::start::start(checker, input);
    if !start.has("q21") {
        // The sizing checks that it is above 0.
        return Some(offset);
    }
    let q21_rad = Some(joints.q21_rad).filter(|angle| !angle.is_nan())?;
    let contact = contact_angle_proximal(finger.lengths.half_width_m, object);
    contact.map_err(|error| reject(checker, input, &SizingError::from(error))).ok().map(|contact| contact - q21_rad)
}

/// Label of an impossible sizing.
pub const SIZING_LABEL: &str = "this finger cannot be sized";

fn reject(checker: &mut Checker<'_>, input: &SectionInput<'_>, error: &SizingError) {
    geometry(checker, input.span("sizing"), SIZING_LABEL, &error.to_string());
}
