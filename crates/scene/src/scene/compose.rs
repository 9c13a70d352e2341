//! Merges several texts into one scene: the scenes it extends, its own text, and single settings.
//!
//! The merged text contains every key and value verbatim and is parsed like any other scene. Problems are then reported
//! at their positions in the original texts.

use std::collections::HashMap;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::SceneError;
use super::check::NO_EFFECT;
use super::error::{Problem, shortened};
use super::keys::pair_element;
use super::locate::locate_problems;
use super::parse::{parse_any, syntax_problem};
use super::precedence::{KIND_KEYS, replaced_keys};

/// One of the texts of a scene, with its name for messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    pub file: String,
    pub text: String,
}

/// Keys that are not inherited.
const NOT_INHERITED: [&str; 2] = ["name", "description"];
/// The key with the path of the extended scene.
pub const EXTENDS: &str = "extends";

/// Returns the path of the scene that a text extends, as written, and its position; `None` also for a text that is not
/// TOML.
pub fn extended(text: &str) -> Option<(String, Range<usize>)> {
    let document = DeTable::parse(text).ok()?;
    let value = document.get_ref().get(EXTENDS)?;
    Some((value.get_ref().as_str()?.to_string(), value.span()))
}

/// Merges the texts of a scene and calls `parse` with the merged text and the name of the scene's own file. `files`
/// begins with the extended scenes and ends with the scene's own file; `settings` are lines of `key = value` that
/// override the files.
///
/// # Errors
/// Returns all problems, each with its position in the original text.
pub fn parse_layers<T>(
    files: &[Layer],
    settings: &[Layer],
    parse: impl Fn(&str, &str) -> Result<T, SceneError>,
) -> Result<T, SceneError> {
    let Some(scene_file) = files.last() else { return parse("", "") };
    if files.len() == 1 && settings.is_empty() {
        return parse(&scene_file.text, &scene_file.file);
    }
    let mut merged_table = Table::default();
    for (index, layer) in files.iter().enumerate() {
        let mut overriding = read(layer, index)?;
        overriding.remove(EXTENDS);
        if index > 0 {
            NOT_INHERITED.into_iter().for_each(|key| merged_table.remove(key));
        }
        merged_table.merge(overriding, true);
    }
    let mut set = Table::default();
    for (index, layer) in settings.iter().enumerate() {
        set.merge(read(layer, files.len() + index)?, false);
    }
    merged_table.merge(set, true);
    let mut merged = Merged::new(&merged_table);
    // Inherited keys that have no effect with the last text are removed: `motor.brake = "none"` also removes the keys
    // of the brake.
    let base_layers = &files[..files.len() - usize::from(settings.is_empty())];
    while let Err(error) = parse_any(&merged.text, &scene_file.file) {
        let base_problems =
            parse_layers(base_layers, &[], parse_any).map_or_else(|error| locate_problems(&error), |_| Vec::new());
        let is_new =
            |problem: &&Problem| base_problems.iter().all(|other| other.message != shortened(&problem.message));
        let without_effect = error.problems().iter().filter(|problem| problem.label == NO_EFFECT).filter(is_new);
        let original_positions: Vec<_> =
            without_effect.filter_map(|problem| merged.original_position(problem.span.as_ref()?)).collect();
        if !merged_table.drop(&|segment| {
            segment.layer < base_layers.len() && original_positions.contains(&(segment.layer, segment.span.clone()))
        }) {
            break;
        }
        merged = Merged::new(&merged_table);
    }
    let layers: Vec<&Layer> = files.iter().chain(settings).collect();
    parse(&merged.text, &scene_file.file).map_err(|error| merged.assign_to_layers(error, &layers))
}

fn read(layer: &Layer, index: usize) -> Result<Table, SceneError> {
    let document = DeTable::parse(&layer.text).map_err(|error| SceneError::Invalid {
        file: layer.file.clone(),
        text: layer.text.clone(),
        problems: vec![syntax_problem(&error)],
    })?;
    Ok(Table::parse(document.get_ref(), layer, index))
}

