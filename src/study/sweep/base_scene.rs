//! Base scene: its keys and values are checked once, and it is serialised once with gaps for the values of the axes.
//! Checks that depend on the axes, such as whether the finger closes, are made in each run.

use serde::Deserialize;
use serde_json::Value as Json;
use toml::de::{DeTable, DeValue, Deserializer};
use toml::{Spanned, Table, Value};

use super::axis::{AxisValue, Field, FieldType};
use crate::scene::check::Checker;
use crate::scene::keywords::SceneKind;
use crate::scene::parameters::Parameters;
use crate::scene::parse::syntax_problem;
use crate::scene::precedence::replaced_keys;
use crate::scene::schema::{other_schemas, schema_for};
use crate::scene::{
    Keyword, Layer, PARAMETERS, Part, Problem, SceneError, keys, parse_field, parse_layers_as, parse_layers_of_section,
    split_entries,
};

pub(in crate::study) struct Base {
    pub table: Table,
    pub kind: SceneKind,
    pub parameters: Parameters,
    /// Text of the file of the scene, and of the files that it extends; empty if the whole scene is part of the study
    /// file.
    pub text: String,
}

impl Base {
    /// Whether the scenes contain five-bar fingers. A scene whose object is not a disc is a mechanism instead.
    pub fn is_hand(&self) -> bool {
        let has_outline = self.table.get("object").and_then(|object| object.get("outline")).is_some();
        self.kind.fingers() > 0 && !has_outline
    }

    /// Finds a field. The problem of an unknown path has no position.
    pub fn field(&self, path: &str) -> Result<Field, Problem> {
        Field::find(path, self.kind, &self.table, &self.parameters)
    }
}

/// Builds a base scene from the arguments of `scene::parse_layers_as`.
pub(super) fn base_from_layers(layers: &[Layer], settings: &[Layer]) -> Result<Base, SceneError> {
    parse_layers_as(layers, settings, base_from_text)
}

/// Builds a base scene that is the table `section` of a study, the last layer, and extends the others.
pub(super) fn base_from_section(layers: &[Layer], section: &str) -> Result<Base, SceneError> {
    parse_layers_of_section(layers, section, base_from_text)
}

fn base_from_text(text: &str, file: &str) -> Result<Base, SceneError> {
    let refuse = |problems| SceneError::Invalid { file: file.to_string(), text: text.to_string(), problems };
    let document = DeTable::parse(text).map_err(|error| refuse(vec![syntax_problem(&error)]))?;
    let kind = scene_kind(document.get_ref());
    let checker = Checker::new(text, Vec::new()).with_parameters(document.get_ref());
    let table = check_scene(document, "", kind, &checker);
    if !checker.is_clean() {
        return Err(refuse(checker.into_problems()));
    }
    Ok(Base { table, kind, parameters: checker.parameters, text: text.to_string() })
}

/// Kind of the scene in a document; a finger if it is missing or unknown.
pub(super) fn scene_kind(document: &DeTable<'_>) -> SceneKind {
    let name = document.get("kind").and_then(|kind| kind.get_ref().as_str());
    name.and_then(SceneKind::from_keyword).unwrap_or(SceneKind::Finger)
}

/// Checks a scene of this kind, or a section of one at `path` of its file. Returns its valid content.
pub(super) fn check_scene(mut document: Spanned<DeTable<'_>>, path: &str, kind: SceneKind, checker: &Checker) -> Table {
    let allowed =
        keys::KeySchemas { kind: kind.keyword(), schema: schema_for(kind), other_kinds: &|| other_schemas(kind) };
    checker.extend(keys::remove_unknown(document.get_mut(), &allowed));
    check_values(document.get_ref(), schema_for(kind), path, checker);
    Table::deserialize(Deserializer::from(document)).unwrap_or_default()
}

