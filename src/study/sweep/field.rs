//! Fields of a scene: lookup by path, and parsing of their values.

use serde_json::Value as Json;
use toml::Spanned;

use crate::scene::Problem;
use crate::scene::keys::{child_schema, is_table, unknown_key};
use crate::scene::toml_value::TomlValue;
use crate::scene::value_kinds::{problem_at, read_keyword, read_quantity};
use crate::table::{Kind, Value};
use crate::units::Dimension;

/// A scene field that a study varies.
#[derive(Clone, Debug)]
pub struct Field {
    /// Path in a scene: `contact.friction.mu_static`.
    pub path: String,
    pub field_type: FieldType,
}

/// Type of the values of a field.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldType {
    Quantity(Dimension),
    Number,
    /// A percentage; only in results.
    Percent,
    /// An integer within bounds.
    Integer(i64, i64),
    Flag,
    Choice(Vec<String>),
    Text,
    List(Box<FieldType>),
}

/// One value of a field.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisValue {
    /// TOML text in a scene file.
    pub text: String,
    /// Value in the results, in SI units.
    pub value: Value,
}

/// Error for a path that is not a field: message, label and help.
pub type UnknownField = (String, String, String);

impl Field {
    /// Finds a field by its path in scenes with this schema.
    ///
    /// # Errors
    /// Returns an error if the path is not a field.
    pub fn find(path: &str, schema: &Json) -> Result<Self, UnknownField> {
        let mut node = schema;
        let mut parent = String::new();
        for name in path.split('.') {
            if !is_table(node) {
                return Err((
                    format!("`{path}` is not a field of a scene: `{parent}` is a single value"),
                    "too many parts".to_string(),
                    format!("name the field itself: \"{parent}\""),
                ));
            }
            let Some(field_schema) = child_schema(node, name) else {
                let Problem { message, label, help, .. } = unknown_key(name, &parent, 0..0, node, schema);
                return Err((message, label, help));
            };
            node = field_schema;
            parent = join(&parent, name);
        }
        match is_table(node) {
            true => {
                let keys = node["properties"].as_object().into_iter().flat_map(|keys| keys.keys());
                let fields: Vec<String> = keys.map(|key| format!("\"{path}.{key}\"")).collect();
                Err((
                    format!("`{path}` is a table of a scene, but a field is a single value"),
                    "a table".to_string(),
                    format!("name one of its fields: {}", fields.join(", ")),
                ))
            }
            false => Ok(Field { path: path.to_string(), field_type: FieldType::from_schema(node) }),
        }
    }

    /// Name of the result column: the path with the unit of the SI value.
    pub fn column(&self) -> String {
        match self.field_type {
            FieldType::Quantity(dimension) => format!("{}_{}", self.path, dimension.suffix()),
            _ => self.path.clone(),
        }
    }

    /// Finds the field with this result column in scenes with this schema.
    pub fn from_column(column: &str, schema: &Json) -> Option<Self> {
        let paths = Dimension::ALL
            .into_iter()
            .filter_map(|dimension| column.strip_suffix(dimension.suffix())?.strip_suffix('_'));
        let fields = paths.chain([column]).filter_map(|path| Field::find(path, schema).ok());
        fields.into_iter().find(|field| field.column() == column)
    }

    /// Reads a value of the field from a study file.
    pub fn read(&self, value: &Spanned<TomlValue>) -> Result<AxisValue, Vec<Problem>> {
        self.field_type
            .read(&self.path, value)
            .map(|value_si| AxisValue { text: to_toml(value.get_ref()), value: value_si })
    }
}

impl FieldType {
    /// Kind of a result column with these values.
    pub fn column_kind(&self) -> Kind {
        match self {
            FieldType::Quantity(_) | FieldType::Number | FieldType::Percent => Kind::Number,
            FieldType::Integer(..) => Kind::Integer,
            FieldType::Flag => Kind::Flag,
            FieldType::Choice(_) | FieldType::Text | FieldType::List(_) => Kind::Text,
        }
    }

