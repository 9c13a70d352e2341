//! Fields of a scene: found by their path, their values read as a scene reads them.

use serde_json::Value as Json;
use toml::Spanned;

use crate::scene::Problem;
use crate::scene::any::Any;
use crate::scene::keys::{child, is_table, unknown};
use crate::scene::kinds::{at, quantity, word};
use crate::table::{Kind, Value};
use crate::units::Dimension;

/// A field that a study varies.
#[derive(Clone, Debug)]
pub struct Field {
    /// Its place in a scene: `contact.friction.mu_static`.
    pub path: String,
    pub holds: Holds,
}

/// What a field holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Holds {
    Quantity(Dimension),
    Number,
    /// Of results alone.
    Percent,
    /// A whole number within bounds.
    Whole(i64, i64),
    Flag,
    Word(Vec<String>),
    Text,
    List(Box<Holds>),
}

/// One value of a field.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// As it stands in a scene file.
    pub text: String,
    /// As it stands in the results: in SI.
    pub value: Value,
}

/// Why a path names no field: message, remark and help.
pub type Unknown = (String, String, String);

impl Field {
    /// The field of that path in scenes of that schema.
    pub fn find(path: &str, schema: &Json) -> Result<Self, Unknown> {
        let mut here = schema;
        let mut parent = String::new();
        for name in path.split('.') {
            if !is_table(here) {
                return Err((
                    format!("`{path}` is no field of a scene: `{parent}` is a single value"),
                    "too long".to_string(),
                    format!("name the field itself: \"{parent}\""),
                ));
            }
            let Some(found) = child(here, name) else {
                let Problem { message, label, help, .. } = unknown(name, &parent, 0..0, here, schema);
                return Err((message, label, help));
            };
            here = found;
            parent = join(&parent, name);
        }
        match is_table(here) {
            true => {
                let keys = here["properties"].as_object().into_iter().flat_map(|keys| keys.keys());
                let fields: Vec<String> = keys.map(|key| format!("\"{path}.{key}\"")).collect();
                Err((
                    format!("`{path}` is a table of a scene, but a field is a single value"),
                    "a table".to_string(),
                    format!("name one of its fields: {}", fields.join(", ")),
                ))
            }
            false => Ok(Field { path: path.to_string(), holds: Holds::of(here) }),
        }
    }

    /// Name of its column: the path with the unit of its SI value.
    pub fn column(&self) -> String {
        match self.holds {
            Holds::Quantity(dimension) => format!("{}_{}", self.path, dimension.suffix()),
            _ => self.path.clone(),
        }
    }

    /// The field that has this column in scenes of that schema.
    pub fn of_column(column: &str, schema: &Json) -> Option<Self> {
        let paths = Dimension::ALL.into_iter().filter_map(|of| column.strip_suffix(of.suffix())?.strip_suffix('_'));
        let fields = paths.chain([column]).filter_map(|path| Field::find(path, schema).ok());
        fields.into_iter().find(|field| field.column() == column)
    }

    /// Reads a value given for the field in a study.
    pub fn read(&self, value: &Spanned<Any>) -> Result<Point, Vec<Problem>> {
        self.holds.read(&self.path, value).map(|value_si| Point { text: toml(value.get_ref()), value: value_si })
    }
}

impl Holds {
    /// Kind of a column of such values.
    pub fn kind(&self) -> Kind {
        match self {
            Holds::Quantity(_) | Holds::Number | Holds::Percent => Kind::Number,
            Holds::Whole(..) => Kind::Integer,
            Holds::Flag => Kind::Flag,
            Holds::Word(_) | Holds::Text | Holds::List(_) => Kind::Text,
        }
    }

