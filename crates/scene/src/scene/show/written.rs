//! A scene as it was written, with every default beside it, and what follows from it as comments.
//!
//! What was written stays to the letter. A default is put where the scene is the same with it, bit for bit, which is tried:
//! many keys have a meaning beside certain others only.

use std::fmt::Write as _;
use std::ops::Range;

use serde_json::Value;
use toml::de::{DeTable, DeValue};

use super::super::keys::element;
use super::super::schema::schema_of;
use super::super::words::SceneKind;
use super::super::{Scene, parse_any};
use super::out::Out;
use crate::units::number;

/// Digits of what follows: enough to see it, few enough to read it.
const DIGITS: usize = 6;

/// Contacts that may have laws of their own.
const PLACES: [&str; 4] = ["proximal", "distal", "palm", "table"];

/// Keys and sections of a scene in the order in which people think of them; others stand where they were written.
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

/// A part of a scene file.
#[derive(Clone, Debug)]
enum Node {
    /// A value as it is written.
    Text(String),
    Table(Vec<(String, Node)>),
}

/// The scene as its source says it, with every default filled in. It parses back to the same scene, bit for bit (its
/// `source` excepted). A scene whose source is not its own (changed since it was read) is shown as it is now, in full.
pub fn show_written(scene: &Scene) -> String {
    let source = &scene.source;
    let Ok(document) = DeTable::parse(source) else { return super::show(scene) };
    let mut root = table(document.get_ref(), source);
    put(&mut root, &["name"], &toml::Value::String(scene.name.clone()).to_string());
    if !is_same(&rendered(&root), scene) {
        return super::show(scene);
    }
    // Twice: some defaults go beside others only.
    for _ in 0..2 {
        fill(&mut root, schema_of(scene.kind()), &mut Vec::new(), scene);
    }
    let whole = super::shown(scene, Out::rounded(scene.kind(), DIGITS));
    sort(&mut root, &whole, "");
    let mut text = "# As it was written, with every default filled in.\n".to_string();
    text += &rendered(&root);
    text + &follows(&root, &whole)
}

/// A table with its values as they are written, in their order.
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

/// Puts a value where there is none, with the sections on its way. Whether it did.
fn put(table: &mut Vec<(String, Node)>, path: &[&str], text: &str) -> bool {
    let [key, rest @ ..] = path else { return false };
    let position = table.iter().position(|(known, _)| known == key);
    match (position.map(|index| &mut table[index].1), rest) {
        (None, []) => {
            table.push((key.to_string(), Node::Text(text.to_string())));
            true
        }
        (None, _) => {
            let mut inner = Vec::new();
            let done = put(&mut inner, rest, text);
            table.push((key.to_string(), Node::Table(inner)));
            done
        }
        (Some(Node::Table(inner)), [_, ..]) => put(inner, rest, text),
        (Some(_), _) => false,
    }
}

/// Puts a value where there is none, if the scene is the same with it.
fn put_if_same(root: &mut Vec<(String, Node)>, path: &[&str], text: &str, scene: &Scene) {
    let mut tried = root.clone();
    if put(&mut tried, path, text) && is_same(&rendered(&tried), scene) {
        *root = tried;
    }
}

/// Puts every default of the schema that leaves the scene as it is.
fn fill<'a>(root: &mut Vec<(String, Node)>, schema: &'a Value, path: &mut Vec<&'a str>, scene: &Scene) {
    let Some(properties) = schema["properties"].as_object() else { return };
    for (key, property) in properties {
        path.push(key);
        // The law of one contact is the scene's own wish, and so is what one finger has: they have the defaults of both. A table and a
        // differential are there if they are spoken of.
        let is_own = matches!(path[..], ["contact", "proximal" | "distal" | "palm" | "table"] | ["right" | "left"]);
        if is_own || (matches!(path[..], ["table" | "differential"]) && find(root, key).is_none()) {
            path.pop();
            continue;
        }
        if let Some(default) = property.get("default").and_then(toml_text) {
            put_if_same(root, path, &default, scene);
        }
        fill(root, property, path, scene);
        if let (Some(each), SceneKind::Bodies) = (property.get("additionalProperties"), scene.kind()) {
            for disc in &scene.system.discs {
                fill_disc(root, each, &disc.name, scene);
            }
        }
        path.pop();
    }
}

fn fill_disc(root: &mut Vec<(String, Node)>, schema: &Value, name: &str, scene: &Scene) {
    for (key, property) in schema["properties"].as_object().into_iter().flatten() {
        let Some(default) = property.get("default").and_then(toml_text) else { continue };
        put_if_same(root, &["discs", name, key], &default, scene);
    }
}

