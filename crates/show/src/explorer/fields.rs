//! Every field of a scene: its type, allowed values and current value.

use serde_json::{Value, json};

use crate::scene::schema::schema_for;
use crate::scene::{Keyword, PARAMETERS, Scene, show_written};
use crate::units::{Dimension, parse, split_quantity};

/// Sections of design variables, in the order in which a designer usually needs them. In a mechanism, a section is
/// followed by the names of its parts.
const DESIGN: [&str; 8] =
    [PARAMETERS, "design", "motor", "spring", "object", "contact.friction", "actuators", "springs"];

/// Sections without effect on the page, which runs the analytic model only and writes no log.
const UNUSED: [&str; 3] = ["engine", "validate", "log"];

/// Largest number of entries of a list that are fields of their own, each with a slider. A longer list is one text.
const MAX_ENTRIES: usize = 8;

/// Describes all fields, whether or not they have a value.
pub fn fields(scene: &Scene) -> Value {
    let text = show_written(scene);
    let resolved: toml::Table = text.parse().unwrap_or_default();
    let written: toml::Table = scene.source.parse().unwrap_or_default();
    let field_order = field_order(&text);
    let mut found = Vec::new();
    let top = Table {
        schema: schema_for(scene.kind),
        path: "",
        group: &[],
        resolved: Some(&resolved),
        written: Some(&written),
    };
    collect(&top, &mut found);
    // Entries of a list are in the line of the list.
    let line = |path: &str| field_order.iter().position(|known| path.split('[').next() == Some(known.as_str()));
    found.sort_by_cached_key(|field| field["path"].as_str().and_then(line).unwrap_or(field_order.len()));
    let is_in = |field: &Value, section: &str| field["section"] == section || field["group"][0] == section;
    let mut design: Vec<&Value> = DESIGN
        .iter()
        .flat_map(|section| found.iter().filter(move |field| is_in(field, section) && is_adjustable(field)))
        .map(|field| &field["path"])
        .collect();
    // Entries of lists, such as the times of a motion, are less often varied than gains.
    design.sort_by_key(|path| path.as_str().is_some_and(|path| path.ends_with(']')));
    json!({
        "kind": scene.kind.keyword(),
        "name": &scene.name,
        "description": &scene.description,
        "design": design,
        "fields": found,
    })
}

/// Paths of the fields in the order of a TOML text with one field per line.
fn field_order(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut section = String::new();
    for line in text.lines() {
        if let Some(name) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            section = format!("{name}.");
        } else if let Some((key, _)) = line.split_once(" = ").filter(|_| !line.starts_with('#')) {
            found.push(format!("{section}{key}"));
        }
    }
    found
}

/// Whether the field has a numerical value that can be adjusted.
fn is_adjustable(field: &Value) -> bool {
    matches!(field["kind"].as_str(), Some("quantity" | "number" | "integer")) && !field["value"].is_null()
}

/// A table of a scene.
struct Table<'a> {
    schema: &'a Value,
    path: &'a str,
    /// Where the page lists the fields of a part with a name, such as a body: its section and its name.
    group: &'a [&'a str],
    /// The table in the resolved scene and in its text.
    resolved: Option<&'a toml::Table>,
    written: Option<&'a toml::Table>,
}

/// Collects the fields of a table and of those in it.
fn collect(table: &Table, found: &mut Vec<Value>) {
    let Table { schema, path, group, resolved, written } = *table;
    let join = |key: &str| if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
    let properties = schema.get("properties").and_then(Value::as_object).into_iter().flatten();
    let mut names: Vec<(&String, &Value)> = properties.collect();
    // Tables named by the user, such as discs: one for each name in the scene.
    let free_schema = schema.get("additionalProperties").filter(|schema_value| schema_value.is_object());
    let known = names.len();
    if let (Some(item_schema), Some(resolved)) = (free_schema, resolved) {
        names.extend(resolved.keys().map(|key| (key, item_schema)));
    }
    for (index, (key, property)) in names.into_iter().enumerate() {
        let [value, written_value] = [resolved, written].map(|table| table.and_then(|table| table.get(key)));
        if path.is_empty() && UNUSED.contains(&key.as_str()) {
            continue;
        }
        if is_table(property) {
            let [resolved, written] = [value, written_value].map(|value| value.and_then(toml::Value::as_table));
            let named = [path, key.as_str()];
            // Parts of a part, such as the outlines of a body, are listed with it.
            let group = if group.is_empty() && index >= known { &named } else { group };
            collect(&Table { schema: property, path: &join(key), group, resolved, written }, found);
        } else if !(path.is_empty() && ["name", "description", "kind", "extends"].contains(&key.as_str())) {
            let place = Place { section: path, group, key, path: &join(key) };
            match value.and_then(toml::Value::as_array).filter(|list| has_sliders(group, list)) {
                Some(list) => found.extend(entries(&place, property, list, written_value)),
                None => found.push(field(&place, property, value, written_value.is_some())),
            }
        }
    }
}

/// Whether the entries of a list are fields: numbers or quantities of a named part.
fn has_sliders(group: &[&str], list: &[toml::Value]) -> bool {
    let is_number = |value: &toml::Value| number_and_unit(Some(value)).0.is_some();
    !group.is_empty() && (1..=MAX_ENTRIES).contains(&list.len()) && list.iter().all(is_number)
}

