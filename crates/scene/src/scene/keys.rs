//! Detection of unknown keys: walks the document along the JSON Schema, so that all of them are reported at once.
//! Suggestions for mistyped keys and keywords, and for features that phalanx does not support.

use std::ops::Range;

use serde_json::{Map, Value};
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use super::error::Problem;
use super::field::{no_such_entry, split_entries};
use super::precedence::merge;
use crate::limits::MAX_PROBLEMS;

/// Schema of the keys that a scene may have, and those of scenes of other kinds.
pub struct KeySchemas<'a> {
    pub kind: &'a str,
    pub schema: &'a Value,
    /// Returns the other kinds with their schemas. It is called only for a key that the present kind does not have,
    /// because building each schema takes as long as reading a scene.
    pub other_kinds: &'a dyn Fn() -> Vec<(&'a str, &'a Value)>,
}

/// Removes and reports all unknown keys, all tables where a value is expected, and all values where a table is
/// expected.
pub fn remove_unknown(document: &mut DeTable<'_>, schemas: &KeySchemas) -> Vec<Problem> {
    let mut problems = Vec::new();
    walk(document, schemas.schema, schemas, &[], &mut problems);
    problems
}

/// Checks the table at a path.
fn walk(table: &mut DeTable<'_>, schema: &Value, schemas: &KeySchemas, path: &[&str], problems: &mut Vec<Problem>) {
    move_entries(table, schema, path, problems);
    for (key, mut value) in std::mem::take(table) {
        // The number of problems is limited: the search for similar keys takes time for each.
        if problems.len() >= MAX_PROBLEMS {
            return;
        }
        let name = key.get_ref().as_ref();
        let names = [path, &[name]].concat();
        let key_path = names.join(".");
        let Some(property) = child_schema(schema, name) else {
            let has_key = |(_, other): &(&str, &Value)| {
                names.iter().try_fold(*other, |at, name| child_schema(at, name)).is_some()
            };
            problems.push(match (schemas.other_kinds)().into_iter().find(has_key) {
                Some((other, _)) => other_kind_problem(&key_path, key.span(), schemas.kind, other),
                None => unknown_key(name, &path.join("."), key.span(), schema, schemas.schema),
            });
            continue;
        };
        let span = value.span();
        let items = property.get("items").filter(|items| is_table(items));
        let problem = match (value.get_mut(), is_table(property), items) {
            (DeValue::Table(inner), true, _) => {
                walk(inner, property, schemas, &names, problems);
                None
            }
            (DeValue::Array(tables), false, Some(items)) => {
                for inner in tables.iter_mut() {
                    if let DeValue::Table(inner) = inner.get_mut() {
                        walk(inner, items, schemas, &names, problems);
                    }
                }
                None
            }
            (DeValue::Table(_), false, Some(_)) => {
                let message = format!("`{key_path}` is a single table, but must be a list of tables");
                let help = format!("write its header with two pairs of brackets: [[{key_path}]]");
                Some(Problem::new(Some(key.span()), message, "expected a list of tables", help))
            }
            (DeValue::Table(_), false, None) => {
                let message = format!("`{key_path}` is a table, but must be a single value");
                Some(Problem::new(Some(key.span()), message, "expected a single value", format!("write {name} = ...")))
            }
            (_, true, _) => {
                let message = format!("`{key_path}` is a single value, but must be a table");
                let help = format!("begin a section with [{key_path}] and put its keys below");
                Some(Problem::new(Some(span), message, "expected a table", help))
            }
            _ => None,
        };
        match problem {
            Some(problem) => problems.push(problem),
            None => _ = table.insert(key, value),
        }
    }
}

/// Problem for a key that only scenes of another kind have.
fn other_kind_problem(path: &str, span: Range<usize>, kind: &str, other_kind: &str) -> Problem {
    let message = format!("`{path}` belongs to scenes of kind \"{other_kind}\", but this one is of kind \"{kind}\"");
    let help = format!("remove it, or write kind = \"{other_kind}\" at the top of the file");
    Problem::new(Some(span), message, "for another kind of scene", help)
}

