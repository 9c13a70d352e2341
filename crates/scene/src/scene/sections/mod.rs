//! The settings of a scene file: one struct per section, one field per key.
//!
//! The doc comment of a field is its description; its type gives unit, range and keywords. From these structs follow the
//! JSON Schema, the checks of a file, `scene show`, the settings in a log and the tables of the documentation (see
//! [`schema`](mod@super::schema)). A new setting is one field here, and its use where the scene is
//! resolved. An attribute `extend` gives what a type cannot say:
//!
//! | keyword | meaning |
//! |---|---|
//! | `default` | default, as written in a file |
//! | `x-kinds` | the kinds of scene that have the key; without it all |
//! | `x-finger`, `x-bodies`, `x-gripper`, `x-mechanism` | keywords that differ in this kind of scene |
//! | `x-with` | `KEY = VALUE\|VALUE`: the choice with which the key has an effect |
//! | `x-required` | the remedy if the key is missing |
//! | `x-key` | name in a file, if that is not the name of the field without its unit |
//!
//! Each file has the keys of its sections, resolves them (the functions that read a `SectionInput`), and gives the
//! settings of what is resolved, in SI units (the functions with the suffix `_settings`).
//!
//! | file | sections |
//! |---|---|
//! | `finger` | design, lengths, material, bodies |
//! | `start` | initial |
//! | `drive` | motor, spring, differential |
//! | `bodies` | object, discs, half plane, table |
//! | `law` | contact, limit |
//! | `mechanism` | all sections of a mechanism |
//! | `motion` | moves, vibrations, path |
//! | `run` | integrator, engine, validate, criteria, log |

// Names of sections in brackets, such as [motor], are not links.
#![allow(rustdoc::private_intra_doc_links)]
// Descriptions name sections in brackets, as in a file: [design].
#![allow(rustdoc::broken_intra_doc_links)]

pub(crate) mod bodies;
pub(crate) mod drive;
pub(crate) mod finger;
pub(crate) mod law;
pub(crate) mod mechanism;
pub(crate) mod motion;
pub(crate) mod run;
pub(crate) mod start;

use std::borrow::Cow;
use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde_json::Value;

pub use bodies::{DENSITY_KG_M3, DEPTH_M, DiscSettings, HalfPlaneSettings, ObjectSettings, TableSettings, Target};
pub use drive::{DifferentialSettings, MotorSettings, SizingResult, SpringSettings};
pub use finger::{BodiesSettings, DesignSettings, FingerKeys, FingerLengths, LengthSettings, MaterialSettings};
pub use law::{CommonLaw, ContactSettings, LimitSettings};
pub use mechanism::{GraspSettings, MechanismSettings};
pub use motion::{MoveSettings, PathSettings, VibrationSettings};
pub use run::{
    Bounds, ENGINE_MAX_STEP_S, Engine, EngineSettings, Integrator, LogExcess, LogSettings, Method, Preset, Response,
    Stepping, Thresholds,
};
pub use start::InitialSettings;

use super::keywords::SceneKind;
use super::quantity::{Acceleration, Length, Positive, Quantity, Time};
use super::section_input::SectionInput;
use crate::limits::MAX_TABLE_POINTS;

/// Adds settings to other settings of the same section.
pub fn extend(settings: &mut Value, more: Value) {
    if let (Value::Object(settings), Value::Object(mut more)) = (settings, more) {
        settings.append(&mut more);
    }
}

/// Checks the number of points of a table over time.
fn check_point_count(input: &SectionInput<'_>, count: usize) -> Option<()> {
    if count <= MAX_TABLE_POINTS {
        return Some(());
    }
    let message = format!("`{}` has {count} values, but at most {MAX_TABLE_POINTS} are allowed", input.path("times"));
    input.refuse("times", message, "too many", "give fewer points; values between them are interpolated")
}

/// Kinds of scene in `x-kinds`.
const FINGER: &str = "finger";
const GRIPPER: &str = "gripper";
const BODIES: &str = "bodies";
const MECHANISM: &str = "mechanism";
const FINGERS: &str = "finger gripper";
const NO_OR_TWO_FINGERS: &str = "bodies gripper mechanism";
const NO_FINGERS: &str = "bodies mechanism";
const WITH_HANDS: &str = "finger gripper mechanism";

