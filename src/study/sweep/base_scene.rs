//! Base scene: its keys and values are checked once, and it is serialised once with gaps for the values of the axes.
//! Checks that depend on the axes, such as whether the finger closes, are made in each run.

use serde::Deserialize;
use serde_json::Value as Json;
use toml::de::{DeTable, DeValue, Deserializer, ValueDeserializer};
use toml::{Spanned, Table, Value};

use super::field::{FieldType, join};
use crate::scene::Keyword;
use crate::scene::keywords::SceneKind;
use crate::scene::parse::syntax_problem;
use crate::scene::precedence::replaced_keys;
use crate::scene::schema::{other_schemas, schema_for};
use crate::scene::toml_value::TomlValue;
use crate::scene::{Layer, Problem, SceneError, keys, parse_layers};

/// A base scene.
pub struct Base {
    pub table: Table,
    pub kind: SceneKind,
    /// Text of its file; empty if the scene is part of the study file.
    pub text: String,
}

/// Builds a base scene from the arguments of `scene::parse_layers`.
pub(crate) fn base_from_layers(layers: &[Layer], settings: &[Layer]) -> Result<Base, SceneError> {
    parse_layers(layers, settings, |text: &str, file: &str| {
        let refuse = |problems| SceneError::Invalid { file: file.to_string(), text: text.to_string(), problems };
        let document = DeTable::parse(text).map_err(|error| refuse(vec![syntax_problem(&error)]))?;
        let (mut problems, kind) = (Vec::new(), scene_kind(document.get_ref()));
        let table = check_scene(document, "", kind, &mut problems);
        if problems.is_empty() { Ok(Base { table, kind, text: text.to_string() }) } else { Err(refuse(problems)) }
    })
}

/// Kind of the scene in a document; a finger if it is missing or unknown.
pub(crate) fn scene_kind(document: &DeTable<'_>) -> SceneKind {
    let name = document.get("kind").and_then(|kind| kind.get_ref().as_str());
    SceneKind::ALL.into_iter().find(|kind| Some(kind.keyword()) == name).unwrap_or(SceneKind::Finger)
}

/// Checks a scene of this kind, or a section of one at `path` of its file. Returns its valid content.
pub(crate) fn check_scene(
    mut document: Spanned<DeTable<'_>>,
    path: &str,
    kind: SceneKind,
    problems: &mut Vec<Problem>,
) -> Table {
    if kind == SceneKind::Bodies {
        problems.push(Problem {
            span: document.get_ref().get("kind").map(Spanned::span),
            message: "a sweep simulates fingers and grippers, but this is a scene of kind \"bodies\"".to_string(),
            label: "another kind".to_string(),
            help:
                "use the scene of a finger (kind = \"finger\", or without `kind`) or of a gripper (kind = \"gripper\")"
                    .to_string(),
        });
        return Table::new();
    }
    let allowed =
        keys::KeySchemas { kind: kind.keyword(), schema: schema_for(kind), other_kinds: &|| other_schemas(kind) };
    problems.extend(keys::remove_unknown(document.get_mut(), &allowed));
    check_values(document.get_ref(), schema_for(kind), path, problems);
    Table::deserialize(Deserializer::from(document)).unwrap_or_default()
}

/// Checks the types and units of single values against a schema. Values of several types are accepted.
pub(crate) fn check_values(table: &DeTable<'_>, schema: &Json, path: &str, problems: &mut Vec<Problem>) {
    for (key, value) in table {
        let key = key.get_ref().as_ref();
        let (path, schema) = (join(path, key), keys::child_schema(schema, key).unwrap_or(&Json::Null));
        let (items, is_list) = (schema.get("items"), schema["type"] == "array");
        match value.get_ref() {
            DeValue::Table(inner) => check_values(inner, schema, &path, problems),
            DeValue::Array(tables) if items.is_some_and(keys::is_table) => {
                for inner in tables.iter().filter_map(|item| item.get_ref().as_table()) {
                    check_values(inner, items.unwrap_or(&Json::Null), &path, problems);
                }
            }
            DeValue::Array(values) if schema["minItems"] == 1 && values.is_empty() => problems.push(Problem {
                span: Some(value.span()),
                message: format!("`{path}` is empty"),
                label: "nothing to run".to_string(),
                help: "write comma-separated values in brackets: [0.0, 0.8]".to_string(),
            }),
            DeValue::Array(_) if is_list && items.is_none() => {}
            _ if schema["type"].is_array() => {}
            _ => {
                let of_any = is_list && items.is_none();
                let field_type = if of_any {
                    FieldType::List(Box::new(FieldType::Text), None)
                } else {
                    FieldType::from_schema(schema)
                };
                if let Ok(toml_value) = TomlValue::deserialize(ValueDeserializer::from(value.clone())) {
                    let checked = field_type.read(&path, &Spanned::new(value.span(), toml_value));
                    problems.extend(checked.err().into_iter().flatten());
                }
            }
        }
    }
}