/// Returns the problem of an unknown key, with a suggestion.
pub fn unknown_key(name: &str, path: &str, span: Range<usize>, schema: &Value, root: &Value) -> Problem {
    let message = format!("unknown key `{}` {}", name.escape_debug(), location(path));
    // Most unsupported features are those of fingers.
    let is_finger_word = child_schema(root, "joints").is_some() && !is_of_mechanism(path, name);
    if let Some((reason, instead)) = find_unsupported(path, name).filter(|_| !is_finger_word) {
        return Problem::new(Some(span), format!("{message}: {reason}"), "not supported by phalanx", instead);
    }
    let names: Vec<&str> = properties(schema).into_iter().flat_map(Map::keys).map(String::as_str).collect();
    let mut other_locations = Vec::new();
    find_tables(name, root, "", &mut other_locations);
    other_locations.sort_by_key(|path| path.matches('.').count());
    let label = match (closest_match(name, &names), other_locations.first()) {
        (_, Some(other)) => format!("this key belongs {}", location(other)),
        (Some(near), None) => format!("did you mean `{near}`?"),
        (None, None) => "not a key of a scene".to_string(),
    };
    Problem::new(Some(span), message, label, format!("keys {}: {}", location(path), names.join(", ")))
}

/// Collects the paths of all tables with a key `name`.
fn find_tables(name: &str, schema: &Value, path: &str, found: &mut Vec<String>) {
    if let Some(each) = named_tables_schema(schema) {
        find_tables(name, each, &join(path, "NAME"), found);
    }
    let Some(properties) = properties(schema) else { return };
    if properties.contains_key(name) {
        found.push(path.to_string());
    }
    for (key, property) in properties {
        find_tables(name, property, &join(path, key), found);
    }
}

/// Returns the schema of a key in the table of `schema`, or of an entry of a list such as `points[0][1]`.
pub fn child_schema<'a>(schema: &'a Value, name: &str) -> Option<&'a Value> {
    let property = |name: &str| properties(schema)?.get(name);
    let entry_schema = || {
        let (list, entries) = split_entries(name)?;
        entries.iter().try_fold(property(list)?, |list, _| list.get("items"))
    };
    property(name).or_else(entry_schema).or(named_tables_schema(schema))
}

/// Moves values whose keys name an entry of a list, such as `"points[0][1]"`, into the list. An element of a pair that is not
/// written stays: the pair may have a default.
fn move_entries(table: &mut DeTable<'_>, schema: &Value, path: &[&str], problems: &mut Vec<Problem>) {
    let is_entry = |key: &&Spanned<DeString<'_>>| split_entries(key.get_ref()).is_some();
    // In the order of keys, a list comes before its own entries.
    let keys: Vec<_> = table.keys().filter(is_entry).cloned().collect();
    for key in keys {
        let Some((name, entries)) = split_entries(key.get_ref()) else { continue };
        let (name_path, list) = (join(&path.join("."), name), child_schema(schema, name));
        let count = list.map(|list| list["maxItems"].as_u64());
        let message = match (table.contains_key(name), count) {
            // An unknown key is reported as such.
            (false, None) => continue,
            (false, Some(Some(count))) if entries.len() == 1 => match entries[0] < count as usize {
                true => continue,
                false => Err(no_such_entry(&name_path, entries[0], count as usize)),
            },
            (false, _) if list.is_some_and(|list| list.get("items").is_none()) => {
                Err(format!("`{name_path}` is not a list"))
            }
            (false, _) => Err(format!("`{name_path}` is not given in this scene, so it has no entries")),
            (true, _) => {
                let value = table.remove(key.get_ref().as_ref());
                let list = table.get_mut(name).zip(value);
                list.map_or(Ok(()), |(list, value)| set_entry(list, &name_path, &entries, value))
            }
        };
        if let Err(message) = message {
            table.remove(key.get_ref().as_ref());
            let help = format!("give an entry that exists, or the whole list: {name_path} = [..]");
            problems.push(Problem::new(Some(key.span()), message, "no such entry", help));
        }
    }
}

