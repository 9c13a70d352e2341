//! Which sections scenes have: one list, from which come JSON Schemas, unknown keys and what is suggested in their place.

use serde_json::{Value, json};

use super::table::Table;
use super::table::bounds::Bounds;
use super::table::criteria::Thresholds;
use super::table::differential::Seesaw;
use super::table::disc::DiscKeys;
use super::table::drive::{Motor, Shaft, Springs};
use super::table::finger::{Bodies, LengthKeys, Links, Material, Start};
use super::table::keys::schema;
use super::table::law::{Contact, Limit};
use super::table::motion::{MoveKeys, PathKeys, VibrationKeys};
use super::table::object::Object;
use super::table::plane::{Ground, Support};
use super::table::top::Top;
use super::words::{ANY, FINGERS, NO_FINGER, SceneKind, TWO_FINGERS};
use super::{Engine, Integrator, LogRates};
use crate::gripper::Design;
use crate::shape::Shape;

/// A section, or some of its keys: its name (none before all sections), in which kinds of scene it is, and what is in it.
type Listed = (&'static str, &'static [SceneKind], fn(SceneKind) -> Value);

const LIST: &[Listed] = &[
    ("", ANY, schema::<Top>),
    ("", FINGERS, schema::<Links>),
    ("design", FINGERS, schema::<Design>),
    ("lengths", FINGERS, schema::<LengthKeys>),
    ("material", FINGERS, schema::<Material>),
    ("bodies", FINGERS, schema::<Bodies>),
    ("object", FINGERS, schema::<Object>),
    ("object", FINGERS, schema::<Shape>),
    ("discs", NO_FINGER, discs),
    ("half_plane", NO_FINGER, schema::<Ground>),
    ("table", TWO_FINGERS, schema::<Support>),
    ("differential", TWO_FINGERS, schema::<Seesaw>),
    ("motor", FINGERS, schema::<Motor>),
    ("motor", TWO_FINGERS, schema::<Shaft>),
    ("spring", FINGERS, schema::<Springs>),
    ("limit", FINGERS, schema::<Limit>),
    ("contact", ANY, schema::<Contact>),
    ("initial", FINGERS, schema::<Start>),
    ("moves", TWO_FINGERS, named::<MoveKeys>),
    ("vibrations", TWO_FINGERS, named::<VibrationKeys>),
    ("path", TWO_FINGERS, schema::<PathKeys>),
    ("integrator", ANY, schema::<Integrator>),
    ("engine", ANY, schema::<Engine>),
    ("validate", ANY, schema::<Bounds>),
    ("criteria", TWO_FINGERS, schema::<Thresholds>),
    ("log", ANY, schema::<LogRates>),
];

/// Keys and sections of a finger: of two, those of both, and of either.
pub const OF_FINGER: [&str; 13] = [
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

/// JSON Schema of all that the scenes of a kind say of no single finger.
pub fn listed(kind: SceneKind) -> Value {
    let mut whole = json!({});
    for (name, _, schema) in LIST.iter().filter(|(_, kinds, _)| kinds.contains(&kind)) {
        let section = if name.is_empty() { &mut whole } else { &mut whole["properties"][name] };
        put(section, schema(kind));
    }
    whole
}

/// A section, or more keys of it.
fn put(section: &mut Value, mut made: Value) {
    let keys = made.get_mut("properties").map(Value::take);
    match (section.get_mut("properties"), keys) {
        (Some(Value::Object(known)), Some(Value::Object(more))) => known.extend(more),
        (_, keys) => {
            *section = made;
            keys.into_iter().for_each(|keys| section["properties"] = keys);
        }
    }
}

/// Sections of one kind, each under a name of its own.
fn named<T: Table>(kind: SceneKind) -> Value {
    json!({
        "description": format!("Each under a name of its own. {}", T::doc(kind)),
        "type": "object",
        "propertyNames": { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" },
        "additionalProperties": schema::<T>(kind),
    })
}

fn discs(kind: SceneKind) -> Value {
    let mut disc = schema::<DiscKeys>(kind);
    put(&mut disc, schema::<Shape>(kind));
    json!({
        "description": "Discs, each under a name of its own: [discs.hammer]. At least one must move.",
        "type": "object",
        "minProperties": 1,
        "propertyNames": { "pattern": "^[A-Za-z][A-Za-z0-9_]*$", "not": { "const": "plane" } },
        "additionalProperties": disc,
    })
}
