//! Merges several texts into one scene: the scenes it extends, its own text, and single settings.
//!
//! The merged text contains every value verbatim and is parsed like any other scene. Problems are then reported at their
//! positions in the original texts. A scene is merged and completed as the texts of its values, without a change of notation.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::ops::Range;

use toml::de::{DeString, DeTable, DeValue};
use toml::{Spanned, Table, Value};

use super::check::NO_EFFECT;
use super::error::{Problem, entry_at, locate_problems, shortened};
use super::field::{PARAMETERS, key_text, parse_field, split_entries};
use super::keys::join;
use super::parameters::unknown;
use super::parse::{parse_any, syntax_problem};
use super::precedence::merge;
use super::section::{NO_SECTION, Section};
use super::{Scene, SceneError};

/// One of the texts of a scene, with its name for messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layer {
    pub file: String,
    pub text: String,
}

/// Keys that are not inherited.
const NOT_INHERITED: [&str; 2] = ["name", "description"];
/// The key whose value is the path of the extended scene.
pub const EXTENDS: &str = "extends";

/// Returns the path of the scene that a text extends, as written, and its position. `None` if it extends no scene, or
/// if the text is not TOML.
pub fn extended(text: &str) -> Option<(String, Range<usize>)> {
    extended_in(text, None)
}

/// Like [`extended`], for the scene in the table `section` of the text. If `section` is `None`, the whole text is the
/// scene.
pub fn extended_in(text: &str, section: Option<&str>) -> Option<(String, Range<usize>)> {
    // Most scenes extend none, and need not be parsed twice.
    let document = DeTable::parse(text.contains(EXTENDS).then_some(text)?).ok()?;
    let scene = scene_in(document.into_inner(), section)?;
    let value = scene.get(EXTENDS)?;
    Some((value.get_ref().as_str()?.to_string(), value.span()))
}

/// The scene that is a whole document or the table `section` of it. Positions remain those in the document.
fn scene_in<'t>(mut document: DeTable<'t>, section: Option<&str>) -> Option<DeTable<'t>> {
    let Some(section) = section else { return Some(document) };
    if let DeValue::Table(scene) = document.remove(section)?.into_inner() { Some(scene) } else { None }
}

/// Merges the texts of a scene of any kind, and parses, checks and resolves it. `files` begins with the extended scenes and
/// ends with the scene's own file; `settings` are lines of `key = value` that override the files.
///
/// # Errors
/// Returns all problems, each with its position in the original text.
pub fn parse_layers(files: &[Layer], settings: &[Layer]) -> Result<Scene, SceneError> {
    match single_text(files, settings) {
        Some(layer) => parse_any(&layer.text, &layer.file),
        None => parse_merged(files, settings, None, |_, _, scene| scene),
    }
}

/// Like [`parse_layers`], but parses the merged text with `parse`, which also receives the name of the scene's own file.
///
/// # Errors
/// See [`parse_layers`].
pub fn parse_layers_as<T>(
    files: &[Layer],
    settings: &[Layer],
    parse: impl Fn(&str, &str) -> Result<T, SceneError>,
) -> Result<T, SceneError> {
    match single_text(files, settings) {
        Some(layer) => parse(&layer.text, &layer.file),
        None => parse_merged(files, settings, None, |text, file, _| parse(text, file)),
    }
}

/// Like [`parse_layers_as`], for a scene that is the table `section` of the last file, such as a study.
///
/// # Errors
/// See [`parse_layers`].
pub fn parse_layers_of_section<T>(
    files: &[Layer],
    section: &str,
    parse: impl Fn(&str, &str) -> Result<T, SceneError>,
) -> Result<T, SceneError> {
    parse_merged(files, &[], Some(section), |text, file, _| parse(text, file))
}

/// Returns the text of a scene that needs no merging.
fn single_text<'a>(files: &'a [Layer], settings: &[Layer]) -> Option<&'a Layer> {
    if let [layer] = files { settings.is_empty().then_some(layer) } else { None }
}

