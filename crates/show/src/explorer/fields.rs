//! Every field of a scene: its type, allowed values and current value.

use serde_json::{Value, json};

use crate::scene::schema::schema_for;
use crate::scene::{Keyword, PARAMETERS, Scene, show_written};
use crate::units::{Dimension, parse, split_quantity};

/// Sections of design variables, in the order in which a designer usually needs them.
const DESIGN: [&str; 6] = [PARAMETERS, "design", "motor", "spring", "object", "contact.friction"];

/// Sections without effect on the page, which runs the analytic model only and writes no log.
const UNUSED: [&str; 3] = ["engine", "validate", "log"];

/// Describes all fields, with and without a value.
pub fn fields(scene: &Scene) -> Value {
    let text = show_written(scene);
    let resolved: toml::Table = text.parse().unwrap_or_default();
    let written: toml::Table = scene.source.parse().unwrap_or_default();
    let field_order = field_order(&text);
    let mut found = Vec::new();
    collect(schema_for(scene.kind), "", Some(&resolved), Some(&written), &mut found);
    let position_in_text =
        |field: &Value| field_order.iter().position(|path| field["path"] == **path).unwrap_or(field_order.len());
    found.sort_by_cached_key(position_in_text);
    let design: Vec<&Value> = DESIGN
        .iter()
        .flat_map(|section| found.iter().filter(move |field| field["section"] == *section && is_adjustable(field)))
        .map(|field| &field["path"])
        .collect();
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

/// Collects the fields of a part of the schema, with their values in the resolved scene (`resolved`) and in its text
/// (`written`).
fn collect(
    schema: &Value,
    path: &str,
    resolved: Option<&toml::Table>,
    written: Option<&toml::Table>,
    found: &mut Vec<Value>,
) {
    let join = |key: &str| if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
    let properties = schema.get("properties").and_then(Value::as_object).into_iter().flatten();
    let mut names: Vec<(&String, &Value)> = properties.collect();
    // Tables named by the user, such as discs: one for each name in the scene.
    let free_schema = schema.get("additionalProperties").filter(|schema_value| schema_value.is_object());
    if let (Some(item_schema), Some(resolved)) = (free_schema, resolved) {
        names.extend(resolved.keys().map(|key| (key, item_schema)));
    }
    for (key, property) in names {
        let [value, written_value] = [resolved, written].map(|table| table.and_then(|table| table.get(key)));
        if path.is_empty() && UNUSED.contains(&key.as_str()) {
            continue;
        }
        if is_table(property) {
            let [value, written_value] = [value, written_value].map(|value| value.and_then(toml::Value::as_table));
            collect(property, &join(key), value, written_value, found);
        } else if !(path.is_empty() && ["name", "description", "kind", "extends"].contains(&key.as_str())) {
            found.push(field(path, key, &join(key), property, value, written_value.is_some()));
        }
    }
}

fn is_table(property: &Value) -> bool {
    property.get("properties").is_some() || property.get("additionalProperties").is_some_and(Value::is_object)
}

fn field(
    section: &str,
    key: &str,
    path: &str,
    property: &Value,
    value_in_file: Option<&toml::Value>,
    given: bool,
) -> Value {
    let (value, unit) = number_and_unit(value_in_file);
    let [first, last] = bounds(property, &unit);
    // As entered in the page: a string without its quotes.
    let text = value_in_file.map(|value| value.as_str().map_or_else(|| value.to_string(), str::to_string));
    json!({
        "path": path,
        "section": section,
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