    /// Type described by a node of a schema.
    pub fn from_schema(schema: &Json) -> Self {
        if let Some(unit) = schema.get("x-units").and_then(|units| units.get(0)).and_then(Json::as_str)
            && let Some(dimension) = Dimension::ALL.into_iter().find(|dimension| dimension.units()[0].name == unit)
        {
            return FieldType::Quantity(dimension);
        }
        if let Some(keywords) = schema.get("enum").and_then(Json::as_array) {
            return FieldType::Choice(keywords.iter().filter_map(Json::as_str).map(String::from).collect());
        }
        let bound = |key| schema.get(key).and_then(Json::as_i64);
        match (schema.get("type").and_then(Json::as_str), schema.get("items")) {
            (Some("array"), Some(items)) => FieldType::List(Box::new(FieldType::from_schema(items))),
            (Some("number"), _) => FieldType::Number,
            (Some("integer"), _) => {
                FieldType::Integer(bound("minimum").unwrap_or(i64::MIN), bound("maximum").unwrap_or(i64::MAX))
            }
            (Some("boolean"), _) => FieldType::Flag,
            _ => FieldType::Text,
        }
    }

    /// Parses a value and checks it against this type alone; `key` appears in messages.
    pub fn read(&self, key: &str, value: &Spanned<TomlValue>) -> Result<Value, Vec<Problem>> {
        let toml_value = value.get_ref();
        let mismatch = |required: &str, help: &str| {
            let name = match toml_value {
                TomlValue::Integer(integer) => integer.to_string(),
                TomlValue::Float(number) if !number.is_finite() => number.to_string(),
                other => other.name().to_string(),
            };
            Err(vec![problem_at(
                value,
                format!("`{key}` is {name}, but must be {required}"),
                required,
                help.to_string(),
            )])
        };
        match (self, toml_value) {
            (FieldType::Quantity(dimension), _) => read_quantity(key, value, *dimension).map(Value::Number),
            (FieldType::Number | FieldType::Percent, TomlValue::Integer(integer)) => Ok(Value::Number(*integer as f64)),
            (FieldType::Number | FieldType::Percent, TomlValue::Float(number)) if number.is_finite() => {
                Ok(Value::Number(*number))
            }
            (FieldType::Number | FieldType::Percent, _) => {
                mismatch("a plain number", "write a number such as 0.8 or 1e8, without quotes")
            }
            (FieldType::Integer(min, max), TomlValue::Integer(integer)) if (min..=max).contains(&integer) => {
                Ok(Value::Integer(*integer))
            }
            (FieldType::Integer(min, max), _) => {
                let upper = if *max == i64::MAX { String::new() } else { format!(" to {max}") };
                mismatch(
                    &format!("a whole number from {min}{upper}"),
                    "write it without a decimal point, an exponent or quotes",
                )
            }
            (FieldType::Flag, TomlValue::Flag(flag)) => Ok(Value::Flag(*flag)),
            (FieldType::Flag, _) => mismatch("true or false", "write true or false, without quotes"),
            (FieldType::Choice(keywords), _) => {
                let keywords: Vec<&str> = keywords.iter().map(String::as_str).collect();
                read_keyword(key, value, &keywords).map(|index| Value::from(keywords[index]))
            }
            (FieldType::Text, TomlValue::Text(text)) if !text.trim().is_empty() && !text.contains(char::is_control) => {
                Ok(Value::from(text.as_str()))
            }
            (FieldType::Text, _) => mismatch("a single line of text", "write a string in quotes"),
            (FieldType::List(item_type), TomlValue::List(items)) => {
                let problems: Vec<Problem> =
                    items.iter().filter_map(|item| item_type.read(key, item).err()).flatten().collect();
                if problems.is_empty() { Ok(Value::from(to_toml(toml_value))) } else { Err(problems) }
            }
            (FieldType::List(_), _) => mismatch("a list", "write the values in brackets: [.., ..]"),
        }
    }
}

/// Formats a value as TOML.
fn to_toml(value: &TomlValue) -> String {
    match value {
        TomlValue::Text(text) => toml::Value::from(text.as_str()).to_string(),
        TomlValue::Integer(integer) => integer.to_string(),
        TomlValue::Float(number) | TomlValue::Si(number) => format!("{number:?}"),
        TomlValue::Flag(flag) => flag.to_string(),
        TomlValue::List(items) => {
            let items: Vec<String> = items.iter().map(|item| to_toml(item.get_ref())).collect();
            format!("[{}]", items.join(", "))
        }
        TomlValue::Table(_) => "{}".to_string(),
    }
}

/// Path of a key in the table at `path`.
pub fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_string() } else { format!("{path}.{key}") }
}
