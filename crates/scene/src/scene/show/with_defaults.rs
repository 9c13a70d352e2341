//! Formats a scene as written, with all defaults added, and with derived values as comments.
//!
//! The written text is preserved verbatim. A default is added only if the scene remains identical bit for bit. Each
//! default is tested by parsing, because many keys have an effect only with certain other keys.

use std::fmt::Write as _;
use std::ops::Range;

use serde_json::Value;
use toml::de::{DeTable, DeValue};

use super::super::keys::pair_element;
use super::super::keywords::SceneKind;
use super::super::schema::schema_for;
use super::super::{Scene, parse_any};
use super::toml_writer::TomlWriter;
use crate::units::number;

/// Significant digits of derived values.
const DIGITS: usize = 6;

/// Contacts that may have laws of their own.
const CONTACTS: [&str; 4] = ["proximal", "distal", "palm", "table"];

/// Preferred order of keys and sections; others remain where they were written.
const ORDER: [&str; 33] = [
    "name",
    "description",
    "kind",
    "duration",
    "gravity",
    "half_width",
    "assembly",
    "palm",
    "palm_width",
    "positioning_error",
    "sizing",
    "closing_time",
    "design",
    "lengths",
    "material",
    "bodies",
    "discs",
    "half_plane",
    "object",
    "table",
    "differential",
    "motor",
    "spring",
    "limit",
    "contact",
    "initial",
    "right",
    "left",
    "integrator",
    "engine",
    "validate",
    "criteria",
    "log",
];

/// A value or table of a scene file.
#[derive(Clone, Debug)]
enum Node {
    /// A value as written.
    Text(String),
    Table(Vec<(String, Node)>),
}

/// Returns the source of the scene with every default added. It parses back to the same scene bit for bit, except for
/// `source`. A scene that has been changed since its source was read is shown in full as it is now.
pub fn show_written(scene: &Scene) -> String {
    let source = &scene.source;
    let Ok(document) = DeTable::parse(source) else { return super::show(scene) };
    let mut root = table(document.get_ref(), source);
    insert(&mut root, &["name"], &toml::Value::String(scene.name.clone()).to_string());
    if !is_same(&to_text(&root), scene) {
        return super::show(scene);
    }
    // Two passes: some defaults are possible only after others have been added.
    for _ in 0..2 {
        insert_defaults(&mut root, schema_for(scene.kind()), &mut Vec::new(), scene);
    }
    let complete = super::write_scene(scene, TomlWriter::rounded(scene.kind(), DIGITS));
    sort(&mut root, &complete, "");
    let mut text = "# Scene as written, with every default filled in.\n".to_string();
    text += &to_text(&root);
    text + &derived_values(&root, &complete)
}

/// Converts a table with its values as written, in their order.
fn table(from: &DeTable<'_>, source: &str) -> Vec<(String, Node)> {
    let mut entries: Vec<(Range<usize>, String, Node)> = Vec::new();
    for (key, value) in from {
        let node = match value.get_ref() {
            DeValue::Table(inner) => Node::Table(table(inner, source)),
            _ => Node::Text(source[value.span()].to_string()),
        };
        entries.push((key.span(), key.get_ref().to_string(), node));
    }
    entries.sort_by_key(|(span, ..)| span.start);
    entries.into_iter().map(|(_, key, node)| (key, node)).collect()
}

fn find<'a>(table: &'a [(String, Node)], key: &str) -> Option<&'a Node> {
    table.iter().find(|(known, _)| known == key).map(|(_, node)| node)
}

/// Inserts a missing value, with its sections. Returns `false` if the value exists.
fn insert(table: &mut Vec<(String, Node)>, path: &[&str], text: &str) -> bool {
    let [key, rest @ ..] = path else { return false };
    let position = table.iter().position(|(known, _)| known == key);
    match (position.map(|index| &mut table[index].1), rest) {
        (None, []) => {
            table.push((key.to_string(), Node::Text(text.to_string())));
            true
        }
        (None, _) => {
            let mut inner = Vec::new();
            let was_inserted = insert(&mut inner, rest, text);
            table.push((key.to_string(), Node::Table(inner)));
            was_inserted
        }
        (Some(Node::Table(inner)), [_, ..]) => insert(inner, rest, text),
        (Some(_), _) => false,
    }
}

/// Inserts a missing value if it does not change the scene.
fn insert_if_same(root: &mut Vec<(String, Node)>, path: &[&str], text: &str, scene: &Scene) {
    let mut candidate = root.clone();
    if insert(&mut candidate, path, text) && is_same(&to_text(&candidate), scene) {
        *root = candidate;
    }
}

/// Inserts every default of the schema that does not change the scene.
fn insert_defaults<'a>(root: &mut Vec<(String, Node)>, schema: &'a Value, path: &mut Vec<&'a str>, scene: &Scene) {
    let Some(properties) = schema["properties"].as_object() else { return };
    for (key, property) in properties {
        path.push(key);
        // Laws of individual contacts and settings of individual fingers default to the common ones. The section of a table or
        // a differential adds the component, so it must not be inserted.
        let overrides_common =
            matches!(path[..], ["contact", "proximal" | "distal" | "palm" | "table"] | ["right" | "left"]);
        if overrides_common || (matches!(path[..], ["table" | "differential"]) && find(root, key).is_none()) {
            path.pop();
            continue;
        }
        if let Some(default) = property.get("default").and_then(toml_text) {
            insert_if_same(root, path, &default, scene);
        }
        insert_defaults(root, property, path, scene);
        if let (Some(each), SceneKind::Bodies) = (property.get("additionalProperties"), scene.kind()) {
            for disc in &scene.system.discs {
                insert_disc_defaults(root, each, &disc.name, scene);
            }
        }
        path.pop();
    }
}