/// Sets an entry of a list; the keys of a table replace single ones of a table there.
fn set_entry<'t>(
    list: &mut Spanned<DeValue<'t>>,
    path: &str,
    entries: &[usize],
    mut value: Spanned<DeValue<'t>>,
) -> Result<(), String> {
    fn as_table<'v, 't>(value: &'v mut Spanned<DeValue<'t>>) -> Option<&'v mut DeTable<'t>> {
        if let DeValue::Table(table) = value.get_mut() { Some(table) } else { None }
    }
    let Some((entry, rest)) = entries.split_first() else {
        match (as_table(list), as_table(&mut value)) {
            (Some(inner), Some(more)) => merge(inner, std::mem::take(more), true, as_table),
            _ => *list = value,
        }
        return Ok(());
    };
    let DeValue::Array(items) = list.get_mut() else { return Err(format!("`{path}` is not a list")) };
    let count = items.len();
    let item = items.get_mut(*entry).ok_or_else(|| no_such_entry(path, *entry, count))?;
    set_entry(item, &format!("{path}[{entry}]"), rest, value)
}

pub fn is_table(schema: &Value) -> bool {
    properties(schema).is_some() || named_tables_schema(schema).is_some()
}

/// Whether the values are lists of tables.
pub fn has_tables(schema: &Value) -> bool {
    schema.get("items").is_some_and(is_table)
}

fn properties(schema: &Value) -> Option<&Map<String, Value>> {
    schema.get("properties")?.as_object()
}

/// Returns the schema of all values of a table whose keys are names chosen by the user.
pub(crate) fn named_tables_schema(schema: &Value) -> Option<&Value> {
    schema.get("additionalProperties").filter(|each| each.is_object())
}

fn location(path: &str) -> String {
    match path {
        "" => "at the top level".to_string(),
        path => format!("in [{path}]"),
    }
}

/// Whether a text can be a name chosen by the user. Names are used in topics, keys and columns.
pub(crate) fn is_name(text: &str) -> bool {
    let is_valid = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    text.starts_with(|first: char| first.is_ascii_alphabetic()) && text.chars().all(is_valid)
}

/// Path of a key of the table at a path.
pub fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_string() } else { format!("{path}.{key}") }
}

/// Unsupported features, one per line: the section they are expected in (empty: any), their keys, the reason, and the
/// alternative. The lines that hold for mechanisms come first.
const UNSUPPORTED: &str = "\
engine|construction|\
    joint coordinates have been removed, because their error was 2,900 times larger; every body moves freely and every joint is \
    a constraint, as with \"maximal\"|remove the line
outlines|rectangle square triangle circle|an outline is a disc, a capsule, a box, a polygon, an ellipse or a half plane|\
    write type = \"box\" with size = [width, height], type = \"polygon\" with vertices, or type = \"disc\" with a radius
joints|pin hinge slider ball fixed weld rigid|a joint is revolute or prismatic|\
    write type = \"revolute\" for a pin, \"prismatic\" for a slider; join rigidly connected parts to one body
|tendon tendons cable cables rope pulley pulleys winch|a finger has no tendons|\
    describe the finger as kind = \"mechanism\", with [tendons.NAME]
|l31 l32 t32 phi32 q31 q32 phalanges n_phalanges third_phalanx medial middle intermediate links n_links joints n_joints|\
    a finger has two phalanges, l21 and t22|leave further ones out; t22 and phi22 shape the distal phalanx
