//! Motor and spring sized to the finger, where the scene says so.

use super::super::check::Checker;
use super::super::kinds::Choice;
use super::super::table::finger::Links;
use super::super::table::keys::Keys;
use super::super::{Actuation, Placement, SpringKind};
use super::finger::geometry;
use crate::gripper::{Finger, contact_angle_proximal};
use crate::shape::Placed;
use crate::sizing::{INTERVALS, Sizing, SizingError, Task, size_with};

/// Whether motor and spring come from a sizing.
#[derive(Clone, Copy, Debug)]
pub enum Sized {
    /// The scene gives its torques.
    Not,
    /// It asks for a sizing, of which something is wrong; that is noted.
    Wrong,
    By(Sizing),
}

impl Sized {
    /// What does for both of two tasks: of motor and of spring the larger one (thesis §4.2.1.3).
    pub fn for_both(self, other: Self) -> Self {
        self.merged(other, f64::max, f64::max)
    }

    /// What one motor needs that drives two fingers in equal parts; springs stay with the fingers.
    pub fn of_both_motors(self, other: Self) -> Self {
        self.merged(other, |one, other| one + other, f64::max)
    }

    fn merged(self, other: Self, motors: fn(f64, f64) -> f64, springs: fn(f64, f64) -> f64) -> Self {
        match (self, other) {
            (Sized::By(one), Sized::By(other)) => Sized::By(Sizing {
                motor_n_m: motors(one.motor_n_m, other.motor_n_m),
                spring_n_m: springs(one.spring_n_m, other.spring_n_m),
            }),
            (Sized::Not, Sized::Not) => Sized::Not,
            _ => Sized::Wrong,
        }
    }

    pub fn sizing(self) -> Option<Sizing> {
        match self {
            Sized::By(sizing) => Some(sizing),
            Sized::Not | Sized::Wrong => None,
        }
    }
}

/// Sizes motor and spring, if the scene asks for it; `sound` is what of the scene it stands on.
pub fn sizing(
    c: &mut Checker<'_>,
    raw: &Keys<'_>,
    said: &Links,
    sound: Option<(&Finger, &Option<Placed>)>,
    gravity_m_s2: [f64; 2],
) -> Sized {
    if !raw.has("sizing") {
        c.unused_at("closing_time", raw.span("closing_time"), "without sizing = \"rigid\" or \"whole\"");
        return Sized::Not;
    }
    refuse_given(c, raw);
    let Links { sizing: rule, closing_s, .. } = *said;
    let placement = raw.inner("spring").value::<Choice<Placement>>("placement").unwrap_or(Placement::Phalanges);
    let (Some((finger, object)), Some(rule)) = (sound, rule) else {
        return Sized::Wrong;
    };
    let Some(object) = object else {
        c.push(
            raw.span("sizing"),
            "`sizing` needs the object that the finger closes on, and this scene has none",
            "nothing to close on",
            "give [motor] torque and [spring] torque instead, or remove [object] present = false",
        );
        return Sized::Wrong;
    };
    let Some(opening_rad) = opening(c, raw, finger, *object) else {
        return Sized::Wrong;
    };
    let task = Task { object: *object, opening_rad, gravity_m_s2, closing_s };
    match size_with(finger, &task, rule, placement, INTERVALS) {
        Ok(sizing) => Sized::By(sizing),
        Err(error) => {
            refuse(c, raw, &error);
            Sized::Wrong
        }
    }
}

/// What would be given twice.
fn refuse_given(c: &mut Checker<'_>, raw: &Keys<'_>) {
    let given = [
        ("motor.torque", raw.inner("motor").span("torque")),
        ("spring.torque", raw.inner("spring").span("torque")),
        ("spring.stiffness", raw.inner("spring").span("stiffness")),
    ];
    for (key, span) in given {
        if span.is_some() {
            let message = format!("`{key}` is given, and `sizing` says it too");
            c.push(span, message, "and here again", "keep one of them: remove this, or remove `sizing`");
        }
    }
    if let Some(Actuation::Table { .. }) = raw.inner("motor").value::<Choice<Actuation>>("profile") {
        c.push(
            raw.inner("motor").span("profile"),
            "`sizing` sizes the motor, but the torques of a table are all given",
            "has its own torques",
            "remove `sizing` and give [spring] torque, or choose another profile",
        );
    }
    if raw.inner("spring").value::<Choice<Option<SpringKind>>>("type") == Some(None) {
        c.push(
            raw.inner("spring").span("type"),
            "`sizing` sizes motor and spring together, but this scene has no spring",
            "no spring",
            "remove `sizing` and give [motor] torque, or let the scene have a spring",
        );
    }
}

/// q_0: how far before the proximal contact the finger starts.
fn opening(c: &mut Checker<'_>, raw: &Keys<'_>, finger: &Finger, object: Placed) -> Option<f64> {
    let start = raw.inner("initial");
    if start.has("q11") {
        c.push(
            start.span("q11"),
            "`sizing` stands on a test trajectory that starts straight, but this start need not be",
            "leave it out",
            "give `q21` or `offset` alone for a straight start, or give [motor] torque and [spring] torque instead of `sizing`",
        );
        return None;
    }
    let (offset, joints) = super::start::start(c, raw);
    if !start.has("q21") {
        // Whether it is above 0 is for the sizing to say.
        return Some(offset);
    }
    let q21_rad = Some(joints.q21_rad).filter(|angle| !angle.is_nan())?;
    let contact = contact_angle_proximal(finger.lengths.half_width_m, object);
    contact.map_err(|error| refuse(c, raw, &SizingError::from(error))).ok().map(|contact| contact - q21_rad)
}

/// What is said at the place of a sizing that is refused.
pub const NOT_SIZED: &str = "this finger cannot be sized";

fn refuse(c: &mut Checker<'_>, raw: &Keys<'_>, error: &SizingError) {
    geometry(c, raw.span("sizing"), NOT_SIZED, &error.to_string());
}