/// A scene of kind "finger": one finger, the object it grasps, and the settings of the simulation. Omitted keys
/// have their defaults. Quantities are strings with a unit: "15 mm", "120 deg", "480 N*mm".
#[derive(JsonSchema)]
#[schemars(
    title = "scene of a finger",
    extend(
        "x-bodies" = {
            "title": "scene of discs",
            "description": "A scene of kind \"bodies\": discs that are fixed, driven or free, and a half plane, to study the \
                contact laws alone. Omitted keys have their defaults. Quantities are strings with a unit: \"15 mm\", \"0.3 m/s\".",
        },
        "x-gripper" = {
            "title": "scene of a gripper",
            "description": "A scene of kind \"gripper\": two fingers that close on an object, which may move, with a palm and an \
                optional table. Omitted keys have their defaults. Quantities are strings with a unit: \"15 mm\", \"120 deg\", \
                \"480 N*mm\".",
        }
    )
)]
pub struct SceneFile {
    #[serde(flatten)]
    pub top: SceneSettings,
    /// Named values, chosen freely: numbers, quantities with units, or expressions. An expression begins with `=` and may
    /// stand in place of any number or quantity of the scene: "= 2 * crank + 5 mm".
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub parameters: BTreeMap<String, ParameterValue>,
    #[serde(flatten)]
    pub finger: FingerSettings,
    /// Discs, one section per name, chosen freely: [discs.hammer]. At least one disc must move.
    #[schemars(extend(
        "x-kinds" = BODIES, "minProperties" = 1,
        "propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$", "not": { "const": "plane" } }
    ))]
    pub discs: BTreeMap<String, DiscSettings>,
    #[schemars(extend("x-kinds" = BODIES))]
    pub half_plane: HalfPlaneSettings,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub object: ObjectSettings,
    #[schemars(extend("x-kinds" = GRIPPER))]
    pub table: TableSettings,
    #[schemars(extend("x-kinds" = GRIPPER))]
    pub differential: DifferentialSettings,
    /// Settings of the right finger that differ from those of both fingers.
    #[schemars(extend("x-kinds" = GRIPPER, "x-overrides" = true))]
    pub right: FingerSettings,
    /// Settings of the left finger that differ from those of both fingers. It is described by its mirror image.
    #[schemars(extend("x-kinds" = GRIPPER, "x-overrides" = true))]
    pub left: FingerSettings,
    /// One section per name, chosen freely. A move of the palm from rest to rest along a polynomial of order 7, with
    /// zero rate, acceleration and jerk at both ends. Overlapping moves add up.
    #[schemars(extend("x-kinds" = GRIPPER, "propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub moves: BTreeMap<String, MoveSettings>,
    /// One section per name, chosen freely. A vibration of the palm, amplitude × sin(2π f (t − start) + phase), with a
    /// ramp over the first periods.
    #[schemars(extend("x-kinds" = GRIPPER, "propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub vibrations: BTreeMap<String, VibrationSettings>,
    #[schemars(extend("x-kinds" = GRIPPER))]
    pub path: PathSettings,
    pub integrator: Integrator,
    pub engine: Engine,
    pub validate: Bounds,
    #[schemars(extend("x-kinds" = GRIPPER))]
    pub criteria: Thresholds,
    pub log: LogSettings,
}

/// A scene of kind "mechanism": any planar linkage of bodies and joints, with springs, actuators and contacts. Omitted keys
/// have their defaults. Quantities are strings with a unit: "15 mm", "120 deg", "0.25 N*m".
#[derive(JsonSchema)]
#[schemars(title = "scene of a mechanism")]
pub struct MechanismFile {
    #[serde(flatten)]
    pub top: SceneSettings,
    /// Named values, chosen freely: numbers, quantities with units, or expressions. An expression begins with `=` and may
    /// stand in place of any number or quantity of the scene: "= 2 * crank + 5 mm".
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub parameters: BTreeMap<String, ParameterValue>,
    #[serde(flatten)]
    pub mechanism: MechanismSettings,
    pub grasp: GraspSettings,
    /// One section per name, chosen freely. A move of a body from rest to rest along a polynomial of order 7, with zero
    /// rate, acceleration and jerk at both ends. Overlapping moves add up.
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub moves: BTreeMap<String, MoveSettings>,
    /// One section per name, chosen freely. A vibration of a body, amplitude × sin(2π f (t − start) + phase), with a ramp over
    /// the first periods.
    #[schemars(extend("propertyNames" = { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" }))]
    pub vibrations: BTreeMap<String, VibrationSettings>,
    pub path: PathSettings,
    pub integrator: Integrator,
    pub engine: Engine,
    pub validate: Bounds,
    pub criteria: Thresholds,
    pub log: LogSettings,
}

