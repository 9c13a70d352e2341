//! The file of a scene of discs as it is written; see [`raw`](super::raw) for what both kinds of scene share.

use std::borrow::Cow;
use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use toml::Spanned;

use super::entry::Section;
use super::sections::sections;
use super::table::bounds::DiscBounds;
use super::table::disc::DiscKeys;
use super::table::half_plane::Ground;
use super::table::keys::{self, Keys};
use super::table::law::BodiesContact;
use super::table::top::BodiesKeys;
use super::{Engine, Integrator, LogRates};

sections! {
    "scene of discs", RawBodiesScene: BodiesKeys {
        discs: RawDiscs,
        half_plane: Keys<Ground>,
        contact: Keys<BodiesContact>,
        integrator: Keys<Integrator>,
        engine: Keys<Engine>,
        validate: Keys<DiscBounds>,
        log: Keys<LogRates>,
    }
}

/// Discs by their names.
#[derive(Debug, Default, Deserialize)]
#[serde(transparent)]
pub struct RawDiscs(pub BTreeMap<Spanned<String>, Section<Keys<DiscKeys>>>);

impl JsonSchema for RawDiscs {
    fn schema_name() -> Cow<'static, str> {
        "RawDiscs".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Discs, each under a name of its own: [discs.hammer]. At least one must move.",
            "type": "object",
            "minProperties": 1,
            "propertyNames": { "pattern": "^[A-Za-z][A-Za-z0-9_]*$", "not": { "const": "plane" } },
            "additionalProperties": keys::schema::<DiscKeys>().to_value(),
        })
    }
}