/// Merges texts. `parse` receives the merged text, the name of the scene's own file, and the scene in this text.
fn parse_merged<T>(
    files: &[Layer],
    settings: &[Layer],
    section: Option<&str>,
    parse: impl Fn(&str, &str, Result<Scene, SceneError>) -> Result<T, SceneError>,
) -> Result<T, SceneError> {
    let Some(scene_file) = files.last() else { return parse("", "", parse_any("", "")) };
    let layers: Vec<&Layer> = files.iter().chain(settings).collect();
    let mut merged = Merged::new(&layers, files.len(), section)?;
    let mut text = merged.text();
    let mut scene = parse_any(&text, &scene_file.file);
    // Inherited keys that have no effect with the last text are removed: `motor.brake = "none"` also removes the keys
    // of the brake.
    let base_layers = &files[..files.len() - usize::from(settings.is_empty())];
    while let Err(error) = &scene {
        let base_problems = parse_layers(base_layers, &[]).map_or_else(|error| locate_problems(&error), |_| Vec::new());
        let is_new =
            |problem: &&Problem| base_problems.iter().all(|other| other.message != shortened(&problem.message));
        let without_effect = error.problems().iter().filter(|problem| problem.label == NO_EFFECT).filter(is_new);
        let places = merged.places(without_effect.map(|problem| problem.span.clone())).into_iter().flatten();
        let inherited: Vec<String> =
            places.filter(|place| place.layer < base_layers.len()).map(|place| place.path.join(".")).collect();
        if inherited.iter().filter(|path| remove(&mut merged.texts, path)).count() == 0 {
            break;
        }
        text = merged.text();
        scene = parse_any(&text, &scene_file.file);
    }
    parse(&text, &scene_file.file, scene).map_err(|error| merged.assign_to_layers(error, &layers))
}

/// The merged texts of all values, and the layers as written.
struct Merged<'t> {
    texts: Table,
    layers: Vec<DeTable<'t>>,
}

/// Checks that a setting names existing parameters: others would have no effect.
fn check_parameters(setting: &DeTable<'_>, scene: &Table, layer: &Layer) -> Result<(), SceneError> {
    let of_scene = scene.get(PARAMETERS).and_then(Value::as_table);
    let names: Vec<&str> = of_scene.into_iter().flat_map(|section| section.keys()).map(String::as_str).collect();
    let set = setting.get(PARAMETERS).and_then(|section| section.get_ref().as_table());
    let Some((name, _)) = set.into_iter().flatten().find(|(name, _)| !names.contains(&name.get_ref().as_ref())) else {
        return Ok(());
    };
    let (label, help) = unknown(name.get_ref(), &names);
    let message = format!("unknown parameter `{}`", name.get_ref().escape_debug());
    let problems = vec![Problem::new(Some(name.span()), message, label, help)];
    Err(SceneError::Invalid { file: layer.file.clone(), text: layer.text.clone(), problems })
}

/// A position in a layer, and the path of the key there.
struct Place {
    layer: usize,
    span: Range<usize>,
    path: Vec<String>,
}