/// A default of the schema as TOML.
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

/// Whether a text is the same scene, whatever its source.
fn is_same(text: &str, scene: &Scene) -> bool {
    let Ok(mut found) = parse_any(text, "scene.toml") else { return false };
    found.source.clone_from(&scene.source);
    found == *scene
}

fn rendered(root: &[(String, Node)]) -> String {
    let mut text = String::new();
    let place = |key: &str| ORDER.iter().position(|known| *known == key).unwrap_or(ORDER.len());
    let mut sorted: Vec<_> = root.iter().collect();
    sorted.sort_by_key(|(key, _)| place(key));
    render(&mut text, &sorted, "");
    text
}

/// Sorts the keys of each section as a whole scene has them; what it does not have stays in its order, behind.
fn sort(entries: &mut [(String, Node)], whole: &str, path: &str) {
    for (key, node) in entries {
        let Node::Table(inner) = node else { continue };
        let here = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        // A whole scene has the law of both contacts at each of them.
        let names = [here.clone(), here.replacen("contact", "contact.proximal", 1)];
        let head = names.iter().find_map(|name| whole.split_once(&format!("\n[{name}]\n")));
        let section = head.map_or("", |(_, rest)| rest.split("\n\n").next().unwrap_or(rest));
        let keys: Vec<&str> = section.lines().filter_map(|line| Some(line.split_once(" = ")?.0)).collect();
        inner.sort_by_key(|(key, _)| keys.iter().position(|known| known == key).unwrap_or(keys.len()));
        sort(inner, whole, &here);
    }
}

/// Values before sections, as TOML wants it.
fn render(text: &mut String, entries: &[&(String, Node)], path: &str) {
    // Writing to a string cannot fail.
    for (key, node) in entries {
        if let Node::Text(value) = node {
            let quote = if element(key).is_some() { "\"" } else { "" };
            let _ = writeln!(text, "{quote}{key}{quote} = {value}");
        }
    }
    for (key, node) in entries {
        let Node::Table(inner) = node else { continue };
        let here = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        if inner.is_empty() || inner.iter().any(|(_, node)| matches!(node, Node::Text(_))) {
            let _ = write!(text, "\n[{here}]\n");
        }
        render(text, &inner.iter().collect::<Vec<_>>(), &here);
    }
}

/// What a scene comes to beyond what it says, rounded, as comments.
fn follows(root: &[(String, Node)], whole: &str) -> String {
    let contact =
        |place: &str| matches!(find(root, "contact"), Some(Node::Table(inner)) if find(inner, place).is_some());
    let one_law = !PLACES.into_iter().any(contact);
    let mut text = String::new();
    let mut section = String::new();
    let mut said = String::new();
    for line in whole.lines() {
        if let Some(name) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
            section = name.to_string();
            // Both contacts have the same law unless something is said of one of them.
            if one_law {
                section = section.replacen("contact.proximal", "contact", 1);
            }
            continue;
        }
        let Some((key, _)) = line.split_once(" = ") else { continue };
        let repeated = one_law && PLACES[1..].iter().any(|place| section.starts_with(&format!("contact.{place}")));
        // What is said of both fingers is that of each; a law of one contact that is that of all is said there; a design has some of
        // the lengths.
        let both = ["right.", "left."].into_iter().find_map(|side| section.strip_prefix(side)).unwrap_or(&section);
        let law = PLACES.into_iter().find(|place| both.starts_with(&format!("contact.{place}")));
        let common = law.map_or(both.to_string(), |place| both.replacen(&format!("contact.{place}"), "contact", 1));
        let common = if section == "lengths" { "design" } else { &common };
        if line.starts_with('#') || repeated || is_given(root, &section, key) || is_given(root, common, key) {
            continue;
        }
        if said != section {
            let _ = write!(text, "#\n# [{section}]\n");
            said.clone_from(&section);
        }
        let _ = writeln!(text, "# {line}");
    }
    if text.is_empty() {
        return text;
    }
    format!("\n# What follows from this, rounded (scene show --resolved has all digits):\n{text}")
}

fn is_given(root: &[(String, Node)], section: &str, key: &str) -> bool {
    let mut table = root;
    for part in section.split('.').filter(|part| !part.is_empty()) {
        match find(table, part) {
            Some(Node::Table(inner)) => table = inner,
            _ => return false,
        }
    }
    find(table, key).is_some()
}
