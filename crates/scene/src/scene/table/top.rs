//! What a scene says before its sections.

use super::lines;
use crate::scene::check::POSITIVE;
use crate::scene::defaults;
use crate::scene::kinds::{Acceleration, Choice, Flag, Length, Pair, Text, Time};
use crate::scene::words::{FINGERS, NO_FINGER, ONE_FINGER, SceneKind, TWO_FINGERS};

/// What is said of the whole scene; a text is empty where nothing is said, a number none where it is not given.
#[derive(Clone, Debug)]
pub struct Top {
    pub extends: String,
    pub name: String,
    pub description: String,
    pub kind: SceneKind,
    pub duration_s: f64,
    pub gravity_m_s2: [f64; 2],
    pub palm: bool,
    pub palm_width_m: f64,
    pub positioning_error_m: f64,
}

/// Keys that scenes of every kind have.
pub const HEADING: [&str; 6] = ["extends", "name", "description", "kind", "duration", "gravity"];

/// Not a number where something must be given, or follows from something else.
const GIVEN: f64 = f64::NAN;

impl Top {
    /// None acts on discs by themselves.
    pub const fn usual_gravity_m_s2(kind: SceneKind) -> [f64; 2] {
        match kind {
            SceneKind::Bodies => [0.0, 0.0],
            SceneKind::Finger | SceneKind::Gripper => defaults::GRAVITY_M_S2,
        }
    }
}

lines! {
    /// A scene: one gripper variant, the object it grasps, and how it is simulated. A scene says only what differs from the
    /// defaults. Quantities are texts with a unit: "15 mm", "120 deg", "480 N*mm".
    Top = Self::usual_in(SceneKind::Finger), k, where {
        const DOCS: &'static [(SceneKind, &'static str)] = &[
            (
                SceneKind::Bodies,
                "A scene of kind \"bodies\": discs that are fixed, driven or free, and a half plane, to see the contact laws by \
                 themselves. A scene says only what differs from the defaults. Quantities are texts with a unit: \"15 mm\", \
                 \"0.3 m/s\".",
            ),
            (
                SceneKind::Gripper,
                "A scene of kind \"gripper\": two fingers close on an object that may move, before a palm and perhaps a table. A \
                 scene says only what differs from the defaults. Quantities are texts with a unit: \"15 mm\", \"120 deg\", \
                 \"480 N*mm\".",
            ),
        ];

        fn usual_in(kind: SceneKind) -> Self {
            let [extends, name, description] = [const { String::new() }; 3];
            Self {
                extends,
                name,
                description,
                kind,
                duration_s: defaults::DURATION_S,
                gravity_m_s2: Self::usual_gravity_m_s2(kind),
                palm: true,
                palm_width_m: GIVEN,
                positioning_error_m: GIVEN,
            }
        }
    };
    /// Scene file that this one extends, seen from the directory of this one: whatever is not said here is as it is there, but for
    /// its name and description. A section that says its `type` or `profile` replaces the one there; [lengths] replaces [design].
    "extends": Text = Some(&mut k.extends), of(FINGERS);
    /// Scene file that this one extends, seen from the directory of this one: whatever is not said here is as it is there, but for
    /// its name and description.
    "extends": Text = Some(&mut k.extends), of(NO_FINGER);
    /// Name in reports and logs. Default: the file's name without its extension.
    "name": Text = Some(&mut k.name);
    /// What the scene is for; not used by the simulation.
    "description": Text = Some(&mut k.description);
    /// Kind of scene: "finger" is one finger of two phalanges and one motor; "bodies", of which all keys are others, are
    /// discs and a half plane.
    "kind": Choice<SceneKind> = Some(&mut k.kind), of(ONE_FINGER);
    /// Kind of scene: "bodies" are discs and a half plane. Required.
    "kind": Choice<SceneKind> = Some(&mut k.kind), follows(), of(NO_FINGER);
    /// Kind of scene: "gripper" are two fingers and what they grasp. Required.
    "kind": Choice<SceneKind> = Some(&mut k.kind), follows(), of(TWO_FINGERS);
    /// Simulated time.
    "duration": Time = Some(&mut k.duration_s), allowed(POSITIVE);
    /// Gravity as x along and y out of the palm; the gripper hangs upside down by default.
    "gravity": Pair<Acceleration> = Some(&mut k.gravity_m_s2), of(FINGERS);
    /// Gravity as x and y; acts on free discs. There is none by default.
    "gravity": Pair<Acceleration> = Some(&mut k.gravity_m_s2), of(NO_FINGER);
    /// Whether the palm, the half plane y ≤ 0, is there.
    "palm": Flag = Some(&mut k.palm), of(ONE_FINGER);
    /// Whether the palm, the half plane y ≤ 0, is there; only the object meets it.
    "palm": Flag = Some(&mut k.palm), of(TWO_FINGERS);
    /// Distance between the ground joints of both fingers. Default: twice the base of [design] or [lengths].
    "palm_width": Length = Some(&mut k.palm_width_m), allowed(POSITIVE), of(TWO_FINGERS);
    /// Largest positioning error that starts and `sizing` are made for: both fingers start where the one that is nearer to the object
    /// would, at either end of the error, and have the larger motor and spring of both ends (of one, where the other is out of a finger's reach). Default: that of the object's offset.
    "positioning_error": Length = Some(&mut k.positioning_error_m), of(TWO_FINGERS);
}