impl<'t> Merged<'t> {
    /// Merges the layers; those up to `file_count` are files, and the others settings, which form one text. The scene of
    /// the last file is its table `section`, if there is one.
    fn new(layers: &[&'t Layer], file_count: usize, section: Option<&str>) -> Result<Self, SceneError> {
        let (mut merged, mut set) = (Merged { texts: Table::new(), layers: Vec::new() }, Table::new());
        for (index, layer) in layers.iter().enumerate() {
            let document = DeTable::parse(&layer.text).map_err(|error| SceneError::Invalid {
                file: layer.file.clone(),
                text: layer.text.clone(),
                problems: vec![syntax_problem(&error)],
            })?;
            let section = section.filter(|_| index + 1 == file_count);
            let document = scene_in(document.into_inner(), section).unwrap_or_default();
            let mut texts = texts(&document, &layer.text);
            if index >= file_count {
                check_parameters(&document, &merged.texts, layer)?;
                merge(&mut set, texts, false, Value::as_table_mut);
            } else {
                texts.remove(EXTENDS);
                if index > 0 {
                    NOT_INHERITED.into_iter().for_each(|key| _ = merged.texts.remove(key));
                }
                merge(&mut merged.texts, texts, true, Value::as_table_mut);
            }
            merged.layers.push(document);
        }
        merge(&mut merged.texts, set, true, Value::as_table_mut);
        Ok(merged)
    }

    /// The layer from which a value comes, the last one that has it; of a table, the first one of its values.
    fn origin(&self, path: &[String]) -> Option<usize> {
        match find(&self.texts, &path.join("."))? {
            Value::Table(inner) => {
                inner.keys().filter_map(|key| self.origin(&[path, std::slice::from_ref(key)].concat())).min()
            }
            _ => self.layers.iter().rposition(|layer| entry(layer, path).is_some_and(|(_, value)| !is_table(value))),
        }
    }

    fn text(&self) -> String {
        let mut text = String::new();
        write_texts(&mut text, &NO_SECTION, &self.texts, "");
        text
    }

    /// Returns the original places of positions in the merged text.
    fn places(&self, spans: impl Iterator<Item = Option<Range<usize>>>) -> Vec<Option<Place>> {
        let text = self.text();
        let merged = DeTable::parse(&text).map_or_else(|_| DeTable::default(), Spanned::into_inner);
        spans.map(|span| self.place(&span?, &merged)).collect()
    }

    fn place(&self, span: &Range<usize>, merged: &DeTable<'_>) -> Option<Place> {
        let (path, merged_key, merged_value) = entry_at(merged, span.start)?;
        // The position of a list of tables is that of its first header.
        let is_section = !find(&self.texts, &path.join("."))?.is_str();
        // An empty table has no origin. It may have replaced a value of an earlier layer.
        let last_with_path = || self.layers.iter().rposition(|layer| entry(layer, &path).is_some());
        let layer = self.origin(&path).or_else(last_with_path)?;
        let (key, value) = entry(&self.layers[layer], &path)?;
        // Values are verbatim: their parts have the same positions.
        let within = |original: Range<usize>, merged: &Range<usize>| {
            let start = original.start + span.start - merged.start;
            start..start + span.len()
        };
        let span = match is_section || merged_key.contains(&span.start) {
            true if !is_section && span.len() < merged_key.len() => within(key.span(), &merged_key),
            true => key.span(),
            false => within(value.span(), &merged_value),
        };
        Some(Place { layer, span, path })
    }

    /// Assigns the problems of the merged text to the layers.
    fn assign_to_layers(&self, error: SceneError, layers: &[&Layer]) -> SceneError {
        let SceneError::Invalid { file, problems, .. } = error else { return error };
        // Problems without a position are assigned to the scene's own file.
        let default_layer = layers.iter().rposition(|layer| layer.file == file).unwrap_or(0);
        let mut problems_by_layer: BTreeMap<usize, Vec<Problem>> = BTreeMap::new();
        let places = self.places(problems.iter().map(|problem| problem.span.clone()));
        for (mut problem, place) in problems.into_iter().zip(places) {
            let layer = place.as_ref().map_or(default_layer, |place| place.layer);
            problem.span = place.map(|place| place.span);
            problems_by_layer.entry(layer).or_default().push(problem);
        }
        let invalid = |(layer, mut problems): (usize, Vec<Problem>)| {
            problems.sort_by_key(|problem| problem.span.as_ref().map_or(usize::MAX, |span| span.start));
            SceneError::Invalid { file: layers[layer].file.clone(), text: layers[layer].text.clone(), problems }
        };
        let mut errors: Vec<SceneError> = problems_by_layer.into_iter().map(invalid).collect();
        if errors.len() == 1 { errors.remove(0) } else { SceneError::Layers(errors) }
    }
}

const EXAMPLE: &str = "write FIELD=VALUE, such as contact.friction.mu_static=0.6";

/// Parses `FIELD=VALUE` into a line of a scene; `origin` names it in messages. A value that is not TOML, such as `12
/// mm` or `torsional`, is read as a string without quotes.
///
/// # Errors
/// Returns a message if the field is invalid or the value is missing.
pub fn parse_setting(origin: &str, text: &str) -> Result<Layer, String> {
    let (field, value) = text.split_once('=').ok_or(format!("there is no `=`: {EXAMPLE}"))?;
    setting_from_parts(origin, field, value)
}

/// Like [`parse_setting`], with field and value as separate arguments.
///
/// # Errors
/// See [`parse_setting`].
pub fn setting_from_parts(origin: &str, field: &str, value: &str) -> Result<Layer, String> {
    let (field, value) = (field.trim(), value.trim());
    if field.is_empty() || value.is_empty() {
        return Err(format!("there is no {}: {EXAMPLE}", if field.is_empty() { "field" } else { "value" }));
    }
    // The key of an entry of a list is quoted.
    let keys: Vec<String> = parse_field(field)?.iter().map(|part| key_text(&part.key())).collect();
    let field = keys.join(".");
    let plain = format!("value = {value}");
    let value = match plain.parse::<toml::Table>() {
        Ok(found) if found.len() == 1 && !value.contains('\n') => value.to_string(),
        _ => toml::Value::from(value).to_string(),
    };
    Ok(Layer { file: origin.to_string(), text: format!("{field} = {value}") })
}

fn is_table(value: &Spanned<DeValue<'_>>) -> bool {
    value.get_ref().is_table()
}

/// Returns the key and the value at a path.
fn entry<'a, 't>(
    table: &'a DeTable<'t>,
    path: &[String],
) -> Option<(&'a Spanned<DeString<'t>>, &'a Spanned<DeValue<'t>>)> {
    let (first, rest) = path.split_first()?;
    let (key, value) = table.get_key_value(first.as_str())?;
    if rest.is_empty() { Some((key, value)) } else { entry(value.get_ref().as_table()?, rest) }
}

/// The texts of all values as written in `source`, by section.
pub fn texts(table: &DeTable<'_>, source: &str) -> Table {
    let text = |value: &Spanned<DeValue<'_>>| match value.get_ref() {
        DeValue::Table(inner) => Value::Table(texts(inner, source)),
        DeValue::Array(items) if !items.is_empty() && items.iter().all(is_table) => {
            let table =
                |item: &Spanned<DeValue<'_>>| item.get_ref().as_table().map(|inner| texts(inner, source).into());
            Value::Array(items.iter().filter_map(table).collect())
        }
        _ => inline(value, source).into(),
    };
    table.iter().map(|(key, value)| (key.get_ref().to_string(), text(value))).collect()
}

