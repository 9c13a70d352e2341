//! Structure of the study file. Doc comments become the descriptions of the JSON Schema; defaults are in the
//! attributes.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, json_schema};
use serde::Deserialize;
use serde_json::{Value as Json, json};
use toml::Spanned;

use super::axis::Spacing;
use super::sequence::Method;
use crate::scene::Problem;
use crate::scene::entry::{Entry, Section};
use crate::scene::keywords::SceneKind;
use crate::scene::schema::{schema_for, unwrap_lines};
use crate::scene::toml_value::TomlValue;
use crate::scene::value_kinds::{Choice, Count, Flag, InputKind, Keyword, Text, problem_at};
use crate::trace::Model;

/// A study: a base scene, the fields that vary, and the runs to simulate.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(title = "phalanx study")]
pub struct RawStudy {
    /// Name in reports. Default: the file name without its extension.
    pub name: Entry<Text>,
    /// Purpose of the study.
    pub description: Entry<Text>,
    /// The base scene: a path relative to the directory of this file, or a table [scene] with the keys of a scene. It
    /// may lack the fields of the axes.
    pub scene: Entry<Text>,
    /// Simulation model.
    #[schemars(extend("default" = "analytic"))]
    pub model: Entry<Choice<Model>>,
    /// Fields that vary; all combinations are run, the last axis fastest.
    pub axes: Vec<Section<RawAxis>>,
    pub sample: Section<RawSample>,
    pub filter: Section<RawFilter>,
}

/// One axis: values or a range of one field, or rows of values of several fields.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawAxis {
    /// Scene field, such as "design.base" or "contact.friction.mu_static".
    pub field: Entry<Text>,
    /// Fields that vary together; requires `rows`.
    pub fields: Entry<ValueList>,
    /// Values, written as in a scene.
    pub values: Entry<ValueList>,
    /// Rows of values, one value for each of `fields`.
    pub rows: Entry<ValueList>,
    /// First value of a range.
    pub from: Entry<AnyValue>,
    /// Last value of a range.
    pub to: Entry<AnyValue>,
    /// Number of values of the range including both ends. Without it, [sample] determines the values.
    pub count: Entry<Count>,
    /// Spacing of the values of a range.
    #[schemars(extend("default" = "linear"))]
    pub spacing: Entry<Choice<Spacing>>,
    /// Whether the axis repeats the same designs under other conditions instead of making new designs.
    #[schemars(extend("default" = false))]
    pub again: Entry<Flag>,
}

/// Sample points of all ranges without `count`. Every combination of the other axes is run with all points.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawSample {
    /// "halton": low discrepancy, and a longer sample contains the shorter one; "latin-hypercube": one point in
    /// every slice of every axis; "random": independent points.
    #[schemars(extend("default" = "halton"))]
    pub method: Entry<Choice<Method>>,
    /// Number of points. Required.
    pub count: Entry<Count>,
    /// Seed of the points.
    #[schemars(extend("default" = 1))]
    pub seed: Entry<Count>,
}

/// Static criteria of the designs to simulate. Other designs are in the results as "filtered".
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawFilter {
    /// Whether both contact forces at rest are compressive.
    pub force_positive: Entry<Flag>,
    /// Whether the palm force at rest is compressive.
    pub palm_force_positive: Entry<Flag>,
    /// Whether the grasp by two such fingers and the palm is form-closed.
    pub form_closed: Entry<Flag>,
}

/// List of values of any type.
#[derive(Debug)]
pub struct ValueList;

impl InputKind for ValueList {
    type Value = Vec<Spanned<TomlValue>>;
    const NAME: &'static str = "Values";

    fn read(key: &str, value: &Spanned<TomlValue>) -> Result<Self::Value, Vec<Problem>> {
        let help = "write comma-separated values in brackets: [0.0, 0.8]".to_string();
        match value.get_ref() {
            TomlValue::List(items) if !items.is_empty() => Ok(items.clone()),
            TomlValue::List(_) => Err(vec![problem_at(value, format!("`{key}` is empty"), "nothing to run", help)]),
            other => {
                let message = format!("`{key}` is {}, but must be a list", other.name());
                Err(vec![problem_at(value, message, "a list in brackets", help)])
            }
        }
    }

    fn schema() -> Schema {
        json_schema!({ "type": "array", "minItems": 1 })
    }
}

/// Value of any type, checked against its field later.
#[derive(Debug)]
pub struct AnyValue;

impl InputKind for AnyValue {
    type Value = Spanned<TomlValue>;
    const NAME: &'static str = "Value";

    fn read(_: &str, value: &Spanned<TomlValue>) -> Result<Self::Value, Vec<Problem>> {
        Ok(value.clone())
    }

    fn schema() -> Schema {
        json_schema!({ "type": ["string", "number"] })
    }
}

impl Keyword for Spacing {
    const KEYWORDS: &'static [(&'static str, Self)] = &[("linear", Spacing::Linear), ("log", Spacing::Log)];
}

impl Keyword for Method {
    const KEYWORDS: &'static [(&'static str, Self)] =
        &[("halton", Method::Halton), ("latin-hypercube", Method::LatinHypercube), ("random", Method::Random)];
}

/// JSON Schema of study files.
pub fn schema() -> String {
    scene_study_schema_text(schema_json())
}

/// Text of the schema of a file with a base scene and [set]; both accept the keys of a finger or a gripper.
pub(in crate::study) fn scene_study_schema_text(mut schema: Json) -> String {
    let [scene, set] = ["scene", "set"].map(|key| schema["properties"][key]["description"].take());
    let [finger, gripper] = scene_schemas();
    let file = json!({ "type": "string" });
    schema["properties"]["scene"] = json!({ "description": scene, "anyOf": [file, finger, gripper] });
    schema["properties"]["set"] = json!({ "description": set, "anyOf": scene_schemas() });
    format!("{schema:#}\n")
}

/// Schemas of the scenes that a study accepts.
fn scene_schemas() -> [Json; 2] {
    [SceneKind::Finger, SceneKind::Gripper].map(|kind| {
        let mut schema = schema_for(kind).clone();
        schema.as_object_mut().map(|map| map.remove("$schema"));
        schema
    })
}

/// Schema that detects unknown keys. Tables [scene] and [set] are checked as scenes instead.
pub(super) fn schema_json() -> Json {
    study_schema::<RawStudy>("study")
}

/// Schema of a file with a base scene and [set]. `name` is the name of the file type in descriptions.
pub(in crate::study) fn study_schema<R: JsonSchema>(name: &str) -> Json {
    let settings = SchemaSettings::draft07().for_deserialize().with(|s| s.inline_subschemas = true);
    let mut schema = settings.into_generator().into_root_schema_for::<R>().to_value();
    unwrap_lines(&mut schema);
    let [mut set, _] = scene_schemas();
    set["description"] = format!("Fields of the base scene that the {name} replaces in every run.").into();
    schema["properties"]["set"] = set;
    schema
}
