//! The file of a scene of a gripper as it is written; see [`raw`](super::raw) for what it shares with that of a finger.
//!
//! The sections of a finger are those of both; `[right]` and `[left]` have the same ones for that finger alone, over the common ones.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer};

use super::entry::Section;
use super::over::{EITHER, KINDS};
use super::raw::RawScene;
use super::sections::sections;
use super::table::bounds::GripperBounds;
use super::table::drive::BoughtMotor;
use super::table::gripper::{Grasped, Seesaw, Support};
use super::table::keys::Keys;
use super::table::law::GripperContact;
use super::table::motion::{MoveKeys, PathKeys, VibrationKeys};
use super::table::top::GripperKeys;
use super::table::{self, Table};
use super::{Engine, Integrator, LogRates, Side};

/// Keys and sections that a gripper shares with the scene of a finger.
pub const OF_FINGER: [&str; 11] = [
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
];

/// What a finger of a gripper has as well, though with keys of its own.
pub const OF_SIDE: [&str; 2] = ["motor", "contact"];

sections! {
    "scene of a gripper", RawGripper: GripperKeys {
        object: Keys<Grasped>,
        table: Keys<Support>,
        differential: Keys<Seesaw>,
        moves: Named<MoveKeys>,
        vibrations: Named<VibrationKeys>,
        path: Keys<PathKeys>,
        motor: Keys<BoughtMotor>,
        contact: Keys<GripperContact>,
        integrator: Keys<Integrator>,
        engine: Keys<Engine>,
        validate: Keys<GripperBounds>,
        log: Keys<LogRates>,
    }
}

/// Sections of one kind, each under a name of its own.
#[derive(Debug, Deserialize)]
#[serde(transparent, bound = "")]
pub struct Named<T>(pub BTreeMap<Spanned<String>, Section<Keys<T>>>);

impl<T> Default for Named<T> {
    fn default() -> Self {
        Named(BTreeMap::new())
    }
}

impl<T: Table> JsonSchema for Named<T> {
    fn schema_name() -> Cow<'static, str> {
        format!("Named{}", std::any::type_name::<T>()).into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": format!("Each under a name of its own. {}", T::DOC.trim_start()),
            "type": "object",
            "propertyNames": { "pattern": "^[A-Za-z][A-Za-z0-9_]*$" },
            "additionalProperties": table::keys::schema::<T>().to_value(),
        })
    }

    fn inline_schema() -> bool {
        true
    }
}

/// What a file says of one finger, as the scene of a finger would.
#[derive(Debug)]
pub struct RawFinger {
    pub raw: RawScene,
    /// Where its own section gives a motor.
    pub own_motor: Option<Range<usize>>,
}

/// Both fingers of a document without unknown keys; what is said of them is taken out.
///
/// # Errors
/// That of the deserialisation.
pub fn take_fingers(document: &mut DeTable<'_>) -> Result<[RawFinger; 2], toml::de::Error> {
    let mut common = DeTable::new();
    for (key, value) in document.iter() {
        let name = key.get_ref().as_ref();
        if OF_FINGER.contains(&name) || OF_SIDE.contains(&name) {
            common.insert(key.clone(), value.clone());
        }
    }
    OF_FINGER.into_iter().for_each(|key| _ = document.remove(key));
    let [right, left] = Side::BOTH.map(|side| {
        let own = match document.remove(side.word()).map(Spanned::into_inner) {
            Some(DeValue::Table(table)) => table,
            _ => DeTable::new(),
        };
        let own_motor = own.get("motor").map(Spanned::span);
        let mut whole = common.clone();
        take_over(&mut whole, own);
        let raw = RawScene::deserialize(Deserializer::from(Spanned::new(0..0, whole)))?;
        Ok(RawFinger { raw, own_motor })
    });
    Ok([right?, left?])
}

/// Puts one table over another as a scene that extends one does, and takes out what only one of both can say.
fn take_over<'a>(whole: &mut DeTable<'a>, over: DeTable<'a>) {
    for (mine, other) in EITHER {
        if over.contains_key(mine) && !over.contains_key(other) {
            whole.remove(other);
        }
    }
    merge(whole, over);
}

fn merge<'a>(whole: &mut DeTable<'a>, over: DeTable<'a>) {
    for (key, mut value) in over {
        let before = whole.remove(&key);
        if let (DeValue::Table(more), Some(DeValue::Table(mut inner))) =
            (value.get_mut(), before.map(Spanned::into_inner))
            && !KINDS.iter().any(|kind| more.contains_key(*kind))
        {
            merge(&mut inner, std::mem::take(more));
            *more = inner;
        }
        whole.insert(key, value);
    }
}