/// Returns a value as written, except that tables in a list, which may have headers of their own, become inline tables.
fn inline(value: &Spanned<DeValue<'_>>, source: &str) -> String {
    let list = |items: Vec<String>, [open, close]: [&str; 2]| format!("{open}{}{close}", items.join(", "));
    match value.get_ref() {
        DeValue::Table(table) => {
            let pairs =
                table.iter().map(|(key, value)| format!("{} = {}", key_text(key.get_ref()), inline(value, source)));
            list(pairs.collect(), ["{", "}"])
        }
        DeValue::Array(items) if items.iter().any(is_table) => {
            list(items.iter().map(|item| inline(item, source)).collect(), ["[", "]"])
        }
        _ => source[value.span()].to_string(),
    }
}

/// Writes texts of values with the sections below, in the order of a section of the schema.
pub(crate) fn write_texts(text: &mut String, order: &Section, values: &Table, path: &str) {
    let position = |name: &str| {
        let name = split_entries(name).map_or(name, |(list, _)| list);
        let sections = order.subsections().iter().chain(order.lists()).map(|(name, _)| *name);
        let mut all = order.keys().iter().map(|key| key.name).chain(sections);
        all.position(|known| known == name).unwrap_or(usize::MAX)
    };
    let mut entries: Vec<(&String, &Value)> = values.iter().collect();
    entries.sort_by_key(|(key, _)| position(key));
    // Writing to a string cannot fail.
    for (key, value) in &entries {
        value.as_str().into_iter().for_each(|value| _ = writeln!(text, "{} = {value}", key_text(key)));
    }
    for (key, value) in entries {
        let section = join(path, &key_text(key));
        for item in value.as_array().into_iter().flatten().filter_map(Value::as_table) {
            let _ = write!(text, "\n[[{section}]]\n");
            write_texts(text, order.subsection(key).unwrap_or(&NO_SECTION), item, &section);
        }
        let Value::Table(inner) = value else { continue };
        if inner.is_empty() || inner.values().any(Value::is_str) {
            let _ = write!(text, "\n[{section}]\n");
        }
        write_texts(text, order.subsection(key).unwrap_or(&NO_SECTION), inner, &section);
    }
}