/// A piece of text with its position in a layer.
#[derive(Clone, Debug)]
struct TextSegment {
    text: String,
    layer: usize,
    span: Range<usize>,
}

#[derive(Clone, Debug)]
enum Node {
    Value(TextSegment),
    Table(Table),
}

/// Entries in the order of their first appearance: name, key as written (perhaps quoted), and value.
#[derive(Clone, Debug, Default)]
struct Table(Vec<(String, TextSegment, Node)>);

impl Table {
    fn parse(table: &DeTable<'_>, layer: &Layer, index: usize) -> Self {
        let segment = |text: String, span| TextSegment { text, layer: index, span };
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        let entry = |(key, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
            let name: &std::borrow::Cow<'_, str> = key.get_ref();
            let node = match value.get_ref() {
                DeValue::Table(inner) => Node::Table(Table::parse(inner, layer, index)),
                _ => Node::Value(segment(to_inline(value, &layer.text), value.span())),
            };
            (name.to_string(), segment(layer.text[key.span()].to_string(), key.span()), node)
        };
        Self(entries.into_iter().map(entry).collect())
    }

    fn remove(&mut self, key: &str) {
        self.0.retain(|(name, _, _)| name != key);
    }

    /// Removes all values and tables for which `without_effect` holds; returns whether it removed any.
    fn drop(&mut self, without_effect: &impl Fn(&TextSegment) -> bool) -> bool {
        let (before, mut inner) = (self.0.len(), false);
        self.0.retain_mut(|(_, key, node)| match node {
            Node::Value(value) => !without_effect(value),
            Node::Table(table) => {
                !without_effect(key) && {
                    inner |= table.drop(without_effect);
                    true
                }
            }
        });
        inner || self.0.len() < before
    }

    fn has(&self, key: &str) -> bool {
        self.0.iter().any(|(name, _, _)| name == key)
    }

    /// Merges another table over this one. With `replaces_kinds`, a section that selects its kind replaces the
    /// inherited section, and alternative keys replace each other.
    fn merge(&mut self, overriding: Self, replaces_kinds: bool) {
        if replaces_kinds {
            replaced_keys(|key| overriding.has(key)).for_each(|key| self.remove(key));
        }
        // A pair replaces single elements.
        self.0.retain(|(known, ..)| pair_element(known).is_none_or(|(pair, _)| !overriding.has(pair)));
        let known: HashMap<String, usize> =
            self.0.iter().enumerate().map(|(index, (known, ..))| (known.clone(), index)).collect();
        for (name, key, node) in overriding.0 {
            let Some(&index) = known.get(&name) else {
                self.0.push((name, key, node));
                continue;
            };
            match (&mut self.0[index], node) {
                ((_, head, Node::Table(inner)), Node::Table(more)) => {
                    if replaces_kinds && KIND_KEYS.iter().any(|kind| more.has(kind)) {
                        *inner = Table::default();
                        *head = key;
                    }
                    inner.merge(more, replaces_kinds);
                }
                (entry, node) => *entry = (name, key, node),
            }
        }
    }
}

/// Returns a value as written, except that tables in a list, which may have headers of their own, become inline tables.
fn to_inline(value: &Spanned<DeValue<'_>>, text: &str) -> String {
    let list = |items: Vec<String>, [open, close]: [&str; 2]| format!("{open}{}{close}", items.join(", "));
    match value.get_ref() {
        DeValue::Table(table) => {
            let pair = |(key, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
                format!("{} = {}", &text[key.span()], to_inline(value, text))
            };
            list(table.iter().map(pair).collect(), ["{", "}"])
        }
        DeValue::Array(items) if items.iter().any(|item| matches!(item.get_ref(), DeValue::Table(_))) => {
            list(items.iter().map(|item| to_inline(item, text)).collect(), ["[", "]"])
        }
        _ => text[value.span()].to_string(),
    }
}

/// The merged text with the origin of its pieces.
#[derive(Debug, Default)]
struct Merged {
    text: String,
    /// Positions in the text, in order, each with the layer and the position there.
    original_positions: Vec<(Range<usize>, usize, Range<usize>)>,
}