/// The entries of a list, as fields.
fn entries(place: &Place, property: &Value, list: &[toml::Value], written: Option<&toml::Value>) -> Vec<Value> {
    let mut schema = property.get("items").cloned().unwrap_or_default();
    if let (Some(schema), Some(about)) = (schema.as_object_mut(), property.get("description")) {
        schema.entry("description").or_insert_with(|| about.clone());
    }
    let entry = |(index, value): (usize, &toml::Value)| {
        let [key, path] = [place.key, place.path].map(|name| format!("{name}[{index}]"));
        let place = Place { key: &key, path: &path, ..*place };
        field(&place, &schema, Some(value), written.is_some())
    };
    list.iter().enumerate().map(entry).collect()
}

fn is_table(property: &Value) -> bool {
    property.get("properties").is_some() || property.get("additionalProperties").is_some_and(Value::is_object)
}

/// Where a field is in the scene.
#[derive(Clone, Copy)]
struct Place<'a> {
    section: &'a str,
    group: &'a [&'a str],
    key: &'a str,
    path: &'a str,
}

fn field(place: &Place, property: &Value, value_in_file: Option<&toml::Value>, given: bool) -> Value {
    let Place { section, group, key, path } = *place;
    let (value, unit) = number_and_unit(value_in_file);
    let [first, last] = bounds(property, &unit);
    // As entered in the page: a string without its quotes.
    let text = value_in_file.map(|value| value.as_str().map_or_else(|| value.to_string(), str::to_string));
    json!({
        "path": path,
        "section": section,
        "group": group,
        "key": key,
        "kind": kind(property, value.map(|_| unit.as_str())),
        "value": value,
        "unit": unit,
        "units": property.get("x-units"),
        "text": text.unwrap_or_default(),
        "words": property.get("enum"),
        "low": first,
        "high": last,
        "about": property.get("description"),
        "given": given,
    })
}

/// Lower and upper bound of the allowed range, in `unit`. Exclusive bounds are treated as inclusive, which suffices for
/// a slider.
fn bounds(property: &Value, unit: &str) -> [Option<f64>; 2] {
    let bound = |name: &str| property.get(name).and_then(Value::as_f64);
    let first = property.pointer("/x-units/0").and_then(Value::as_str);
    let dimension = Dimension::ALL.into_iter().find(|candidate| Some(candidate.units()[0].name) == first);
    let unit_si = dimension.and_then(|dimension| parse(&format!("1 {unit}"), dimension).ok());
    [["minimum", "exclusiveMinimum"], ["maximum", "exclusiveMaximum"]].map(|[inclusive, exclusive]| {
        let display_bound = bound(inclusive).or(bound(exclusive));
        // Bounds of quantities are in SI units.
        let bound_si = bound(&format!("x-{inclusive}")).or(bound(&format!("x-{exclusive}")));
        display_bound.or(bound_si.zip(unit_si).map(|(end, unit_si)| end / unit_si))
    })
}

/// Returns a number and its unit as written.
fn number_and_unit(value: Option<&toml::Value>) -> (Option<f64>, String) {
    match value {
        Some(toml::Value::String(text)) => {
            let (number, unit) = split_quantity(text);
            number.parse().map_or((None, String::new()), |number| (Some(number), unit.to_string()))
        }
        Some(value) => (value.as_float().or(value.as_integer().map(|number| number as f64)), String::new()),
        None => (None, String::new()),
    }
}

/// Kind of a field; that of a parameter follows from its value, a number with a unit or without.
fn kind(property: &Value, unit_of_number: Option<&str>) -> &'static str {
    match property.get("type").and_then(Value::as_str) {
        _ if property.get("x-parameter").is_some() => match unit_of_number {
            Some("") => "number",
            Some(_) => "quantity",
            None => "text",
        },
        _ if property.get("x-units").is_some() => "quantity",
        _ if property.get("enum").is_some() => "word",
        Some("array") => "list",
        Some("number") => "number",
        Some("integer") => "integer",
        Some("boolean") => "flag",
        _ => "text",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parse_any;

    /// The sliders of parameters come first. Expressions are texts without a slider.
    #[test]
    fn parameters_are_fields_with_the_kinds_of_their_values() {
        let text = include_str!("../../../../scenes/experiment-95.toml")
            .replace("base = \"15.5 mm\"", "base = \"= reach / ratio\"");
        let head = "parameters = { reach = \"31 mm\", ratio = 2, half = \"= reach / 2\" }\n";
        let scene = parse_any(&(head.to_string() + &text), "test.toml").unwrap_or_else(|error| panic!("{error}"));
        let found = fields(&scene);
        let design: Vec<&str> = found["design"].as_array().expect("a list").iter().filter_map(Value::as_str).collect();
        assert_eq!(design[..3], ["parameters.ratio", "parameters.reach", "design.l21_fraction"]);
        let field = |path: &str| {
            let all = found["fields"].as_array().expect("a list");
            let field = all.iter().find(|field| field["path"] == path).unwrap_or_else(|| panic!("{path}"));
            ["kind", "value", "unit", "text"].map(|key| field[key].clone())
        };
        assert_eq!(field("parameters.reach"), [json!("quantity"), json!(31.0), json!("mm"), json!("31 mm")]);
        assert_eq!(field("parameters.ratio"), [json!("number"), json!(2.0), json!(""), json!("2")]);
        assert_eq!(field("parameters.half"), [json!("text"), Value::Null, json!(""), json!("= reach / 2")]);
        assert_eq!(field("design.base"), [json!("quantity"), Value::Null, json!(""), json!("= reach / ratio")]);
    }
}