/// Finds the text or the section at a path.
pub fn find<'a>(table: &'a Table, path: &str) -> Option<&'a Value> {
    match path.split_once('.') {
        None => table.get(path),
        Some((key, rest)) => find(table.get(key)?.as_table()?, rest),
    }
}

/// Removes a value; also removes its section if the section is then empty. Returns whether there was such a value.
pub fn remove(table: &mut Table, path: &str) -> bool {
    match path.split_once('.') {
        None => table.remove(path).is_some(),
        Some((key, rest)) => {
            let Some(Value::Table(inner)) = table.get_mut(key) else { return false };
            let was_there = remove(inner, rest);
            if was_there && inner.is_empty() {
                table.remove(key);
            }
            was_there
        }
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
        let text = parse_layers_as(&files, &settings, |text, _| Ok(text.to_string())).expect("TOML");
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
        let error = parse_layers_as::<()>(&files, &settings, |text, file| {
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
        assert_eq!(found[0], [Some("t"), Some("22")]);
        assert_eq!(found[1], [Some("c"), Some("333"), None]);
        assert_eq!(found[2], [Some("444")]);
        let shown = error.to_string();
        for position in ["base.toml:3:5", "base.toml:2:2", "own.toml:2:1", "own.toml:2:5", "--set:1:7"] {
            assert!(shown.contains(position), "{position}: {shown}");
        }
    }

    #[test]
    fn accepts_toml_values_and_unquoted_texts() {
        for (input, text) in [
            ("contact.friction.mu_static=0.6", "contact.friction.mu_static = 0.6"),
            (" design.base = 12 mm ", "design.base = \"12 mm\""),
            ("design.base=\"12 mm\"", "design.base = \"12 mm\""),
            ("spring.type=torsional", "spring.type = \"torsional\""),
            ("palm=false", "palm = false"),
            ("gravity=[\"0 m/s^2\", \"0 m/s^2\"]", "gravity = [\"0 m/s^2\", \"0 m/s^2\"]"),
            ("gravity[1]=1 g", "\"gravity[1]\" = \"1 g\""),
            ("object.centre[0]=\"1 mm\"", "object.\"centre[0]\" = \"1 mm\""),
            ("name=a = b", "name = \"a = b\""),
            ("discs.\"a b\".radius=\"1 mm\"", "discs.\"a b\".radius = \"1 mm\""),
            ("name=1\n[motor]", "name = \"\"\"\n1\n[motor]\"\"\""),
        ] {
            let found = parse_setting("--set", input).unwrap_or_else(|error| panic!("{input}: {error}"));
            let (found, text): (toml::Table, toml::Table) =
                (found.text.parse().expect("TOML"), text.replace("\n1", "1").parse().expect("TOML"));
            assert_eq!(found, text, "{input}");
        }
        for wrong in ["mu_static", "=1", "a=", "a b=1", "a..b=1", "[a]=1"] {
            assert!(parse_setting("--set", wrong).is_err(), "{wrong}");
        }
        assert!(setting_from_parts("set", "a=b", "1").is_err());
    }
}