impl Merged {
    fn new(merged_table: &Table) -> Self {
        let mut merged = Self::default();
        merged.write(merged_table, &mut Vec::new());
        merged
    }

    fn write(&mut self, table: &Table, path: &mut Vec<TextSegment>) {
        for (_, key, node) in &table.0 {
            if let Node::Value(value) = node {
                self.put(key);
                self.text.push_str(" = ");
                self.put(value);
                self.text.push('\n');
            }
        }
        for (_, key, node) in &table.0 {
            if let Node::Table(inner) = node {
                path.push(key.clone());
                if inner.0.is_empty() || inner.0.iter().any(|(_, _, node)| matches!(node, Node::Value(_))) {
                    self.header(path);
                }
                self.write(inner, path);
                path.pop();
            }
        }
    }

    /// Writes the header of a section; its origin is the key that opened the section.
    fn header(&mut self, path: &[TextSegment]) {
        let names: Vec<&str> = path.iter().map(|key| key.text.as_str()).collect();
        let start = self.text.len();
        self.text.push_str(&format!("[{}]", names.join(".")));
        if let Some(key) = path.last() {
            self.original_positions.push((start..self.text.len(), key.layer, key.span.clone()));
        }
        self.text.push('\n');
    }

    fn put(&mut self, segment: &TextSegment) {
        let start = self.text.len();
        self.text.push_str(&segment.text);
        self.original_positions.push((start..self.text.len(), segment.layer, segment.span.clone()));
    }

    /// Assigns the problems of the merged text to the layers.
    fn assign_to_layers(&self, error: SceneError, layers: &[&Layer]) -> SceneError {
        let SceneError::Invalid { file, problems, .. } = error else { return error };
        let mut problems_by_layer: Vec<(usize, Vec<Problem>)> = Vec::new();
        // Problems without a position are assigned to the scene's own file.
        let default_layer = layers.iter().rposition(|layer| layer.file == file).unwrap_or(0);
        for mut problem in problems {
            let found = problem.span.take().and_then(|span| self.original_position(&span));
            let layer = found.as_ref().map_or(default_layer, |(layer, _)| *layer);
            problem.span = found.map(|(_, span)| span);
            match problems_by_layer.iter_mut().find(|(entry_layer, _)| *entry_layer == layer) {
                Some((_, problems)) => problems.push(problem),
                None => problems_by_layer.push((layer, vec![problem])),
            }
        }
        problems_by_layer.sort_by_key(|(layer, _)| *layer);
        let invalid = |(layer, problems): (usize, Vec<Problem>)| SceneError::Invalid {
            file: layers[layer].file.clone(),
            text: layers[layer].text.clone(),
            problems,
        };
        let mut errors: Vec<SceneError> = problems_by_layer.into_iter().map(invalid).collect();
        if errors.len() == 1 { errors.remove(0) } else { SceneError::Layers(errors) }
    }