/// Checks the types and units of single values against a schema. Values of several types are accepted.
pub(super) fn check_values(table: &DeTable<'_>, schema: &Json, path: &str, checker: &Checker) {
    for (key, value) in table {
        let key = key.get_ref().as_ref();
        let (path, schema) = (keys::join(path, key), keys::child_schema(schema, key).unwrap_or(&Json::Null));
        let (items, is_list) = (schema.get("items"), schema["type"] == "array");
        match (value.get_ref(), items) {
            (DeValue::Table(inner), _) => check_values(inner, schema, &path, checker),
            (DeValue::Array(tables), Some(items)) if keys::is_table(items) => {
                let tables = tables.iter().filter_map(|item| item.get_ref().as_table());
                tables.for_each(|inner| check_values(inner, items, &path, checker));
            }
            (DeValue::Array(values), _) if schema["minItems"] == 1 && values.is_empty() => checker.push(Problem::new(
                Some(value.span()),
                format!("`{path}` is empty"),
                "nothing to run",
                "write comma-separated values in brackets: [0.0, 0.8]",
            )),
            (DeValue::Array(_), None) if is_list => {}
            _ if schema["type"].is_array() => {}
            // Parameters are read as a whole.
            _ if schema.get("x-parameter").is_some() => {}
            _ => {
                let field_type = match items {
                    None if is_list => FieldType::List(Box::new(FieldType::Text), None),
                    _ => FieldType::from_schema(schema),
                };
                field_type
                    .read(&path, value, &checker.parameters)
                    .map_or_else(|problems| checker.extend(problems), |_| {});
            }
        }
    }
}

/// Merges the fields of `over` into `base`.
pub(super) fn merge(base: &mut Table, over: Table) {
    replaced_keys(|key| over.contains_key(key)).for_each(|other| _ = base.remove(other));
    for (key, value) in over {
        match (base.get_mut(&key), value) {
            // Parameters have any names.
            (Some(Value::Table(inner)), Value::Table(more)) if key == PARAMETERS => inner.extend(more),
            (Some(Value::Table(inner)), Value::Table(more)) => merge(inner, more),
            (_, value) => _ = base.insert(key, value),
        }
    }
}

/// A scene text with gaps.
#[derive(Clone, Debug)]
pub(super) struct Template {
    /// Text before the first gap.
    head: String,
    /// Index of the field in each gap, and the text after it.
    gaps: Vec<(usize, String)>,
}

/// Start and end of the placeholder of a field. They occur in no scene and need no escaping in TOML.
const PLACEHOLDER: [&str; 2] = ["@@phalanx sweep axis ", "@@"];

impl Template {
    /// Creates a template with a gap for each field. Missing tables on the path of a field are added.
    pub fn new<'a>(mut base: Table, fields: impl Iterator<Item = &'a Field>) -> Result<Self, String> {
        let [open, close] = PLACEHOLDER;
        for (index, field) in fields.enumerate() {
            insert_at_path(&mut base, &parse_field(&field.path)?, Value::from(format!("{open}{index}{close}")));
        }
        let text = toml::to_string(&base).map_err(|error| error.to_string())?;
        let (open, close) = (format!("\"{open}"), format!("{close}\""));
        let mut parts = text.split(&open);
        let head = parts.next().unwrap_or_default().to_string();
        let gap = |part: &str| {
            let (index, text) = part.split_once(&close)?;
            Some((index.parse().ok()?, text.to_string()))
        };
        Ok(Template { head, gaps: parts.filter_map(gap).collect() })
    }

    /// Returns the text of a scene with these TOML values, in the order of the fields.
    pub fn fill(&self, values: &[AxisValue]) -> String {
        let text = |index: &usize| values.get(*index).map_or("", |value| value.text.as_str());
        let gaps = self.gaps.iter().flat_map(|(index, after)| [text(index), after]);
        [self.head.as_str()].into_iter().chain(gaps).collect()
    }
}

/// Inserts a value at a path and removes the fields that it replaces.
pub(super) fn insert_at_path(table: &mut Table, path: &[Part], value: Value) {
    let [part, rest @ ..] = path else { return };
    let key = part.key();
    let list = table.get_mut(&part.name).filter(|_| !part.entries.is_empty());
    // An entry of a list that is not written is an element of a pair with a default, which is a key.
    if let Some(entry) = list.and_then(|list| part.entries.iter().try_fold(list, |list, entry| list.get_mut(*entry))) {
        match entry {
            Value::Table(inner) if !rest.is_empty() => insert_at_path(inner, rest, value),
            entry => *entry = value,
        }
        return;
    }
    if rest.is_empty() {
        replaced_keys(|known| known == key).for_each(|other| _ = table.remove(other));
        table.retain(|known, _| split_entries(known).is_none_or(|(list, _)| list != key));
        table.insert(key, value);
        return;
    }
    // The base scene has been checked, so this is a table.
    match table.entry(key.as_str()).or_insert_with(|| Value::Table(Table::new())) {
        // Parameters have any names.
        Value::Table(inner) if key == PARAMETERS => _ = inner.insert(rest[0].key(), value),
        Value::Table(inner) => insert_at_path(inner, rest, value),
        _ => {}
    }
}
