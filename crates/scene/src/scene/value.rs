//! Values of settings: their types by the schema, and reading them from a file.

use serde_json::Value as Json;
use toml::de::DeValue;
use toml::{Spanned, Value};

use super::error::Problem;
use super::keys::{closest_match, find_unsupported};
use super::parameters::Parameters;
use super::written::{number, problem_at, type_name};
use crate::units::{self, Dimension, Measured, is_expression, number as decimal};

/// Type of the values of a key.
#[derive(Clone, Debug, PartialEq)]
pub enum ValueType {
    Quantity(Dimension),
    /// A quantity of one of these dimensions.
    OneOf(Vec<Dimension>),
    /// A plain number: a ratio, or a value in SI units if its unit has a fractional power.
    Number,
    /// A percentage; only in results of sweeps.
    Percent,
    /// A whole number within limits.
    Integer(i64, i64),
    Flag,
    Choice(Vec<String>),
    /// Non-empty text.
    Text,
    /// A list, perhaps of a fixed length.
    List(Box<ValueType>, Option<u64>),
}

type Read<T> = Result<T, Vec<Problem>>;

impl ValueType {
    /// Returns the type that a schema describes.
    pub fn from_schema(schema: &Json) -> Self {
        match dimensions(schema)[..] {
            [] => {}
            [dimension] => return ValueType::Quantity(dimension),
            ref dimensions => return ValueType::OneOf(dimensions.to_vec()),
        }
        if let Some(keywords) = schema["enum"].as_array() {
            return ValueType::Choice(keywords.iter().filter_map(Json::as_str).map(String::from).collect());
        }
        let limit = |key| schema.get(key).and_then(Json::as_i64);
        match (schema["type"].as_str(), schema.get("items")) {
            (Some("array"), Some(item)) => {
                ValueType::List(Box::new(Self::from_schema(item)), schema["maxItems"].as_u64())
            }
            (Some("number"), _) => ValueType::Number,
            (Some("integer"), _) => {
                ValueType::Integer(limit("minimum").unwrap_or(i64::MIN), limit("maximum").unwrap_or(i64::MAX))
            }
            (Some("boolean"), _) => ValueType::Flag,
            _ => ValueType::Text,
        }
    }

    /// Returns the same type with the dimension that it has for a sliding (linear) or rotating joint, if the dimension
    /// depends on this.
    pub fn of_joint(&self, is_linear: bool) -> Self {
        match self {
            ValueType::OneOf(dimensions) => {
                let of_joint = dimensions.iter().find(|dimension| dimension.is_linear() == is_linear);
                of_joint.map_or(self.clone(), |dimension| ValueType::Quantity(*dimension))
            }
            ValueType::List(item, length) => ValueType::List(Box::new(item.of_joint(is_linear)), *length),
            _ => self.clone(),
        }
    }