/// Merges the fields of `over` into `base`.
pub fn merge(base: &mut Table, over: Table) {
    replaced_keys(|key| over.contains_key(key)).for_each(|other| _ = base.remove(other));
    for (key, value) in over {
        match (base.get_mut(&key), value) {
            (Some(Value::Table(inner)), Value::Table(more)) => merge(inner, more),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

/// A scene text with gaps.
#[derive(Clone, Debug)]
pub struct Template {
    /// Text before each gap, and the index of its field.
    pieces: Vec<(String, usize)>,
    /// Text after the last gap.
    rest: String,
}

impl Template {
    /// Creates a template with a gap for each field. Missing tables on the path of a field are added.
    pub fn new(mut base: Table, fields: &[&str]) -> Result<Self, String> {
        // Occurs in no scene and needs no escaping in TOML.
        let placeholder = |index: usize| format!("@@phalanx sweep axis {index}@@");
        for (index, path) in fields.iter().enumerate() {
            insert_at_path(&mut base, path, Value::from(placeholder(index)));
        }
        let mut rest = toml::to_string(&base).map_err(|error| error.to_string())?;
        let gaps = (0..fields.len()).map(|index| (format!("\"{}\"", placeholder(index)), index));
        let mut gaps: Vec<_> = gaps.filter_map(|(quoted, index)| Some((rest.find(&quoted)?, quoted, index))).collect();
        gaps.sort_unstable();
        let mut pieces = Vec::new();
        for (_, quoted, index) in gaps {
            if let Some((before, after)) = rest.split_once(&quoted) {
                pieces.push((before.to_string(), index));
                rest = after.to_string();
            }
        }
        Ok(Template { pieces, rest })
    }

    /// Returns the scene text with the TOML values of all fields, in the order of the fields.
    pub fn fill(&self, values: &[&str]) -> String {
        let gaps = self.pieces.iter().flat_map(|(piece, index)| [piece.as_str(), values.get(*index).unwrap_or(&"")]);
        gaps.chain([self.rest.as_str()]).collect()
    }
}

/// Inserts a value at a path and removes the fields that it replaces.
fn insert_at_path(table: &mut Table, path: &str, value: Value) {
    match path.split_once('.') {
        None => {
            replaced_keys(|key| key == path).for_each(|other| _ = table.remove(other));
            table.retain(|known, _| keys::pair_element(known).is_none_or(|(pair, _)| pair != path));
            table.insert(path.to_string(), value);
        }
        Some((key, rest)) => {
            let inner = table.entry(key).or_insert_with(|| Value::Table(Table::new()));
            // The base scene has been checked, so this is a table.
            if let Value::Table(inner) = inner {
                insert_at_path(inner, rest, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fills_values_at_the_paths_of_the_fields() {
        let base: Table =
            "duration = \"20 ms\"\n[design]\nbase = \"1 mm\"\nl21_fraction = 1\n[motor]\ntorque = \"1 N*m\"\n"
                .parse()
                .expect("TOML");
        let fields = ["motor.torque", "contact.friction.mu_static", "design.base", "palm", "design.l21"];
        let template = Template::new(base, &fields).expect("a template");
        let text = template.fill(&["\"2 N*m\"", "0.8", "\"12 mm\"", "false", "\"24 mm\""]);
        let expected: Table = "duration = \"20 ms\"\npalm = false\ndesign.base = \"12 mm\"\ndesign.l21 = \"24 mm\"\nmotor.torque = \"2 N*m\"\n\
                               contact.friction.mu_static = 0.8\n"
            .parse()
            .expect("TOML");
        assert_eq!(text.parse::<Table>().expect("TOML"), expected, "{text}");
    }

    #[test]
    fn merge_replaces_single_fields() {
        let mut base: Table = "a = 1\nt.x = 1\nt.y = 2\n".parse().expect("TOML");
        merge(&mut base, "b = 2\nt.y = 3\nu.z = 4\n".parse().expect("TOML"));
        assert_eq!(base, "a = 1\nb = 2\nt.x = 1\nt.y = 3\nu.z = 4\n".parse().expect("TOML"));
    }
}