|fingers n_fingers thumb|a scene has one finger, or two that face each other|choose by kind = \"finger\" or kind = \"gripper\"
|shape box square rectangle cuboid polygon vertices ellipse cylinder sphere sides corners diameter|every object is a disc|\
    give its radius; replace a rounded body by a disc with its curvature at the contact
|ground pivot pivots ground_pivot ground_pivots ground_joint ground_joints ground_link base_link base_joint anchor l0 l01|\
    l11 and l21 share one ground joint|place the object by the base of [design] or [lengths]; palm_width is the distance of two fingers
|control controller pid pd kp ki kd gain gains servo setpoint target target_angle position position_control velocity_control feedback|\
    a motor has a torque over time and no controller|set [motor] profile = \"ramp\", \"reversal\" or \"table\"; to hold a position, use the brake of a gripper
contact|law model normal type restitution hunt-crossley hunt_crossley kelvin-voigt hertz|\
    the normal law is stiffness × depth^exponent with a damper that engages over `transition`|\
    set these four, or [contact.materials] for Hertz; there are two friction laws: contact.friction.law = \"regularised\" or \"bristle\"";

/// Number of lines of [`UNSUPPORTED`] that hold for mechanisms.
const MECHANISM_LINES: usize = 3;

/// Whether a mechanism has no such key, by one of its own lines.
fn is_of_mechanism(path: &str, word: &str) -> bool {
    find_among(UNSUPPORTED.lines().take(MECHANISM_LINES), path, word).is_some()
}

/// Returns why phalanx does not support a key or value in a section, and the alternative.
pub(crate) fn find_unsupported(path: &str, word: &str) -> Option<(&'static str, &'static str)> {
    find_among(UNSUPPORTED.lines(), path, word)
}

fn find_among(
    mut lines: impl Iterator<Item = &'static str>,
    path: &str,
    word: &str,
) -> Option<(&'static str, &'static str)> {
    let word = word.to_lowercase();
    lines.find_map(|line| {
        let [section, unsupported_words, reason, instead] = line.split('|').collect::<Vec<_>>().try_into().ok()?;
        let is_expected_here = section.is_empty() || path.split('.').any(|part| part == section);
        (is_expected_here && unsupported_words.split(' ').any(|known| known == word)).then_some((reason, instead))
    })
}

/// Returns the candidate nearest to `word`, if it is similar enough to suggest.
pub fn closest_match<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let word = word.to_lowercase();
    // Among candidates that contain the word, the shortest is preferred: `pfp_n` before `static_pfp_n`.
    let containing = candidates.iter().filter(|candidate| word.len() > 2 && candidate.to_lowercase().contains(&word));
    if let Some(containing_candidate) =
        containing.min_by_key(|candidate| (!candidate.to_lowercase().starts_with(&word), candidate.len()))
    {
        return Some(containing_candidate);
    }
    candidates
        .iter()
        .map(|candidate| (strsim::damerau_levenshtein(&word, &candidate.to_lowercase()), *candidate))
        .filter(|(distance, candidate)| *distance <= 1 + candidate.len().max(word.len()) / 4)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggests_similar_words_only() {
        let keys = ["radius", "centre", "present"];
        assert_eq!(closest_match("raduis", &keys), Some("radius"));
        assert_eq!(closest_match("center", &keys), Some("centre"));
        assert_eq!(closest_match("Radius", &keys), Some("radius"));
        assert_eq!(closest_match("sine", &["ramp", "half-sine"]), Some("half-sine"));
        let columns = ["static_pfp_n", "peak_pfp_n", "pfp_n", "pfp_share"];
        assert_eq!(
            ["pfp", "pfp_N", "static"].map(|word| closest_match(word, &columns)),
            ["pfp_n", "pfp_n", "static_pfp_n"].map(Some)
        );
        assert_eq!(closest_match("colour", &keys), None);
        assert_eq!(closest_match("", &keys), None);
    }
}
