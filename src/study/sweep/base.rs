//! The base scene: its keys and values are checked once, as far as that can be said without the axes; whether the finger
//! closes, say, is found run by run.

use std::ops::Range;
use std::path::Path;

use serde::Deserialize;
use serde_json::Value as Json;
use toml::de::{DeTable, DeValue, Deserializer, ValueDeserializer};
use toml::{Spanned, Table};

use super::field::{Holds, join};
use super::problem::problem;
use crate::scene::any::Any;
use crate::scene::kinds::Words;
use crate::scene::schema::{schema_of, schemas_but};
use crate::scene::text::syntax;
use crate::scene::words::SceneKind;
use crate::scene::{Layer, Problem, SceneError, keys, layers, parse_layers};

/// A base scene.
pub struct Base {
    pub table: Table,
    pub kind: SceneKind,
    /// The text of its file; empty if it stands in the study.
    pub text: String,
}

/// Why there is no base scene: because of what the study says of it, or because of what its own file says.
pub enum Refusal {
    Study(Problem),
    Scene(SceneError, SceneKind),
}

/// Reads the scene file that a study names, from the study's directory; `span`: where it does.
pub fn load(scene: &str, study_file: &str, span: Option<Range<usize>>) -> Result<Base, Refusal> {
    let path = Path::new(study_file).parent().unwrap_or(Path::new("")).join(scene);
    let layers = layers(&path).map_err(|error| match error {
        SceneError::Read { file, reason } => Refusal::Study(problem(
            span.clone(),
            format!("cannot read the base scene {file}: {reason}"),
            "this file".to_string(),
            "name a scene file; its path is seen from the directory of the study".to_string(),
        )),
        error => Refusal::Scene(error, SceneKind::Finger),
    })?;
    let kind = parse_layers(&layers, &[], |text, _| {
        Ok(DeTable::parse(text).map_or(SceneKind::Finger, |document| kind_of(document.get_ref())))
    });
    of_layers(&layers, &[]).map_err(|error| Refusal::Scene(error, kind.unwrap_or(SceneKind::Finger)))
}

/// The base scene of these texts, see `scene::parse_layers`.
pub fn of_layers(layers: &[Layer], settings: &[Layer]) -> Result<Base, SceneError> {
    let read = |text: &str, file: &str| {
        let refuse = |problems| SceneError::Invalid { file: file.to_string(), text: text.to_string(), problems };
        let document = DeTable::parse(text).map_err(|error| refuse(vec![syntax(&error)]))?;
        let (mut problems, kind) = (Vec::new(), kind_of(document.get_ref()));
        let table = check(document, "", kind, &mut problems);
        if problems.is_empty() { Ok(Base { table, kind, text: text.to_string() }) } else { Err(refuse(problems)) }
    };
    parse_layers(layers, settings, read)
}

/// The kind of scene a document says it is; of a finger if it says nothing that is known.
pub fn kind_of(document: &DeTable<'_>) -> SceneKind {
    let said = document.get("kind").and_then(|kind| kind.get_ref().as_str());
    SceneKind::ALL.into_iter().find(|kind| Some(kind.word()) == said).unwrap_or(SceneKind::Finger)
}

/// Checks a scene of this kind or a part of one, which stands under `path` in its file.
pub fn check(mut document: Spanned<DeTable<'_>>, path: &str, kind: SceneKind, problems: &mut Vec<Problem>) -> Table {
    if kind == SceneKind::Bodies {
        problems.push(problem(
            document.get_ref().get("kind").map(Spanned::span),
            "a sweep simulates fingers and grippers, but this is a scene of kind \"bodies\"".to_string(),
            "another kind".to_string(),
            "give the scene of a finger (kind = \"finger\", or no kind at all) or of a gripper (kind = \"gripper\")"
                .to_string(),
        ));
        return Table::new();
    }
    let allowed = keys::Allowed { kind: kind.word(), schema: schema_of(kind), others: &|| schemas_but(kind) };
    problems.extend(keys::weed(document.get_mut(), &allowed));
    leaves(document.get_ref(), schema_of(kind), path, problems);
    Table::deserialize(Deserializer::from(document)).unwrap_or_default()
}

/// Checks single values: their kinds, their units.
fn leaves(table: &DeTable<'_>, schema: &Json, path: &str, problems: &mut Vec<Problem>) {
    for (key, value) in table {
        let key = key.get_ref().as_ref();
        let (here, part) = (join(path, key), keys::child(schema, key).unwrap_or(&Json::Null));
        if let DeValue::Table(inner) = value.get_ref() {
            leaves(inner, part, &here, problems);
        } else if let Ok(given) = Any::deserialize(ValueDeserializer::from(value.clone())) {
            let given = Spanned::new(value.span(), given);
            problems.extend(Holds::of(part).read(&here, &given).err().into_iter().flatten());
        }
    }
}
