//! Base scene: its keys and values are checked once. Checks that depend on the axes, such as whether the finger closes,
//! are made in each run.

use std::ops::Range;
use std::path::Path;

use serde::Deserialize;
use serde_json::Value as Json;
use toml::de::{DeTable, DeValue, Deserializer, ValueDeserializer};
use toml::{Spanned, Table};

use super::field::{FieldType, join};
use super::problem::problem;
use crate::scene::keywords::SceneKind;
use crate::scene::parse::syntax_problem;
use crate::scene::schema::{other_schemas, schema_for};
use crate::scene::toml_value::TomlValue;
use crate::scene::value_kinds::Keyword;
use crate::scene::{Layer, Problem, SceneError, keys, load_layers, parse_layers};

/// A base scene.
pub struct Base {
    pub table: Table,
    pub kind: SceneKind,
    /// Text of its file; empty if the scene is part of the study file.
    pub text: String,
}

/// Error in the base scene, located in the study file or in the scene file.
pub enum BaseError {
    Study(Problem),
    Scene(SceneError, SceneKind),
}

/// Reads the scene file that a study names, relative to the directory of the study. `span` locates the name.
pub fn load(scene: &str, study_file: &str, span: Option<Range<usize>>) -> Result<Base, BaseError> {
    let path = Path::new(study_file).parent().unwrap_or(Path::new("")).join(scene);
    let layers = load_layers(&path).map_err(|error| match error {
        SceneError::Read { file, reason } => BaseError::Study(problem(
            span.clone(),
            format!("cannot read the base scene {file}: {reason}"),
            "this file".to_string(),
            "name a scene file; its path is relative to the directory of the study".to_string(),
        )),
        error => BaseError::Scene(error, SceneKind::Finger),
    })?;
    let kind = parse_layers(&layers, &[], |text, _| {
        Ok(DeTable::parse(text).map_or(SceneKind::Finger, |document| scene_kind(document.get_ref())))
    });
    base_from_layers(&layers, &[]).map_err(|error| BaseError::Scene(error, kind.unwrap_or(SceneKind::Finger)))
}

/// Builds a base scene from the arguments of `scene::parse_layers`.
pub fn base_from_layers(layers: &[Layer], settings: &[Layer]) -> Result<Base, SceneError> {
    let read = |text: &str, file: &str| {
        let refuse = |problems| SceneError::Invalid { file: file.to_string(), text: text.to_string(), problems };
        let document = DeTable::parse(text).map_err(|error| refuse(vec![syntax_problem(&error)]))?;
        let (mut problems, kind) = (Vec::new(), scene_kind(document.get_ref()));
        let table = check_scene(document, "", kind, &mut problems);
        if problems.is_empty() { Ok(Base { table, kind, text: text.to_string() }) } else { Err(refuse(problems)) }
    };
    parse_layers(layers, settings, read)
}

/// Kind of the scene in a document; a finger if it is missing or unknown.
pub fn scene_kind(document: &DeTable<'_>) -> SceneKind {
    let name = document.get("kind").and_then(|kind| kind.get_ref().as_str());
    SceneKind::ALL.into_iter().find(|kind| Some(kind.keyword()) == name).unwrap_or(SceneKind::Finger)
}

/// Checks a scene of this kind, or a section of one at `path` of its file. Returns its valid content.
pub fn check_scene(
    mut document: Spanned<DeTable<'_>>,
    path: &str,
    kind: SceneKind,
    problems: &mut Vec<Problem>,
) -> Table {
    if kind == SceneKind::Bodies {
        problems.push(problem(
            document.get_ref().get("kind").map(Spanned::span),
            "a sweep simulates fingers and grippers, but this is a scene of kind \"bodies\"".to_string(),
            "another kind".to_string(),
            "use the scene of a finger (kind = \"finger\", or without `kind`) or of a gripper (kind = \"gripper\")"
                .to_string(),
        ));
        return Table::new();
    }
    let allowed =
        keys::KeySchemas { kind: kind.keyword(), schema: schema_for(kind), other_kinds: &|| other_schemas(kind) };
    problems.extend(keys::remove_unknown(document.get_mut(), &allowed));
    check_values(document.get_ref(), schema_for(kind), path, problems);
    Table::deserialize(Deserializer::from(document)).unwrap_or_default()
}

/// Checks the types and units of single values.
fn check_values(table: &DeTable<'_>, schema: &Json, path: &str, problems: &mut Vec<Problem>) {
    for (key, value) in table {
        let key = key.get_ref().as_ref();
        let (path, schema) = (join(path, key), keys::child_schema(schema, key).unwrap_or(&Json::Null));
        if let DeValue::Table(inner) = value.get_ref() {
            check_values(inner, schema, &path, problems);
        } else if let Ok(toml_value) = TomlValue::deserialize(ValueDeserializer::from(value.clone())) {
            let toml_value = Spanned::new(value.span(), toml_value);
            problems.extend(FieldType::from_schema(schema).read(&path, &toml_value).err().into_iter().flatten());
        }
    }
}