    /// Returns the layer of a position in the merged text and the position there.
    fn original_position(&self, span: &Range<usize>) -> Option<(usize, Range<usize>)> {
        let inside = |entry: &&(Range<usize>, usize, Range<usize>)| entry.0.contains(&span.start);
        let (merged_span, layer, layer_span) = self.original_positions.iter().find(inside)?;
        if merged_span.len() != layer_span.len() {
            return Some((*layer, layer_span.clone()));
        }
        let to_original = |offset: usize| (layer_span.start + (offset - merged_span.start)).min(layer_span.end);
        Some((*layer, to_original(span.start)..to_original(span.end)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(file: &str, text: &str) -> Layer {
        Layer { file: file.to_string(), text: text.to_string() }
    }

    fn merged(files: &[&str], settings: &[&str]) -> toml::Table {
        let files: Vec<Layer> = files.iter().map(|text| layer("file.toml", text)).collect();
        let settings: Vec<Layer> = settings.iter().map(|text| layer("--set", text)).collect();
        let text = parse_layers(&files, &settings, |text, _| Ok(text.to_string())).expect("TOML");
        text.parse().unwrap_or_else(|error| panic!("{error}\n{text}"))
    }

    #[track_caller]
    fn assert_same(found: toml::Table, expected: &str) {
        assert_eq!(found, expected.parse().expect("TOML"));
    }

    #[test]
    fn keys_override_inherited_keys_except_name_and_description() {
        let base = "name = \"a\"\ndescription = \"b\"\nduration = \"1 ms\"\n[motor]\ntorque = \"1 N*m\"\n[object]\n";
        let derived = "extends = \"a.toml\"\nmotor.pulse = \"2 ms\"\n[motor.more]\nx = [1,\n 2]\n";
        assert_same(
            merged(
                &[base, derived],
                &["motor.torque = \"3 N*m\"", "contact.friction.mu_static = 0.1", "motor.pulse = 1"],
            ),
            "duration = \"1 ms\"\nobject = {}\nmotor = { torque = \"3 N*m\", pulse = 1, more = { x = [1, 2] } }\n\
             contact = { friction = { mu_static = 0.1 } }",
        );
    }

    #[test]
    fn sections_of_another_kind_replace_inherited_sections() {
        let base = "[spring]\ntype = \"constant\"\ntorque = 1\n[design]\nbase = 1\n[contact.friction]\nmu_static = 1\n";
        assert_same(
            merged(&[base, "[spring]\ntype = \"torsional\"\n[lengths]\nl11 = 2\n"], &["spring.stiffness = 3"]),
            "spring = { type = \"torsional\", stiffness = 3 }\nlengths = { l11 = 2 }\ncontact = { friction = { mu_static = 1 } }",
        );
        // All settings form one text; their order does not matter.
        assert_same(
            merged(&[base], &["spring.stiffness = 3", "spring.type = \"torsional\""]),
            "spring = { type = \"torsional\", stiffness = 3 }\ndesign = { base = 1 }\ncontact = { friction = { mu_static = 1 } }",
        );
    }

    #[test]
    fn quoted_keys_and_lists_of_tables_are_preserved() {
        assert_same(
            merged(&["\"a b\".'c.d' = 1\n[[list]]\nx = 1\n[[list]]\ny = {z = 2}\n", "q = '''\nlong'''"], &[]),
            "q = \"long\"\nlist = [{ x = 1 }, { y = { z = 2 } }]\n\"a b\" = { \"c.d\" = 1 }",
        );
    }

    #[test]
    fn problems_are_assigned_to_their_original_texts() {
        let files = [layer("base.toml", "a = 1\n[t]\nb = 22\n"), layer("own.toml", "[t]\nc = 333\n")];
        let settings = [layer("--set", "t.d = 4444")];
        let error = parse_layers::<()>(&files, &settings, |text, file| {
            let problem = |what: &str| {
                let start = text.find(what).expect("the text occurs");
                Problem {
                    span: Some(start..start + what.len()),
                    message: what.into(),
                    label: "".into(),
                    help: "".into(),
                }
            };
            let unlocated = Problem { span: None, ..problem("a") };
            let problems = vec![problem("22"), problem("[t]"), problem("c"), problem("333"), problem("444"), unlocated];
            Err(SceneError::Invalid { file: file.into(), text: text.into(), problems })
        })
        .expect_err("problems");
        let SceneError::Layers(parts) = &error else { panic!("{error}") };
        let found: Vec<Vec<Option<&str>>> = parts
            .iter()
            .map(|part| {
                let SceneError::Invalid { text, problems, .. } = part else { panic!("{part}") };
                problems.iter().map(|problem| problem.span.clone().map(|span| &text[span])).collect()
            })
            .collect();
        assert_eq!(found[0], [Some("22"), Some("t")]);
        assert_eq!(found[1], [Some("c"), Some("333"), None]);
        assert_eq!(found[2], [Some("444")]);
        let shown = error.to_string();
        for position in ["base.toml:3:5", "base.toml:2:2", "own.toml:2:1", "own.toml:2:5", "--set:1:7"] {
            assert!(shown.contains(position), "{position}: {shown}");
        }
    }
}
