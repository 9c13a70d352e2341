//! The list of all sections, the source of the JSON Schemas and thereby of the detection of unknown keys and the
//! suggestions.

use serde_json::{Value, json};

use super::keywords::{ANY, FINGERS, NO_FINGER, SceneKind, TWO_FINGERS};
use super::table::SettingsSection;
use super::table::bounds::Bounds;
use super::table::criteria::Thresholds;
use super::table::differential::DifferentialSettings;
use super::table::disc::DiscSettings;
use super::table::drive::{MotorSettings, ShaftSettings, SpringSettings};
use super::table::finger::{BodySettings, FingerSettings, InitialSettings, LengthSettings, MaterialSettings};
use super::table::input::schema;
use super::table::law::{ContactSettings, LimitSettings};
use super::table::motion::{MoveSettings, PathSettings, VibrationSettings};
use super::table::object::ObjectSettings;
use super::table::plane::{HalfPlaneSettings, TableSettings};
use super::table::scene::SceneSettings;
use super::{Engine, Integrator, LogRates};
use crate::gripper::Design;
use crate::shape::Shape;

/// A section or some of its keys: name (empty for the top level), kinds of scene that have it, and schema.
type SectionEntry = (&'static str, &'static [SceneKind], fn(SceneKind) -> Value);

const LIST: &[SectionEntry] = &[
    ("", ANY, schema::<SceneSettings>),
    ("", FINGERS, schema::<FingerSettings>),
    ("design", FINGERS, schema::<Design>),
    ("lengths", FINGERS, schema::<LengthSettings>),
    ("material", FINGERS, schema::<MaterialSettings>),
    ("bodies", FINGERS, schema::<BodySettings>),
    ("object", FINGERS, schema::<ObjectSettings>),
    ("object", FINGERS, schema::<Shape>),
    ("discs", NO_FINGER, discs),
    ("half_plane", NO_FINGER, schema::<HalfPlaneSettings>),
    ("table", TWO_FINGERS, schema::<TableSettings>),
    ("differential", TWO_FINGERS, schema::<DifferentialSettings>),
    ("motor", FINGERS, schema::<MotorSettings>),
    ("motor", TWO_FINGERS, schema::<ShaftSettings>),
    ("spring", FINGERS, schema::<SpringSettings>),
    ("limit", FINGERS, schema::<LimitSettings>),
    ("contact", ANY, schema::<ContactSettings>),
    ("initial", FINGERS, schema::<InitialSettings>),
    ("moves", TWO_FINGERS, named_sections::<MoveSettings>),
    ("vibrations", TWO_FINGERS, named_sections::<VibrationSettings>),
    ("path", TWO_FINGERS, schema::<PathSettings>),
    ("integrator", ANY, schema::<Integrator>),
    ("engine", ANY, schema::<Engine>),
    ("validate", ANY, schema::<Bounds>),
    ("criteria", TWO_FINGERS, schema::<Thresholds>),
    ("log", ANY, schema::<LogRates>),
];

/// Keys and sections of a finger; in a gripper they apply to both fingers, or to one within `[right]` and `[left]`.
pub const FINGER_SECTIONS: [&str; 13] = [
    "half_width",
    "assembly",
    "sizing",
    "closing_time",
    "design",
    "lengths",
    "material",
    "bodies",
    "spring",
    "limit",
    "initial",
    "motor",
    "contact",
];

/// Returns the JSON Schema of a kind of scene without the sections of single fingers.
pub fn section_schemas(kind: SceneKind) -> Value {
    let mut combined = json!({});
    for (name, _, schema) in LIST.iter().filter(|(_, kinds, _)| kinds.contains(&kind)) {
        let section = if name.is_empty() { &mut combined } else { &mut combined["properties"][name] };
        add_section(section, schema(kind));
    }
    combined
}

/// Inserts a section, or adds keys to it.
fn add_section(section: &mut Value, mut added: Value) {
    let keys = added.get_mut("properties").map(Value::take);
    match (section.get_mut("properties"), keys) {
        (Some(Value::Object(known)), Some(Value::Object(more))) => known.extend(more),
        (_, keys) => {
            *section = added;
            keys.into_iter().for_each(|keys| section["properties"] = keys);
        }
    }
}

/// Returns the schema of a table of sections with names chosen by the user.
fn named_sections<T: SettingsSection>(kind: SceneKind) -> Value {
    json!({
        "description": format!("One section per name, chosen freely. {}", T::doc(kind)),
        "type": "object",
        "propertyNames": { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" },
        "additionalProperties": schema::<T>(kind),
    })
}

fn discs(kind: SceneKind) -> Value {
    let mut disc = schema::<DiscSettings>(kind);
    add_section(&mut disc, schema::<Shape>(kind));
    json!({
        "description": "Discs, one section per name, chosen freely: [discs.hammer]. At least one disc must move.",
        "type": "object",
        "minProperties": 1,
        "propertyNames": { "pattern": "^[A-Za-z][A-Za-z0-9_]*$", "not": { "const": "plane" } },
        "additionalProperties": disc,
    })
}
