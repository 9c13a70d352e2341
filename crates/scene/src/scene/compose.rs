//! One scene from several texts: those it extends, its own, and single fields that are set besides.
//!
//! The texts are merged into one, in which every key and value stands to the letter, and which is read like any other. What is wrong
//! with it is then said of the text it came from.

use std::collections::HashMap;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::SceneError;
use super::check::NO_EFFECT;
use super::error::{Problem, shortened};
use super::keys::element;
use super::locate::located;
use super::over::{KINDS, replaced};
use super::text::{parse_any, syntax};

/// One of the texts of a scene, and what messages call it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    pub file: String,
    pub text: String,
}

/// Keys that belong to a file, and not to what extends it.
const OWN: [&str; 2] = ["name", "description"];
/// The key that names the scene a scene extends.
pub const EXTENDS: &str = "extends";

/// The scene that a text extends, as it is written, and where it says so. `None` also where the text is not TOML at all.
pub fn extended(text: &str) -> Option<(String, Range<usize>)> {
    let document = DeTable::parse(text).ok()?;
    let value = document.get_ref().get(EXTENDS)?;
    Some((value.get_ref().as_str()?.to_string(), value.span()))
}

/// Reads a scene of several texts with `parse`, which gets a text and the name of its file: first what is extended, last the scene's
/// own file; `settings` are lines of `key = value` that replace what the files say.
///
/// # Errors
/// What is wrong, each said of the text it stands in.
pub fn parse_layers<T>(
    files: &[Layer],
    settings: &[Layer],
    parse: impl Fn(&str, &str) -> Result<T, SceneError>,
) -> Result<T, SceneError> {
    let Some(own) = files.last() else { return parse("", "") };
    if files.len() == 1 && settings.is_empty() {
        return parse(&own.text, &own.file);
    }
    let mut whole = Table::default();
    for (index, layer) in files.iter().enumerate() {
        let mut over = read(layer, index)?;
        over.remove(EXTENDS);
        if index > 0 {
            OWN.into_iter().for_each(|key| whole.remove(key));
        }
        whole.merge(over, true);
    }
    let mut set = Table::default();
    for (index, layer) in settings.iter().enumerate() {
        set.merge(read(layer, files.len() + index)?, false);
    }
    whole.merge(set, true);
    let mut merged = Merged::of(&whole);
    // Keys that have an effect below the last text, and none beside it, give way: `motor.brake = "none"` takes the brake's keys along.
    let below = &files[..files.len() - usize::from(settings.is_empty())];
    while let Err(error) = parse_any(&merged.text, &own.file) {
        let before = parse_layers(below, &[], parse_any).map_or_else(|error| located(&error), |_| Vec::new());
        let is_new = |problem: &&Problem| before.iter().all(|other| other.message != shortened(&problem.message));
        let idle = error.problems().iter().filter(|problem| problem.label == NO_EFFECT).filter(is_new);
        let places: Vec<_> = idle.filter_map(|problem| merged.place(problem.span.as_ref()?)).collect();
        if !whole.drop(&|piece| piece.layer < below.len() && places.contains(&(piece.layer, piece.span.clone()))) {
            break;
        }
        merged = Merged::of(&whole);
    }
    let layers: Vec<&Layer> = files.iter().chain(settings).collect();
    parse(&merged.text, &own.file).map_err(|error| merged.of_layers(error, &layers))
}

fn read(layer: &Layer, index: usize) -> Result<Table, SceneError> {
    let document = DeTable::parse(&layer.text).map_err(|error| SceneError::Invalid {
        file: layer.file.clone(),
        text: layer.text.clone(),
        problems: vec![syntax(&error)],
    })?;
    Ok(Table::of(document.get_ref(), layer, index))
}

/// A text that stands in a layer.
#[derive(Clone, Debug)]
struct Piece {
    text: String,
    layer: usize,
    span: Range<usize>,
}

#[derive(Clone, Debug)]
enum Node {
    Value(Piece),
    Table(Table),
}

/// Keys in the order in which they were written first; the key's own text may be quoted.
#[derive(Clone, Debug, Default)]
struct Table(Vec<(String, Piece, Node)>);

impl Table {
    fn of(table: &DeTable<'_>, layer: &Layer, index: usize) -> Self {
        let piece = |text: String, span| Piece { text, layer: index, span };
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        let entry = |(key, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
            let name: &std::borrow::Cow<'_, str> = key.get_ref();
            let node = match value.get_ref() {
                DeValue::Table(inner) => Node::Table(Table::of(inner, layer, index)),
                _ => Node::Value(piece(written(value, &layer.text), value.span())),
            };
            (name.to_string(), piece(layer.text[key.span()].to_string(), key.span()), node)
        };
        Self(entries.into_iter().map(entry).collect())
    }