    /// What the part of a schema says.
    pub fn of(schema: &Json) -> Self {
        if let Some(unit) = schema.get("x-units").and_then(|units| units.get(0)).and_then(Json::as_str)
            && let Some(dimension) = Dimension::ALL.into_iter().find(|of| of.units()[0].name == unit)
        {
            return Holds::Quantity(dimension);
        }
        if let Some(words) = schema.get("enum").and_then(Json::as_array) {
            return Holds::Word(words.iter().filter_map(Json::as_str).map(String::from).collect());
        }
        let bound = |key| schema.get(key).and_then(Json::as_i64);
        match (schema.get("type").and_then(Json::as_str), schema.get("items")) {
            (Some("array"), Some(items)) => Holds::List(Box::new(Holds::of(items))),
            (Some("number"), _) => Holds::Number,
            (Some("integer"), _) => {
                Holds::Whole(bound("minimum").unwrap_or(i64::MIN), bound("maximum").unwrap_or(i64::MAX))
            }
            (Some("boolean"), _) => Holds::Flag,
            _ => Holds::Text,
        }
    }

    /// Checks a value as far as the field alone says what it may be; `key` is for messages.
    pub fn read(&self, key: &str, value: &Spanned<Any>) -> Result<Value, Vec<Problem>> {
        let found = value.get_ref();
        let wrong = |wanted: &str, help: &str| {
            let name = match found {
                Any::Integer(integer) => integer.to_string(),
                Any::Float(number) if !number.is_finite() => number.to_string(),
                other => other.name().to_string(),
            };
            Err(vec![at(value, format!("`{key}` is {name}, but must be {wanted}"), wanted, help.to_string())])
        };
        match (self, found) {
            (Holds::Quantity(dimension), _) => quantity(key, value, *dimension).map(Value::Number),
            (Holds::Number | Holds::Percent, Any::Integer(integer)) => Ok(Value::Number(*integer as f64)),
            (Holds::Number | Holds::Percent, Any::Float(number)) if number.is_finite() => Ok(Value::Number(*number)),
            (Holds::Number | Holds::Percent, _) => {
                wrong("a plain number", "write a number such as 0.8 or 1e8, without quotes")
            }
            (Holds::Whole(least, most), Any::Integer(integer)) if (least..=most).contains(&integer) => {
                Ok(Value::Integer(*integer))
            }
            (Holds::Whole(least, most), _) => {
                let upto = if *most == i64::MAX { String::new() } else { format!(" to {most}") };
                wrong(&format!("a whole number from {least}{upto}"), "write it without point, exponent or quotes")
            }
            (Holds::Flag, Any::Flag(flag)) => Ok(Value::Flag(*flag)),
            (Holds::Flag, _) => wrong("true or false", "write true or false, without quotes"),
            (Holds::Word(words), _) => {
                let words: Vec<&str> = words.iter().map(String::as_str).collect();
                word(key, value, &words).map(|index| Value::from(words[index]))
            }
            (Holds::Text, Any::Text(text)) if !text.trim().is_empty() && !text.contains(char::is_control) => {
                Ok(Value::from(text.as_str()))
            }
            (Holds::Text, _) => wrong("a text of one line", "write a text in quotes"),
            (Holds::List(holds), Any::List(items)) => {
                let problems: Vec<Problem> =
                    items.iter().filter_map(|item| holds.read(key, item).err()).flatten().collect();
                if problems.is_empty() { Ok(Value::from(toml(found))) } else { Err(problems) }
            }
            (Holds::List(_), _) => wrong("a list", "write its values in brackets: [.., ..]"),
        }
    }
}

/// A value as TOML.
fn toml(value: &Any) -> String {
    match value {
        Any::Text(text) => toml::Value::from(text.as_str()).to_string(),
        Any::Integer(integer) => integer.to_string(),
        Any::Float(number) | Any::Si(number) => format!("{number:?}"),
        Any::Flag(flag) => flag.to_string(),
        Any::List(items) => {
            let items: Vec<String> = items.iter().map(|item| toml(item.get_ref())).collect();
            format!("[{}]", items.join(", "))
        }
        Any::Table(_) => "{}".to_string(),
    }
}

pub fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_string() } else { format!("{path}.{key}") }
}
