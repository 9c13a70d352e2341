//! The file of a scene of discs as it is written; see [`raw`](super::raw) for what both kinds of scene share.

use std::borrow::Cow;
use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use toml::Spanned;

use super::entry::{Entry, Section};
use super::kinds::{Acceleration, AngularRate, Choice, Flag, Inertia, Length, Mass, Pair, Speed, Text, Time};
use super::table::keys::Keys;
use super::table::law::BodiesContact;
use super::words::{Motion, SceneKind};
use super::{BodiesBounds, Engine, HalfPlane, Integrator, LogRates};

/// A scene of kind "bodies": discs that are fixed, driven or free, and a half plane, to see the contact laws by
/// themselves. A scene says only what differs from the defaults. Quantities are texts with a unit: "15 mm", "0.3 m/s".
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(title = "scene of discs")]
pub struct RawBodiesScene {
    /// Scene file that this one extends, seen from the directory of this one: whatever is not said here is as it is there, but for
    /// its name and description.
    pub extends: Entry<Text>,
    /// Name in reports and logs. Default: the file's name without its extension.
    pub name: Entry<Text>,
    /// What the scene is for; not used by the simulation.
    pub description: Entry<Text>,
    /// Kind of scene: "bodies" are discs and a half plane. Required.
    pub kind: Entry<Choice<SceneKind>>,
    /// Simulated time.
    #[schemars(extend("default" = "20 ms"))]
    pub duration: Entry<Time>,
    /// Gravity as x and y; acts on free discs. There is none by default.
    #[schemars(extend("default" = ["0 m/s^2", "0 m/s^2"]))]
    pub gravity: Entry<Pair<Acceleration>>,
    pub discs: Section<RawDiscs>,
    pub half_plane: Section<Keys<HalfPlane>>,
    pub contact: Section<Keys<BodiesContact>>,
    pub integrator: Section<Keys<Integrator>>,
    pub engine: Section<Keys<Engine>>,
    pub validate: Section<Keys<BodiesBounds>>,
    pub log: Section<Keys<LogRates>>,
}

/// Discs by their names.
#[derive(Debug, Default, Deserialize)]
#[serde(transparent)]
pub struct RawDiscs(pub BTreeMap<Spanned<String>, Section<RawDisc>>);

impl JsonSchema for RawDiscs {
    fn schema_name() -> Cow<'static, str> {
        "RawDiscs".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Discs, each under a name of its own: [discs.hammer]. At least one must move.",
            "type": "object",
            "minProperties": 1,
            "propertyNames": { "pattern": "^[A-Za-z][A-Za-z0-9_]*$", "not": { "const": "plane" } },
            "additionalProperties": RawDisc::json_schema(generator),
        })
    }
}

/// A disc.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawDisc {
    /// Required.
    pub radius: Entry<Length>,
    /// Where its centre starts. Required.
    pub centre: Entry<Pair<Length>>,
    /// What moves it: "free": gravity and contact; "driven": `velocity`, `acceleration` and `spin`, whatever it meets;
    /// "fixed": nothing.
    #[schemars(extend("default" = "free"))]
    pub motion: Entry<Choice<Motion>>,
    /// Velocity of the centre at the start (motion = "free" or "driven").
    #[schemars(extend("default" = ["0 m/s", "0 m/s"]))]
    pub velocity: Entry<Pair<Speed>>,
    /// Constant acceleration of the centre (motion = "driven").
    #[schemars(extend("default" = ["0 m/s^2", "0 m/s^2"]))]
    pub acceleration: Entry<Pair<Acceleration>>,
    /// Angular rate at the start, counter-clockwise (motion = "free" or "driven").
    #[schemars(extend("default" = "0 rad/s"))]
    pub spin: Entry<AngularRate>,
    /// Required with, and only with, motion = "free".
    pub mass: Entry<Mass>,
    /// Moment of inertia about the centre (motion = "free"). Default: of a homogeneous disc, mass × radius² / 2.
    pub inertia: Entry<Inertia>,
    /// Whether contact can turn it (motion = "free").
    #[schemars(extend("default" = true))]
    pub rotates: Entry<Flag>,
}
