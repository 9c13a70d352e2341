//! Settings at the top level of a scene.

use super::settings;
use crate::scene::check::POSITIVE;
use crate::scene::defaults;
use crate::scene::keywords::{FINGERS, NO_FINGER, ONE_FINGER, SceneKind, TWO_FINGERS};
use crate::scene::value_kinds::{Acceleration, Choice, Flag, Length, Pair, Text, Time};

/// Settings at the top level. Missing texts are empty, and missing numbers are NaN.
#[derive(Clone, Debug)]
pub struct SceneSettings {
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

/// Keys of all kinds of scene.
pub const HEADING: [&str; 6] = ["extends", "name", "description", "kind", "duration", "gravity"];

/// A value that is derived from other settings.
const UNSET: f64 = f64::NAN;

impl SceneSettings {
    /// Default gravity: none in scenes of discs.
    pub const fn default_gravity_m_s2(kind: SceneKind) -> [f64; 2] {
        match kind {
            SceneKind::Bodies => [0.0, 0.0],
            SceneKind::Finger | SceneKind::Gripper => defaults::GRAVITY_M_S2,
        }
    }
}

settings! {
    /// A scene of kind "finger": one finger, the object it grasps, and the settings of the simulation. Omitted keys
    /// have their defaults. Quantities are strings with a unit: "15 mm", "120 deg", "480 N*mm".
    SceneSettings = Self::defaults_for(SceneKind::Finger), k, where {
        const DOC_OVERRIDES: &'static [(SceneKind, &'static str)] = &[
            (
                SceneKind::Bodies,
                "A scene of kind \"bodies\": discs that are fixed, driven or free, and a half plane, to study the contact laws \
                 alone. Omitted keys have their defaults. Quantities are strings with a unit: \"15 mm\", \"0.3 m/s\".",
            ),
            (
                SceneKind::Gripper,
                "A scene of kind \"gripper\": two fingers that close on an object, which may move, with a palm and an optional table. \
                 Omitted keys have their defaults. Quantities are strings with a unit: \"15 mm\", \"120 deg\", \"480 N*mm\".",
            ),
        ];

        fn defaults_for(kind: SceneKind) -> Self {
            let [extends, name, description] = [const { String::new() }; 3];
            Self {
                extends,
                name,
                description,
                kind,
                duration_s: defaults::DURATION_S,
                gravity_m_s2: Self::default_gravity_m_s2(kind),
                palm: true,
                palm_width_m: UNSET,
                positioning_error_m: UNSET,
            }
        }
    };
    /// Scene file that this one extends, relative to its own directory: omitted keys are inherited, except
    /// name and description. A section with `type` or `profile` replaces the inherited section; [lengths] replaces
    /// [design].
    "extends": Text = Some(&mut k.extends), only_in(FINGERS);
    /// Scene file that this one extends, relative to its own directory: omitted keys are inherited, except
    /// name and description.
    "extends": Text = Some(&mut k.extends), only_in(NO_FINGER);
    /// Name in reports and logs. Default: the name of the file without its extension.
    "name": Text = Some(&mut k.name);
    /// Description of the scene; not used by the simulation.
    "description": Text = Some(&mut k.description);
    /// Kind of scene: "finger": one finger with two phalanges and one motor; "gripper": two fingers; "bodies": discs
    /// and a half plane. Determines the other keys.
    "kind": Choice<SceneKind> = Some(&mut k.kind), only_in(ONE_FINGER);
    /// Kind of scene: "bodies": discs and a half plane. Required.
    "kind": Choice<SceneKind> = Some(&mut k.kind), derived(), only_in(NO_FINGER);
    /// Kind of scene: "gripper": two fingers and an object. Required.
    "kind": Choice<SceneKind> = Some(&mut k.kind), derived(), only_in(TWO_FINGERS);
    /// Simulated time.
    "duration": Time = Some(&mut k.duration_s), allowed(POSITIVE);
    /// Gravity: x along the palm, y out of it; by default the gripper hangs upside down.
    "gravity": Pair<Acceleration> = Some(&mut k.gravity_m_s2), only_in(FINGERS);
    /// Gravity on free discs. Default: none.
    "gravity": Pair<Acceleration> = Some(&mut k.gravity_m_s2), only_in(NO_FINGER);
    /// Whether there is a palm, the half plane y ≤ 0.
    "palm": Flag = Some(&mut k.palm), only_in(ONE_FINGER);
    /// Whether there is a palm, the half plane y ≤ 0, which only the object can touch.
    "palm": Flag = Some(&mut k.palm), only_in(TWO_FINGERS);
    /// Distance between the ground joints of both fingers. Default: twice the base of [design] or [lengths].
    "palm_width": Length = Some(&mut k.palm_width_m), allowed(POSITIVE), only_in(TWO_FINGERS);
    /// Largest positioning error for the initial configuration and `sizing`: both fingers start before the earliest
    /// contact over both ends of the error, and have the larger torques of motor and spring of both ends (of one end,
    /// if the other one is out of reach). Default: the offset of the object.
    "positioning_error": Length = Some(&mut k.positioning_error_m), only_in(TWO_FINGERS);
}