    /// Suffix that names have for the SI unit; `None` for a type without a unit.
    pub fn suffix(&self) -> Option<&'static str> {
        match self {
            ValueType::Quantity(dimension) => Some(dimension.suffix()),
            ValueType::List(item, _) => item.suffix(),
            _ => None,
        }
    }

    /// Reads the value of `key`; quantities are returned in SI units. `key` is used in messages, `parameters` in
    /// expressions.
    ///
    /// # Errors
    /// Returns the problems of a value of another type.
    pub fn read(&self, key: &str, value: &Spanned<DeValue<'_>>, parameters: &Parameters) -> Read<Value> {
        let found = value.get_ref();
        if let DeValue::String(text) = found
            && is_expression(text)
            && let Some(expected) = self.measures()
        {
            return self.read_expression(key, value, &parameters.evaluate(key, value, text)?, &expected);
        }
        let refuse = |name: &str, required: &str, label: &str, help: &str| {
            Err(vec![problem_at(value, format!("`{key}` is {name}, but must be {required}"), label, help.to_string())])
        };
        match (self, found) {
            (ValueType::Quantity(dimension), _) => read_quantity(key, value, &[*dimension]).map(Value::Float),
            (ValueType::OneOf(dimensions), _) => read_quantity(key, value, dimensions).map(Value::Float),
            (ValueType::Number | ValueType::Percent, _) => match (number(found), found) {
                (Some(Value::Integer(integer)), _) => Ok(Value::Float(integer as f64)),
                (Some(Value::Float(number)), _) if !number.is_finite() => {
                    refuse(&number.to_string(), "finite", "a number", "write a finite number")
                }
                (Some(number), _) => Ok(number),
                (None, DeValue::String(_)) => {
                    let help = "write it without quotes and unit, in SI units: 0.8 or 1e8";
                    refuse(type_name(found), "a plain number", "a number", help)
                }
                (None, _) => {
                    refuse(type_name(found), "a plain number", "a number", "write a number such as 0.8 or 1e8")
                }
            },
            (ValueType::Integer(min, max), _) => {
                let name = match number(found) {
                    Some(Value::Integer(integer)) if (min..=max).contains(&&integer) => {
                        return Ok(Value::Integer(integer));
                    }
                    Some(Value::Integer(integer)) => integer.to_string(),
                    _ => type_name(found).to_string(),
                };
                let upper = if *max == i64::MAX { String::new() } else { format!(" to {max}") };
                let help = format!("write a number from {min}{upper} without point, exponent or quotes");
                let label = if upper.is_empty() { "a whole number" } else { &format!("from {min}{upper}") };
                refuse(&name, &format!("a whole number from {min}{upper}"), label, &help)
            }
            (ValueType::Flag, DeValue::Boolean(flag)) => Ok(Value::Boolean(*flag)),
            (ValueType::Flag, _) => {
                refuse(type_name(found), "true or false", "true or false", "write true or false, without quotes")
            }
            (ValueType::Choice(keywords), _) => read_keyword(key, value, keywords),
            (ValueType::Text, DeValue::String(text)) if !text.trim().is_empty() => Ok(Value::from(text.as_ref())),
            (ValueType::Text, _) => {
                let name = if found.is_str() { "empty" } else { type_name(found) };
                refuse(name, "a string", "a string", "write a string in quotes, or remove the key")
            }
            (ValueType::List(item, None), DeValue::Array(items)) => read_items(key, item, items, parameters),
            (ValueType::List(item, None), _) => {
                let example = item.example();
                refuse(type_name(found), "a list", "a list in brackets", &format!("write [{example}, {example}]"))
            }
            (ValueType::List(item, Some(_)), DeValue::Array(items)) => {
                match read_items(key, item, items, parameters)? {
                    Value::Array(list) if list.len() != 2 => {
                        let which = if matches!(**item, ValueType::Quantity(_)) { ", x and y" } else { "" };
                        let message = format!("`{key}` has {} values, but must have two{which}", list.len());
                        Err(vec![problem_at(value, message, "two values", item.pair_example(found))])
                    }
                    list => Ok(list),
                }
            }
            (ValueType::List(item, Some(_)), _) => {
                let help = item.pair_example(found);
                refuse(type_name(found), "a list of two values", "two values in brackets", &help)
            }
        }
    }

    /// Whether a number or a quantity is required, so that an expression is allowed.
    pub fn is_numeric(&self) -> bool {
        self.measures().is_some()
    }

    /// Dimensions that an expression may have here, `None` for a plain number; `None` if the value is not numeric.
    fn measures(&self) -> Option<Vec<Option<Dimension>>> {
        match self {
            ValueType::Quantity(dimension) => Some(vec![Some(*dimension)]),
            ValueType::OneOf(dimensions) => Some(dimensions.iter().copied().map(Some).collect()),
            ValueType::Number | ValueType::Integer(..) => Some(vec![None]),
            _ => None,
        }
    }

    /// Checks the value of an expression like one that is written with its unit.
    fn read_expression(
        &self,
        key: &str,
        value: &Spanned<DeValue<'_>>,
        found: &Measured,
        expected: &[Option<Dimension>],
    ) -> Read<Value> {
        let text = value.get_ref().as_str().unwrap_or_default();
        let refuse = |message: String, label: &str, help: String| Err(vec![problem_at(value, message, label, help)]);
        let Some(dimension) = expected.iter().find(|dimension| found.is(**dimension)) else {
            let names: Vec<&str> = expected.iter().map(|of| of.map_or("a number", Dimension::name)).collect();
            let name = names.join(" or ");
            let help = match expected[0] {
                Some(dimension) if found.is_number() => {
                    format!("write units in the expression, or multiply it by `1 {}`", dimension.units()[0].name)
                }
                _ => format!(
                    "change the expression such that its result is {name}; a factor of `1 rad` makes a number an angle"
                ),
            };
            return refuse(format!("`{key}`: `{text}` is {}; expected {name}", found.name()), &name, help);
        };
        match (self, dimension) {
            (ValueType::Integer(min, max), _) => {
                let integer = found.si as i64;
                if integer as f64 == found.si && (min..=max).contains(&&integer) {
                    return Ok(Value::Integer(integer));
                }
                let message =
                    format!("`{key}`: `{text}` is {}, but must be a whole number from {min}", decimal(found.si));
                refuse(message, "a whole number", "change the values in the expression".to_string())
            }
            (_, Some(dimension)) if found.si.abs() > dimension.max_si() => {
                let text = format!("{text} = {found}");
                let message = format!("`{key}`: {}", units::QuantityError::TooLarge { text, expected: *dimension });
                refuse(message, dimension.name(), "change the values in the expression".to_string())
            }
            _ => Ok(Value::Float(found.si)),
        }
    }

    fn example(&self) -> String {
        match self {
            ValueType::Quantity(dimension) => format!("\"{}\"", dimension.example()),
            ValueType::OneOf(dimensions) => format!("\"{}\"", dimensions[0].example()),
            _ => "..".to_string(),
        }
    }

    /// Remedy for a value that is no pair. A single value is taken as y, which is the usual case for gravity and most
    /// other vectors.
    fn pair_example(&self, found: &DeValue<'_>) -> String {
        let ValueType::Quantity(dimension) = self else { return "write two values: [.., ..]".to_string() };
        let unit = dimension.units()[0].name;
        let y = match (number(found), found) {
            (Some(Value::Integer(y)), _) => format!("{y} {unit}"),
            (Some(Value::Float(y)), _) => format!("{y} {unit}"),
            (_, DeValue::String(y)) if units::parse(y, *dimension).is_ok() => y.trim().to_string(),
            _ => dimension.example().to_string(),
        };
        format!("write x and y: [\"0 {unit}\", \"{y}\"]")
    }

    /// Converts a value of a schema, such as a default, to SI units. It has the notation of a file.
    pub(crate) fn json_to_si(&self, json: &Json) -> Option<Value> {
        self.read("", &DeValue::parse(&json.to_string()).ok()?, &Parameters::default()).ok()
    }

    /// Reads a value in SI units, as recorded in a log; `None` if it is invalid.
    pub fn restore(&self, text: &str) -> Option<Value> {
        match self {
            ValueType::Quantity(dimension) => {
                text.parse().ok().filter(|si: &f64| si.abs() <= dimension.max_si()).map(Value::Float)
            }
            ValueType::Number | ValueType::Percent | ValueType::OneOf(_) => {
                text.parse().ok().filter(|number: &f64| number.is_finite()).map(Value::Float)
            }
            ValueType::Integer(min, max) => {
                text.parse().ok().filter(|integer| (min..=max).contains(&integer)).map(Value::Integer)
            }
            ValueType::Flag => text.parse().ok().map(Value::Boolean),
            ValueType::Choice(keywords) => keywords.iter().any(|keyword| keyword == text).then(|| text.into()),
            // No record has such values.
            ValueType::Text | ValueType::List(..) => None,
        }
    }
}

