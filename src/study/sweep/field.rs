//! Fields of a scene: lookup by path, and parsing of their values.

use serde_json::Value as Json;
use toml::Spanned;

use crate::scene::Problem;
use crate::scene::keys::{child_schema, is_table, unknown_key};
use crate::scene::toml_value::TomlValue;
pub use crate::scene::value::ValueType as FieldType;
use crate::scene::value::problem_at;
use crate::table::{Kind, Value};
use crate::units::Dimension;

/// A scene field that a study varies.
#[derive(Clone, Debug)]
pub struct Field {
    /// Path in a scene: `contact.friction.mu_static`.
    pub path: String,
    pub field_type: FieldType,
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
pub(crate) type UnknownField = (String, String, String);

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
    pub(crate) fn from_column(column: &str, schema: &Json) -> Option<Self> {
        let paths = Dimension::ALL
            .into_iter()
            .filter_map(|dimension| column.strip_suffix(dimension.suffix())?.strip_suffix('_'));
        let fields = paths.chain([column]).filter_map(|path| Field::find(path, schema).ok());
        fields.into_iter().find(|field| field.column() == column)
    }

    /// Reads a value of the field from a study file.
    ///
    /// # Errors
    /// Returns the problems of a value of another type.
    pub fn read(&self, value: &Spanned<TomlValue>) -> Result<AxisValue, Vec<Problem>> {
        let value_si = match self.field_type.read(&self.path, value)? {
            toml::Value::Float(number) => Value::Number(number),
            toml::Value::Integer(integer) => Value::Integer(integer),
            toml::Value::Boolean(flag) => Value::Flag(flag),
            toml::Value::String(text) if text.contains(char::is_control) => {
                let message = format!("`{}` is several lines, but must be a single line of text", self.path);
                let help = "write it in one line".to_string();
                return Err(vec![problem_at(value, message, "a single line of text", help)]);
            }
            toml::Value::String(text) => Value::from(text.as_str()),
            _ => Value::from(to_toml(value.get_ref())),
        };
        Ok(AxisValue { text: to_toml(value.get_ref()), value: value_si })
    }
}

/// Kind of a result column with values of this type.
pub(crate) fn column_kind(field_type: &FieldType) -> Kind {
    match field_type {
        FieldType::Quantity(_) | FieldType::Number | FieldType::Percent => Kind::Number,
        FieldType::Integer(..) => Kind::Integer,
        FieldType::Flag => Kind::Flag,
        FieldType::Choice(_) | FieldType::Text | FieldType::List(..) => Kind::Text,
    }
}

/// Formats a value as TOML.
fn to_toml(value: &TomlValue) -> String {
    match value {
        TomlValue::Text(text) => toml::Value::from(text.as_str()).to_string(),
        TomlValue::Integer(integer) => integer.to_string(),
        TomlValue::Float(number) => format!("{number:?}"),
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
