//! Sections of the schema with their keys, parsed once for reading: types, defaults, limits and conditions of the values.

use std::sync::OnceLock;

use serde_json::Value;
use toml::Table;

use super::keys::{has_tables, is_table, named_tables_schema};
use super::value::ValueType;
use crate::units::{format, number};

/// A section of the schema. Its keys and subsections are in the order of the schema.
#[derive(Debug)]
pub struct Section {
    pub schema: &'static Value,
    /// Parsed on first use.
    contents: OnceLock<Contents>,
}

#[derive(Debug, Default)]
struct Contents {
    keys: Vec<Key>,
    subsections: Vec<(&'static str, Section)>,
    /// Sections of lists of tables.
    lists: Vec<(&'static str, Section)>,
    named: Option<Box<Section>>,
}

/// A key whose value is not a table.
#[derive(Debug)]
pub struct Key {
    pub name: &'static str,
    /// Name of the field in the settings.
    pub field: &'static str,
    pub schema: &'static Value,
    pub value_type: ValueType,
    /// Default value in SI units; `None` without a default.
    pub default: Option<toml::Value>,
    /// The key that decides whether this key has an effect, and the values of that key for which it does.
    pub condition: Option<(&'static str, Vec<&'static str>)>,
    /// Keywords of JSON Schema with the limits of the value in SI units.
    limits: Vec<(&'static str, f64)>,
}

/// A section without keys.
pub static NO_SECTION: Section = Section::new(&Value::Null);

impl Section {
    pub(crate) const fn new(schema: &'static Value) -> Self {
        Section { schema, contents: OnceLock::new() }
    }

    fn contents(&self) -> &Contents {
        self.contents.get_or_init(|| {
            let mut all: Vec<_> = self.schema["properties"].as_object().into_iter().flatten().collect();
            all.sort_by_cached_key(|(_, property)| property["x-order"].as_u64());
            let named = named_tables_schema(self.schema).map(|each| Box::new(Section::new(each)));
            let mut contents = Contents { named, ..Contents::default() };
            for (name, property) in all {
                if is_table(property) {
                    contents.subsections.push((name, Section::new(property)));
                } else if has_tables(property) {
                    contents.lists.push((name, Section::new(&property["items"])));
                } else {
                    contents.keys.push(Key::new(name, property));
                }
            }
            contents
        })
    }

    /// Keys whose values are not tables.
    pub fn keys(&self) -> &[Key] {
        &self.contents().keys
    }

    pub fn key(&self, name: &str) -> Option<&Key> {
        self.keys().iter().find(|key| key.name == name)
    }

    pub fn subsections(&self) -> &[(&'static str, Section)] {
        &self.contents().subsections
    }

    /// Sections of lists of tables, such as `[[contacts]]`.
    pub fn lists(&self) -> &[(&'static str, Section)] {
        &self.contents().lists
    }

    /// The section that each name has, if the keys of this section are names chosen by the user.
    pub fn named(&self) -> Option<&Self> {
        self.contents().named.as_deref()
    }

    pub fn subsection(&self, name: &str) -> Option<&Self> {
        let all = self.subsections().iter().chain(self.lists());
        let subsection = all.into_iter().find(|(known, _)| *known == name).map(|(_, subsection)| subsection);
        subsection.or(self.named())
    }

    /// Returns `Ok` if a key has an effect in this section with these values. Otherwise, returns the choice that
    /// prevents it: the key, its value, and the values for which there would be an effect.
    pub fn effect<'a>(&self, key: &'a Key, values: &Table) -> Result<(), (&'static str, String, &'a [&'static str])> {
        let Some((choice, allowed)) = &key.condition else { return Ok(()) };
        let has_effect = self.key(choice).is_none_or(|key| self.effect(key, values).is_ok());
        let chosen = match values.get(*choice).filter(|_| has_effect) {
            Some(toml::Value::String(keyword)) => keyword.clone(),
            Some(other) => other.to_string(),
            None => String::new(),
        };
        if allowed.contains(&chosen.as_str()) { Ok(()) } else { Err((choice, chosen, allowed)) }
    }
}

/// Keywords of limits in JSON Schema, which has them for numbers only, and those for quantities.
const LIMITS: [(&str, &str); 4] = [
    ("minimum", "x-minimum"),
    ("exclusiveMinimum", "x-exclusiveMinimum"),
    ("maximum", "x-maximum"),
    ("exclusiveMaximum", "x-exclusiveMaximum"),
];

impl Key {
    fn new(name: &'static str, schema: &'static Value) -> Self {
        let value_type = ValueType::from_schema(schema);
        let condition = schema.get("x-with").and_then(Value::as_str).and_then(|with| with.split_once(" = "));
        // The limits of a list are those of its items.
        let limited = if matches!(value_type, ValueType::List(..)) { &schema["items"] } else { schema };
        let limit = |(keyword, of_quantity)| {
            let limit = limited.get(keyword).or_else(|| limited.get(of_quantity))?;
            Some((keyword, limit.as_f64()?))
        };
        let limits = LIMITS.into_iter().filter_map(limit);
        Key {
            name,
            field: schema["x-field"].as_str().unwrap_or_default(),
            schema,
            default: schema.get("default").and_then(|default| value_type.json_to_si(default)),
            condition: condition.map(|(choice, values)| (choice, values.split('|').collect())),
            limits: limits.collect(),
            value_type,
        }
    }

    /// Whether a value, or each item of a list, is within the limits of the key.
    pub fn allows(&self, value: &toml::Value) -> bool {
        if let Some(items) = value.as_array() {
            return items.iter().all(|item| self.allows(item));
        }
        let Some(number) = value.as_float() else { return true };
        self.limits.iter().all(|(keyword, limit)| match *keyword {
            "minimum" => number >= *limit,
            "exclusiveMinimum" => number > *limit,
            "maximum" => number <= *limit,
            _ => number < *limit,
        })
    }

    /// Describes the allowed numbers: "above 0", "from 0 to 1".
    pub(crate) fn limits(&self) -> String {
        let of_number = if let ValueType::List(item, _) = &self.value_type { item } else { &self.value_type };
        let text = |limit: f64| match of_number {
            ValueType::Quantity(dimension) if limit != 0.0 => format(limit, *dimension),
            _ => number(limit),
        };
        match self.limits[..] {
            [] => "any finite number".to_string(),
            [("minimum", low)] => format!("at least {}", text(low)),
            [(_, low)] => format!("above {}", text(low)),
            [("minimum", low), (_, high)] => format!("from {} to {}", text(low), text(high)),
            [("exclusiveMinimum", low), ("maximum", high)] => format!("above {} and up to {}", text(low), text(high)),
            [(_, low), (_, high), ..] => format!("between {} and {}, both excluded", text(low), text(high)),
        }
    }

    /// Describes the allowed values.
    pub(crate) fn allowed(&self) -> String {
        match &self.value_type {
            ValueType::Choice(keywords) => {
                keywords.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(" or ")
            }
            ValueType::Integer(min, i64::MAX) => format!("a whole number from {min}"),
            ValueType::Integer(min, max) => format!("a whole number from {min} to {max}"),
            ValueType::Flag => "true or false".to_string(),
            ValueType::Text => "a string".to_string(),
            ValueType::Quantity(dimension) if self.limits.is_empty() => dimension.name().to_string(),
            ValueType::OneOf(dimensions) => {
                let names: Vec<&str> = dimensions.iter().map(|dimension| dimension.name()).collect();
                let limits = if self.limits.is_empty() { String::new() } else { format!(", {}", self.limits()) };
                names.join(" or ") + &limits
            }
            ValueType::Quantity(dimension) => format!("{} {}", dimension.name(), self.limits()),
            ValueType::Number | ValueType::Percent if self.limits.is_empty() => self.limits(),
            ValueType::Number | ValueType::Percent => format!("a number {}", self.limits()),
            ValueType::List(item, _) => match **item {
                ValueType::Quantity(dimension) if self.limits.is_empty() => dimension.name().to_string(),
                ValueType::Quantity(dimension) => format!("{} {}", dimension.name(), self.limits()),
                _ => "a list".to_string(),
            },
        }
    }

    /// Name of a value with its SI unit.
    pub(crate) fn column(&self) -> String {
        match self.value_type.suffix() {
            Some(suffix) if !self.field.ends_with(&format!("_{suffix}")) => format!("{}_{suffix}", self.field),
            Some(_) => self.field.to_string(),
            None => self.name.to_string(),
        }
    }
}
