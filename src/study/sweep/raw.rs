//! The study file as it is written. Doc comments become the descriptions of the JSON Schema; defaults stand beside them.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, json_schema};
use serde::Deserialize;
use serde_json::{Value as Json, json};
use toml::Spanned;

use super::axis::Spacing;
use super::sequence::Method;
use crate::scene::Problem;
use crate::scene::any::Any;
use crate::scene::entry::{Entry, Section};
use crate::scene::kinds::{Choice, Count, Flag, Kind, Text, Words, at};
use crate::scene::schema::{schema_of, unwrap_lines};
use crate::scene::words::SceneKind;
use crate::trace::Model;

/// A study: a scene, the fields of it that vary, and what is simulated of all that.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(title = "phalanx study")]
pub struct RawStudy {
    /// Name in reports. Default: the file's name without its extension.
    pub name: Entry<Text>,
    /// What the study is for.
    pub description: Entry<Text>,
    /// The base scene: a file, seen from the directory of this one, or a table [scene] with the keys of a scene. It may lack
    /// what the axes give.
    pub scene: Entry<Text>,
    /// The model that simulates.
    #[schemars(extend("default" = "analytic"))]
    pub model: Entry<Choice<Model>>,
    /// What varies; all combinations are run, the last axis fastest.
    pub axes: Vec<Section<RawAxis>>,
    pub sample: Section<RawSample>,
    pub filter: Section<RawFilter>,
}

/// One axis: values or a range of one field, or rows of values of several fields.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawAxis {
    /// Field of a scene, such as "design.base" or "contact.friction.mu_static".
    pub field: Entry<Text>,
    /// Fields that vary together, by `rows`.
    pub fields: Entry<List>,
    /// Values, as they would stand in the scene.
    pub values: Entry<List>,
    /// Rows of values, one value for each of `fields`.
    pub rows: Entry<List>,
    /// First value of a range.
    pub from: Entry<Anything>,
    /// Last value of a range.
    pub to: Entry<Anything>,
    /// How many values of the range, both ends among them. Left out, the values are those of [sample].
    pub count: Entry<Count>,
    /// How the values of a range lie.
    #[schemars(extend("default" = "linear"))]
    pub spacing: Entry<Choice<Spacing>>,
    /// Whether the values make no new designs: the same designs run again under other conditions.
    #[schemars(extend("default" = false))]
    pub again: Entry<Flag>,
}

/// Points spread over all ranges without `count`, instead of their grid. Every combination of the other axes gets all of
/// them.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawSample {
    /// "halton": low discrepancy, and a longer sample contains the shorter one; "latin-hypercube": every slice of every axis
    /// once; "random": independent points.
    #[schemars(extend("default" = "halton"))]
    pub method: Entry<Choice<Method>>,
    /// How many points. Required.
    pub count: Entry<Count>,
    /// Another seed gives other points.
    #[schemars(extend("default" = 1))]
    pub seed: Entry<Count>,
}

/// What is simulated: designs whose static criteria are as is said here. The others are in the results as "filtered".
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawFilter {
    /// Both contact forces at rest push.
    pub force_positive: Entry<Flag>,
    /// At rest the object is pressed on the palm.
    pub palm_force_positive: Entry<Flag>,
    /// The object cannot be moved between two such fingers and the palm.
    pub form_closed: Entry<Flag>,
}

/// Values of any kind.
#[derive(Debug)]
pub struct List;

impl Kind for List {
    type Value = Vec<Spanned<Any>>;
    const NAME: &'static str = "Values";

    fn read(key: &str, value: &Spanned<Any>) -> Result<Self::Value, Vec<Problem>> {
        let help = "write values between brackets, with commas: [0.0, 0.8]".to_string();
        match value.get_ref() {
            Any::List(items) if !items.is_empty() => Ok(items.clone()),
            Any::List(_) => Err(vec![at(value, format!("`{key}` is empty"), "nothing to run", help)]),
            other => {
                let message = format!("`{key}` is {}, but must be a list", other.name());
                Err(vec![at(value, message, "a list in brackets", help)])
            }
        }
    }

    fn schema() -> Schema {
        json_schema!({ "type": "array", "minItems": 1 })
    }
}

/// A value of any kind: its field says which.
#[derive(Debug)]
pub struct Anything;

impl Kind for Anything {
    type Value = Spanned<Any>;
    const NAME: &'static str = "Value";

    fn read(_: &str, value: &Spanned<Any>) -> Result<Self::Value, Vec<Problem>> {
        Ok(value.clone())
    }

    fn schema() -> Schema {
        json_schema!({ "type": ["string", "number"] })
    }
}

impl Words for Spacing {
    const WORDS: &'static [(&'static str, Self)] = &[("linear", Spacing::Linear), ("log", Spacing::Log)];
}

impl Words for Method {
    const WORDS: &'static [(&'static str, Self)] =
        &[("halton", Method::Halton), ("latin-hypercube", Method::LatinHypercube), ("random", Method::Random)];
}

/// JSON Schema of study files, as text.
pub fn schema() -> String {
    schema_text(schema_json())
}

/// The schema of files with a base scene and [set], whose keys are those of a scene of either kind.
pub(in crate::study) fn schema_text(mut schema: Json) -> String {
    let [scene, set] = ["scene", "set"].map(|key| schema["properties"][key]["description"].take());
    let [finger, gripper] = swept();
    let file = json!({ "type": "string" });
    schema["properties"]["scene"] = json!({ "description": scene, "anyOf": [file, finger, gripper] });
    schema["properties"]["set"] = json!({ "description": set, "anyOf": swept() });
    format!("{schema:#}\n")
}

/// The kinds of scenes that a study takes.
fn swept() -> [Json; 2] {
    [SceneKind::Finger, SceneKind::Gripper].map(|kind| {
        let mut schema = schema_of(kind).clone();
        schema.as_object_mut().map(|map| map.remove("$schema"));
        schema
    })
}

/// The schema by which unknown keys are found. A [scene] or [set] that is a table is judged as a scene, not by this.
pub(super) fn schema_json() -> Json {
    schema_of_study::<RawStudy>("study")
}

/// The same of any file with a base scene and [set], by what it is.
pub(in crate::study) fn schema_of_study<R: JsonSchema>(whole: &str) -> Json {
    let settings = SchemaSettings::draft07().for_deserialize().with(|s| s.inline_subschemas = true);
    let mut schema = settings.into_generator().into_root_schema_for::<R>().to_value();
    unwrap_lines(&mut schema);
    let [mut set, _] = swept();
    set["description"] = format!("Fields of the base scene that the whole {whole} replaces.").into();
    schema["properties"]["set"] = set;
    schema
}