    fn remove(&mut self, key: &str) {
        self.0.retain(|(name, _, _)| name != key);
    }

    /// Drops all values and tables that are `idle`, and says whether there are any.
    fn drop(&mut self, idle: &impl Fn(&Piece) -> bool) -> bool {
        let (before, mut inner) = (self.0.len(), false);
        self.0.retain_mut(|(_, key, node)| match node {
            Node::Value(value) => !idle(value),
            Node::Table(table) => {
                !idle(key) && {
                    inner |= table.drop(idle);
                    true
                }
            }
        });
        inner || self.0.len() < before
    }

    fn has(&self, key: &str) -> bool {
        self.0.iter().any(|(name, _, _)| name == key)
    }

    /// Puts another table over this one; `anew`: a section that says its kind replaces the one of before, and what says a thing in another
    /// way that of before.
    fn merge(&mut self, over: Self, anew: bool) {
        if anew {
            replaced(|key| over.has(key)).for_each(|key| self.remove(key));
        }
        // A pair replaces what is set of single elements.
        self.0.retain(|(known, ..)| element(known).is_none_or(|(pair, _)| !over.has(pair)));
        let known: HashMap<String, usize> =
            self.0.iter().enumerate().map(|(place, (known, ..))| (known.clone(), place)).collect();
        for (name, key, node) in over.0 {
            let Some(&place) = known.get(&name) else {
                self.0.push((name, key, node));
                continue;
            };
            match (&mut self.0[place], node) {
                ((_, head, Node::Table(inner)), Node::Table(more)) => {
                    if anew && KINDS.iter().any(|kind| more.has(kind)) {
                        *inner = Table::default();
                        *head = key;
                    }
                    inner.merge(more, anew);
                }
                (entry, node) => *entry = (name, key, node),
            }
        }
    }
}

/// A value as it is written; tables in a list, which may have headers of their own, in one line.
fn written(value: &Spanned<DeValue<'_>>, text: &str) -> String {
    let list = |items: Vec<String>, [open, close]: [&str; 2]| format!("{open}{}{close}", items.join(", "));
    match value.get_ref() {
        DeValue::Table(table) => {
            let pair = |(key, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
                format!("{} = {}", &text[key.span()], written(value, text))
            };
            list(table.iter().map(pair).collect(), ["{", "}"])
        }
        DeValue::Array(items) if items.iter().any(|item| matches!(item.get_ref(), DeValue::Table(_))) => {
            list(items.iter().map(|item| written(item, text)).collect(), ["[", "]"])
        }
        _ => text[value.span()].to_string(),
    }
}

/// The merged text, and where its parts come from.
#[derive(Debug, Default)]
struct Merged {
    text: String,
    /// Places in the text, in its order; layers and the places there.
    places: Vec<(Range<usize>, usize, Range<usize>)>,
}

impl Merged {
    fn of(whole: &Table) -> Self {
        let mut merged = Self::default();
        merged.write(whole, &mut Vec::new());
        merged
    }