fn read_items(key: &str, item: &ValueType, items: &[Spanned<DeValue<'_>>], parameters: &Parameters) -> Read<Value> {
    let values = items.iter().map(|value| item.read(key, value, parameters));
    let (values, problems): (Vec<_>, Vec<_>) = values.partition(Result::is_ok);
    // A value without problem of its own uses an invalid parameter.
    match problems.is_empty() {
        true => Ok(Value::Array(values.into_iter().flatten().collect())),
        false => Err(problems.into_iter().filter_map(Result::err).flatten().collect()),
    }
}

/// Dimensions of the quantities of a schema, from its units.
fn dimensions(schema: &Json) -> Vec<Dimension> {
    let units = schema["x-units"].as_array().into_iter().flatten().filter_map(Json::as_str);
    units.filter_map(|unit| Dimension::ALL.into_iter().find(|dimension| dimension.units()[0].name == unit)).collect()
}

/// Returns the dimension that a quantity has among the dimensions `among`; `None` if it has none of them.
pub fn dimension_of(text: &str, among: &[Dimension], parameters: &Parameters) -> Option<Dimension> {
    let of_expression = is_expression(text).then(|| parameters.value(text)).flatten();
    among.iter().copied().find(|dimension| match &of_expression {
        Some(value) => value.is(Some(*dimension)),
        None => units::parse(text, *dimension).is_ok(),
    })
}

/// Reads a quantity of one of these dimensions.
fn read_quantity(key: &str, value: &Spanned<DeValue<'_>>, expected: &[Dimension]) -> Read<f64> {
    let any_of = |text: fn(Dimension) -> String| expected.iter().map(|each| text(*each)).collect::<Vec<_>>();
    let name = any_of(|each| each.name().to_string()).join(" or ");
    let help =
        || format!("write a number and its unit, as in {}", any_of(|d| format!("\"{}\"", d.example())).join(" or "));
    let DeValue::String(text) = value.get_ref() else {
        let message = format!(
            "`{key}` is {}; expected {name} as a string with its unit: {}",
            type_name(value.get_ref()),
            any_of(Dimension::unit_list).join(", ")
        );
        return Err(vec![problem_at(value, message, name.as_str(), help())]);
    };
    let has_unit = |dimension: &&Dimension| units::parse(text, **dimension).is_ok();
    let dimension = *expected.iter().find(has_unit).unwrap_or(&expected[0]);
    units::parse(text, dimension).map_err(|e| vec![problem_at(value, format!("`{key}`: {e}"), name.as_str(), help())])
}

/// Reads a keyword of a closed list.
fn read_keyword(key: &str, value: &Spanned<DeValue<'_>>, keywords: &[String]) -> Read<Value> {
    let help = format!("allowed: \"{}\"", keywords.join("\", \""));
    let DeValue::String(text) = value.get_ref() else {
        let message = format!("`{key}` is {}, but must be a keyword", type_name(value.get_ref()));
        return Err(vec![problem_at(value, message, "a keyword in quotes", help)]);
    };
    if keywords.iter().any(|keyword| keyword == text) {
        return Ok(text.as_ref().into());
    }
    if let Some((reason, instead)) = find_unsupported(key, text) {
        let (message, help) = (format!("`{key}` has no \"{text}\": {reason}"), format!("{instead}; {help}"));
        return Err(vec![problem_at(value, message, "not supported by phalanx", help)]);
    }
    let keywords: Vec<&str> = keywords.iter().map(String::as_str).collect();
    let label = closest_match(text, &keywords).map_or("unknown value".into(), |w| format!("did you mean \"{w}\"?"));
    let message = format!("\"{}\" is not a valid value of `{key}`", text.escape_debug());
    Err(vec![problem_at(value, message, label, help)])
}