fn insert_disc_defaults(root: &mut Vec<(String, Node)>, schema: &Value, name: &str, scene: &Scene) {
    for (key, property) in schema["properties"].as_object().into_iter().flatten() {
        let Some(default) = property.get("default").and_then(toml_text) else { continue };
        insert_if_same(root, &["discs", name, key], &default, scene);
    }
}

/// Formats a default of the schema as TOML.
fn toml_text(value: &Value) -> Option<String> {
    match value {
        Value::Bool(flag) => Some(flag.to_string()),
        Value::Number(count) if count.is_u64() => Some(count.to_string()),
        Value::Number(value) => {
            let text = number(value.as_f64()?);
            Some(if text.contains(['.', 'e']) { text } else { text + ".0" })
        }
        Value::String(text) => Some(toml::Value::String(text.clone()).to_string()),
        Value::Array(items) => {
            let items: Option<Vec<String>> = items.iter().map(toml_text).collect();
            Some(format!("[{}]", items?.join(", ")))
        }
        _ => None,
    }
}

/// Whether a text parses to the same scene, except for `source`.
fn is_same(text: &str, scene: &Scene) -> bool {
    let Ok(mut found) = parse_any(text, "scene.toml") else { return false };
    found.source.clone_from(&scene.source);
    found == *scene
}

fn to_text(root: &[(String, Node)]) -> String {
    let mut text = String::new();
    let position = |key: &str| ORDER.iter().position(|known| *known == key).unwrap_or(ORDER.len());
    let mut sorted: Vec<_> = root.iter().collect();
    sorted.sort_by_key(|(key, _)| position(key));
    render(&mut text, &sorted, "");
    text
}

/// Sorts the keys of each section in the order of the complete scene; other keys follow in their original order.
fn sort(entries: &mut [(String, Node)], complete: &str, path: &str) {
    for (key, node) in entries {
        let Node::Table(inner) = node else { continue };
        let section_path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        // The complete scene contains the common contact law under each contact.
        let names = [section_path.clone(), section_path.replacen("contact", "contact.proximal", 1)];
        let head = names.iter().find_map(|name| complete.split_once(&format!("\n[{name}]\n")));
        let section = head.map_or("", |(_, rest)| rest.split("\n\n").next().unwrap_or(rest));
        let keys: Vec<&str> = section.lines().filter_map(|line| Some(line.split_once(" = ")?.0)).collect();
        inner.sort_by_key(|(key, _)| keys.iter().position(|known| known == key).unwrap_or(keys.len()));
        sort(inner, complete, &section_path);
    }
}

/// Writes values before sections, as TOML requires.
fn render(text: &mut String, entries: &[&(String, Node)], path: &str) {
    // Writing to a string cannot fail.
    for (key, node) in entries {
        if let Node::Text(value) = node {
            let quote = if pair_element(key).is_some() { "\"" } else { "" };
            let _ = writeln!(text, "{quote}{key}{quote} = {value}");
        }
    }
    for (key, node) in entries {
        let Node::Table(inner) = node else { continue };
        let section_path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        if inner.is_empty() || inner.iter().any(|(_, node)| matches!(node, Node::Text(_))) {
            let _ = write!(text, "\n[{section_path}]\n");
        }
        render(text, &inner.iter().collect::<Vec<_>>(), &section_path);
    }
}

/// Returns the values derived from the scene, rounded, as comments.
fn derived_values(root: &[(String, Node)], complete: &str) -> String {
    let contact =
        |contact: &str| matches!(find(root, "contact"), Some(Node::Table(inner)) if find(inner, contact).is_some());
    let has_common_law = !CONTACTS.into_iter().any(contact);
    let mut text = String::new();
    let mut section = String::new();
    let mut current_section = String::new();
    for line in complete.lines() {
        if let Some(name) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
            section = name.to_string();
            // If no contact has its own settings, all have the same law.
            if has_common_law {
                section = section.replacen("contact.proximal", "contact", 1);
            }
            continue;
        }
        let Some((key, _)) = line.split_once(" = ") else { continue };
        let is_repeated =
            has_common_law && CONTACTS[1..].iter().any(|contact| section.starts_with(&format!("contact.{contact}")));
        // A value may be given in a common section: that of both fingers, the common contact law, or the design for
        // some lengths.
        let common_section =
            ["right.", "left."].into_iter().find_map(|side| section.strip_prefix(side)).unwrap_or(&section);
        let law = CONTACTS.into_iter().find(|contact| common_section.starts_with(&format!("contact.{contact}")));
        let common = law.map_or(common_section.to_string(), |contact| {
            common_section.replacen(&format!("contact.{contact}"), "contact", 1)
        });
        let common = if section == "lengths" { "design" } else { &common };
        if line.starts_with('#') || is_repeated || is_present(root, &section, key) || is_present(root, common, key) {
            continue;
        }
        if current_section != section {
            let _ = write!(text, "#\n# [{section}]\n");
            current_section.clone_from(&section);
        }
        let _ = writeln!(text, "# {line}");
    }
    if text.is_empty() {
        return text;
    }
    format!("\n# Derived values, rounded (`scene show --resolved` shows all digits):\n{text}")
}

fn is_present(root: &[(String, Node)], section: &str, key: &str) -> bool {
    let mut table = root;
    for part in section.split('.').filter(|part| !part.is_empty()) {
        match find(table, part) {
            Some(Node::Table(inner)) => table = inner,
            _ => return false,
        }
    }
    find(table, key).is_some()
}