    fn write(&mut self, table: &Table, path: &mut Vec<Piece>) {
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

    /// The header of a section: all of it stands for the key that opened it.
    fn header(&mut self, path: &[Piece]) {
        let names: Vec<&str> = path.iter().map(|key| key.text.as_str()).collect();
        let start = self.text.len();
        self.text.push_str(&format!("[{}]", names.join(".")));
        if let Some(key) = path.last() {
            self.places.push((start..self.text.len(), key.layer, key.span.clone()));
        }
        self.text.push('\n');
    }

    fn put(&mut self, piece: &Piece) {
        let start = self.text.len();
        self.text.push_str(&piece.text);
        self.places.push((start..self.text.len(), piece.layer, piece.span.clone()));
    }

    /// Says of every layer what is wrong with it.
    fn of_layers(&self, error: SceneError, layers: &[&Layer]) -> SceneError {
        let SceneError::Invalid { file, problems, .. } = error else { return error };
        let mut parts: Vec<(usize, Vec<Problem>)> = Vec::new();
        // What is about no place is said of the scene's own file.
        let own = layers.iter().rposition(|layer| layer.file == file).unwrap_or(0);
        for mut problem in problems {
            let found = problem.span.take().and_then(|span| self.place(&span));
            let layer = found.as_ref().map_or(own, |(layer, _)| *layer);
            problem.span = found.map(|(_, span)| span);
            match parts.iter_mut().find(|(of, _)| *of == layer) {
                Some((_, problems)) => problems.push(problem),
                None => parts.push((layer, vec![problem])),
            }
        }
        parts.sort_by_key(|(layer, _)| *layer);
        let invalid = |(layer, problems): (usize, Vec<Problem>)| SceneError::Invalid {
            file: layers[layer].file.clone(),
            text: layers[layer].text.clone(),
            problems,
        };
        let mut errors: Vec<SceneError> = parts.into_iter().map(invalid).collect();
        if errors.len() == 1 { errors.remove(0) } else { SceneError::Layers(errors) }
    }

    /// Where a place of the merged text stands: layer and bytes there.
    fn place(&self, span: &Range<usize>) -> Option<(usize, Range<usize>)> {
        let inside = |place: &&(Range<usize>, usize, Range<usize>)| place.0.contains(&span.start);
        let (here, layer, there) = self.places.iter().find(inside)?;
        if here.len() != there.len() {
            return Some((*layer, there.clone()));
        }
        let at = |offset: usize| (there.start + (offset - here.start)).min(there.end);
        Some((*layer, at(span.start)..at(span.end)))
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
    fn same(found: toml::Table, expected: &str) {
        assert_eq!(found, expected.parse().expect("TOML"));
    }

    #[test]
    fn fields_replace_fields_and_what_belongs_to_a_file_stays_with_it() {
        let base = "name = \"a\"\ndescription = \"b\"\nduration = \"1 ms\"\n[motor]\ntorque = \"1 N*m\"\n[object]\n";
        let own = "extends = \"a.toml\"\nmotor.pulse = \"2 ms\"\n[motor.more]\nx = [1,\n 2]\n";
        same(
            merged(&[base, own], &["motor.torque = \"3 N*m\"", "contact.friction.mu_static = 0.1", "motor.pulse = 1"]),
            "duration = \"1 ms\"\nobject = {}\nmotor = { torque = \"3 N*m\", pulse = 1, more = { x = [1, 2] } }\n\
             contact = { friction = { mu_static = 0.1 } }",
        );
    }

    #[test]
    fn another_kind_of_thing_brings_its_own_keys() {
        let base = "[spring]\ntype = \"constant\"\ntorque = 1\n[design]\nbase = 1\n[contact.friction]\nmu_static = 1\n";
        same(
            merged(&[base, "[spring]\ntype = \"torsional\"\n[lengths]\nl11 = 2\n"], &["spring.stiffness = 3"]),
            "spring = { type = \"torsional\", stiffness = 3 }\nlengths = { l11 = 2 }\ncontact = { friction = { mu_static = 1 } }",
        );
        // What is set is one text, in whatever order.
        same(
            merged(&[base], &["spring.stiffness = 3", "spring.type = \"torsional\""]),
            "spring = { type = \"torsional\", stiffness = 3 }\ndesign = { base = 1 }\ncontact = { friction = { mu_static = 1 } }",
        );
    }

    #[test]
    fn odd_keys_and_lists_of_tables_stay_as_they_are() {
        same(
            merged(&["\"a b\".'c.d' = 1\n[[list]]\nx = 1\n[[list]]\ny = {z = 2}\n", "q = '''\nlong'''"], &[]),
            "q = \"long\"\nlist = [{ x = 1 }, { y = { z = 2 } }]\n\"a b\" = { \"c.d\" = 1 }",
        );
    }

    #[test]
    fn what_is_wrong_is_said_of_the_text_it_stands_in() {
        let files = [layer("base.toml", "a = 1\n[t]\nb = 22\n"), layer("own.toml", "[t]\nc = 333\n")];
        let settings = [layer("--set", "t.d = 4444")];
        let error = parse_layers::<()>(&files, &settings, |text, file| {
            let problem = |what: &str| {
                let start = text.find(what).expect("there");
                Problem {
                    span: Some(start..start + what.len()),
                    message: what.into(),
                    label: "".into(),
                    help: "".into(),
                }
            };
            let nowhere = Problem { span: None, ..problem("a") };
            let problems = vec![problem("22"), problem("[t]"), problem("c"), problem("333"), problem("444"), nowhere];
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
        let said = error.to_string();
        for place in ["base.toml:3:5", "base.toml:2:2", "own.toml:2:1", "own.toml:2:5", "--set:1:7"] {
            assert!(said.contains(place), "{place}: {said}");
        }
    }
}
