//! What a scene says before its sections.

use super::lines;
use crate::gripper::Assembly;
use crate::scene::check::POSITIVE;
use crate::scene::defaults;
use crate::scene::kinds::{Acceleration, Choice, Flag, Length, Pair, Text, Time};
use crate::scene::words::SceneKind;
use crate::sizing::{CLOSING_S, Rule};

/// What scenes of every kind say; a text is empty where nothing is said.
#[derive(Clone, Debug)]
pub struct Heading {
    pub extends: String,
    pub name: String,
    pub description: String,
    pub kind: SceneKind,
    pub duration_s: f64,
    pub gravity_m_s2: [f64; 2],
}

/// Keys of every heading.
pub const HEADING: [&str; 6] = ["extends", "name", "description", "kind", "duration", "gravity"];

/// Not a number where something must be given, or follows from something else.
const GIVEN: f64 = f64::NAN;

impl Heading {
    fn of(kind: SceneKind, gravity_m_s2: [f64; 2]) -> Self {
        let [extends, name, description] = [const { String::new() }; 3];
        Self { extends, name, description, kind, duration_s: defaults::DURATION_S, gravity_m_s2 }
    }
}

/// The lines of a heading, of which some say other things in other kinds of scene, and those of one kind.
macro_rules! headed {
    (
        $(#[doc = $doc:literal])+
        $section:ident = $usual:expr, $s:ident;
        $(#[doc = $extends:literal])+ extends;
        $(#[doc = $kind:literal])+ kind $(, $and:ident())?;
        $(#[doc = $gravity:literal])+ gravity;
        $($lines:tt)*
    ) => {
        lines! {
            $(#[doc = $doc])+
            $section = $usual, $s;
            $(#[doc = $extends])+
            "extends": Text = Some(&mut $s.heading.extends);
            /// Name in reports and logs. Default: the file's name without its extension.
            "name": Text = Some(&mut $s.heading.name);
            /// What the scene is for; not used by the simulation.
            "description": Text = Some(&mut $s.heading.description);
            $(#[doc = $kind])+
            "kind": Choice<SceneKind> = Some(&mut $s.heading.kind) $(, $and())?;
            /// Simulated time.
            "duration": Time = Some(&mut $s.heading.duration_s), allowed(POSITIVE);
            $(#[doc = $gravity])+
            "gravity": Pair<Acceleration> = Some(&mut $s.heading.gravity_m_s2);
            $($lines)*
        }
    };
}

/// Before the sections of a finger.
#[derive(Clone, Debug)]
pub struct FingerKeys {
    pub heading: Heading,
    pub half_width_m: f64,
    pub assembly: Assembly,
    pub palm: bool,
    /// `None` where motor and spring are given.
    pub sizing: Option<Rule>,
    /// Means nothing without a sizing.
    pub closing_s: f64,
}

headed! {
    /// A scene: one gripper variant, the object it grasps, and how it is simulated. A scene says only what differs from the
    /// defaults. Quantities are texts with a unit: "15 mm", "120 deg", "480 N*mm".
    FingerKeys = Self {
        heading: Heading::of(SceneKind::Finger, defaults::GRAVITY_M_S2),
        half_width_m: defaults::HALF_WIDTH_M,
        assembly: Assembly::Reference,
        palm: true,
        sizing: None,
        closing_s: CLOSING_S,
    }, k;
    /// Scene file that this one extends, seen from the directory of this one: whatever is not said here is as it is there, but for
    /// its name and description. A section that says its `type` or `profile` replaces the one there; [lengths] replaces [design].
    extends;
    /// Kind of scene: "finger" is one finger of two phalanges and one motor; "bodies", of which all keys are others, are
    /// discs and a half plane.
    kind;
    /// Gravity as x along and y out of the palm; the gripper hangs upside down by default.
    gravity;
    /// Half width w of every link; a phalanx is a capsule of this radius.
    "half_width": Length = Some(&mut k.half_width_m), allowed(POSITIVE);
    /// Way the five-bar is put together: the mode of the straight configuration, or its mirror image.
    "assembly": Choice<Assembly> = Some(&mut k.assembly);
    /// Whether the palm, the half plane y ≤ 0, is there.
    "palm": Flag = Some(&mut k.palm);
    /// Sizes motor and spring to the finger instead of [motor] torque and [spring] torque (or the stiffness of a torsional
    /// spring with a preload): the spring holds the finger straight on a test trajectory up to the object; the motor has the
    /// RMS torque of this "rigid" phase, or of the "whole" trajectory.
    "sizing": Choice<Rule> = k.sizing.as_mut(), put(|k, rule| k.sizing = Some(rule)), follows();
    /// Length of the test trajectory that `sizing` sizes for.
    "closing_time": Time = Some(&mut k.closing_s), allowed(POSITIVE);
}

/// Before the sections of a scene of discs.
#[derive(Clone, Debug)]
pub struct BodiesKeys {
    pub heading: Heading,
}

/// None.
pub const BODIES_GRAVITY_M_S2: [f64; 2] = [0.0, 0.0];

headed! {
    /// A scene of kind "bodies": discs that are fixed, driven or free, and a half plane, to see the contact laws by
    /// themselves. A scene says only what differs from the defaults. Quantities are texts with a unit: "15 mm", "0.3 m/s".
    BodiesKeys = Self { heading: Heading::of(SceneKind::Bodies, BODIES_GRAVITY_M_S2) }, k;
    /// Scene file that this one extends, seen from the directory of this one: whatever is not said here is as it is there, but for
    /// its name and description.
    extends;
    /// Kind of scene: "bodies" are discs and a half plane. Required.
    kind, follows();
    /// Gravity as x and y; acts on free discs. There is none by default.
    gravity;
}

/// Before the sections of a gripper; not a number what is not given.
#[derive(Clone, Debug)]
pub struct GripperKeys {
    pub heading: Heading,
    pub palm: bool,
    pub palm_width_m: f64,
    pub positioning_error_m: f64,
}

headed! {
    /// A scene of kind "gripper": two fingers close on an object that may move, before a palm and perhaps a table. A scene says only what
    /// differs from the defaults. Quantities are texts with a unit: "15 mm", "120 deg", "480 N*mm".
    GripperKeys = Self {
        heading: Heading::of(SceneKind::Gripper, defaults::GRAVITY_M_S2),
        palm: true,
        palm_width_m: GIVEN,
        positioning_error_m: GIVEN,
    }, k;
    /// Scene file that this one extends, seen from the directory of this one: whatever is not said here is as it is there, but for
    /// its name and description. A section that says its `type` or `profile` replaces the one there; [lengths] replaces [design].
    extends;
    /// Kind of scene: "gripper" are two fingers and what they grasp. Required.
    kind, follows();
    /// Gravity as x along and y out of the palm; the gripper hangs upside down by default.
    gravity;
    /// Whether the palm, the half plane y ≤ 0, is there; only the object meets it.
    "palm": Flag = Some(&mut k.palm);
    /// Distance between the ground joints of both fingers. Default: twice the base of [design]; required with [lengths].
    "palm_width": Length = Some(&mut k.palm_width_m), allowed(POSITIVE);
    /// Largest positioning error that starts and `sizing` are made for: both fingers start where the one that is nearer to the object
    /// would, at either end of the error, and have the larger motor and spring of both ends (of one, where the other is out of a finger's reach). Default: that of the object's offset.
    "positioning_error": Length = Some(&mut k.positioning_error_m);
}