/// A number, a quantity of any dimension, or an expression.
pub struct ParameterValue;

impl JsonSchema for ParameterValue {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "ParameterValue".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "x-parameter": true })
    }
}

/// Keys and sections of a finger. In a gripper they apply to both fingers; within `[right]` and `[left]`, to one.
#[derive(JsonSchema)]
pub struct FingerSettings {
    #[serde(flatten)]
    pub keys: FingerKeys,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub design: DesignSettings,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub lengths: LengthSettings,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub material: MaterialSettings,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub bodies: BodiesSettings,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub motor: MotorSettings,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub spring: SpringSettings,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub limit: LimitSettings,
    pub contact: ContactSettings,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub initial: InitialSettings,
}

/// Settings at the top level.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct SceneSettings {
    /// Path of a scene file that this one extends, relative to the directory of this file. Omitted keys are inherited,
    /// except name and description. A section with `type` or `profile` replaces the inherited section; [lengths]
    /// replaces [design].
    #[schemars(extend("minLength" = 1, "x-bodies" = {
        "description": "Scene file that this one extends, relative to its own directory: omitted keys are inherited, except name \
            and description."
    }))]
    pub extends: Option<String>,
    /// Name in reports and logs. Default: the name of the file without its extension.
    #[schemars(extend("minLength" = 1))]
    pub name: Option<String>,
    /// Description of the scene; not used by the simulation.
    #[schemars(extend("minLength" = 1))]
    pub description: Option<String>,
    /// Kind of scene: "finger": one finger with two phalanges and one motor; "gripper": two fingers; "bodies": discs
    /// and a half plane; "mechanism": any planar linkage. Determines the other keys.
    #[schemars(extend(
        "x-finger" = { "default": "finger" },
        "x-bodies" = { "description": "Kind of scene: \"bodies\": discs and a half plane. Required." },
        "x-gripper" = { "description": "Kind of scene: \"gripper\": two fingers and an object. Required." },
        "x-mechanism" = { "description": "Kind of scene: \"mechanism\": any planar linkage. Required." }
    ))]
    pub kind: Option<SceneKind>,
    /// Simulated time.
    #[schemars(extend("default" = "20 ms"))]
    pub duration: Positive<Time>,
    /// Gravity: x is along the palm, y out of it. By default the gripper hangs upside down.
    #[schemars(extend("default" = ["0 m/s^2", "9.81 m/s^2"], "x-bodies" = {
        "description": "Gravity on free discs. Default: none.", "default": ["0 m/s^2", "0 m/s^2"]
    }, "x-mechanism" = {
        "description": "Gravity. Default: none.", "default": ["0 m/s^2", "0 m/s^2"]
    }))]
    pub gravity: [Quantity<Acceleration>; 2],
    /// Whether there is a palm, the half plane y ≤ 0.
    #[schemars(extend("default" = true, "x-kinds" = FINGERS, "x-gripper" = {
        "description": "Whether there is a palm, the half plane y ≤ 0, which only the object can touch."
    }))]
    pub palm: Option<bool>,
    /// Distance between the ground joints of the two fingers. Default: twice the base of [design] or [lengths].
    #[schemars(extend("x-kinds" = GRIPPER))]
    pub palm_width: Option<Positive<Length>>,
    /// Largest positioning error, for the initial configuration and `sizing`. Both fingers start before the earliest
    /// contact at either end of the error, and have the larger torques of motor and spring of the two ends (of one end
    /// if the other one is out of reach). Default: the offset of the object.
    #[schemars(extend("x-kinds" = GRIPPER))]
    pub positioning_error: Option<Quantity<Length>>,
}
