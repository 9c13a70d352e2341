//! The section `[parameters]`: named values, and the expressions that use them.

use std::collections::BTreeMap;
use std::ops::Range;

use toml::de::{DeTable, DeValue};
use toml::{Spanned, Value};

use super::error::Problem;
use super::field::PARAMETERS;
use super::keys::{closest_match, is_name};
use super::written::{number, problem_at, type_name};
use crate::limits::MAX_PARAMETERS;
use crate::units::{self, ExpressionError, FUNCTIONS, Measured, is_expression};

const REMEDY: &str = "write a number, a quantity such as \"40 mm\", or an expression such as \"= 2 * crank\"";

/// Values of the parameters of a scene. The value is `None` for an invalid parameter, whose problem has been reported.
#[derive(Clone, Debug, Default)]
pub struct Parameters(BTreeMap<String, Option<Measured>>);

/// The parameters of a scene as written.
type Section<'a> = DeTable<'a>;

impl Parameters {
    /// Evaluates the parameters of a scene; also returns their problems.
    pub fn read(scene: &DeTable<'_>) -> (Self, Vec<Problem>) {
        let (mut parameters, mut problems) = (Parameters::default(), Vec::new());
        let section = scene.get(PARAMETERS).and_then(|section| section.get_ref().as_table());
        for (index, (name, _)) in section.into_iter().flatten().enumerate() {
            let text = name.get_ref().as_ref();
            let is_reserved = text == "pi" || FUNCTIONS.contains(&text);
            let (message, help) = if index >= MAX_PARAMETERS {
                (format!("there are more than {MAX_PARAMETERS} parameters"), "remove some of them".to_string())
            } else if is_reserved || !is_name(text) {
                let help = format!("use a letter followed by letters, digits and _; not pi, {}", FUNCTIONS.join(", "));
                (format!("`{}` cannot be the name of a parameter", text.escape_debug()), help)
            } else {
                continue;
            };
            problems.push(Problem::new(Some(name.span()), message, "not a parameter", help));
            parameters.0.insert(text.to_string(), None);
        }
        for name in section.into_iter().flat_map(DeTable::keys) {
            parameters.resolve(name.get_ref(), section, &mut problems);
        }
        (parameters, problems)
    }

    /// Evaluates a parameter after those that it uses, without recursion: the stack is that of names.
    fn resolve(&mut self, name: &str, section: Option<&Section<'_>>, problems: &mut Vec<Problem>) {
        let mut open = vec![name.to_string()];
        while let Some(name) = open.last().cloned() {
            let value = section.and_then(|section| section.get(name.as_str()));
            let Some(value) = value.filter(|_| !self.0.contains_key(&name)) else {
                open.pop();
                continue;
            };
            let found = match self.read_value(&name, value, section) {
                Err(Failure::Pending(other)) => match open.iter().position(|name| *name == other) {
                    None => {
                        open.push(other);
                        continue;
                    }
                    Some(first) => {
                        let circle = [&open[first..], std::slice::from_ref(&other)].concat();
                        let message = format!("the parameters use each other in a circle: {}", circle.join(" → "));
                        problems.push(problem_at(
                            value,
                            message,
                            "ends the circle",
                            "give one of them a value".to_string(),
                        ));
                        self.0.extend(open.drain(first..).map(|name| (name, None)));
                        continue;
                    }
                },
                Err(Failure::Problems(found)) => {
                    problems.extend(found);
                    None
                }
                Ok(found) => Some(found),
            };
            self.0.insert(name, found);
        }
    }

    fn read_value(
        &self,
        name: &str,
        value: &Spanned<DeValue<'_>>,
        section: Option<&Section<'_>>,
    ) -> Result<Measured, Failure> {
        let path = format!("{PARAMETERS}.{name}");
        let refuse =
            |message: String| Err(Failure::Problems(vec![problem_at(value, message, "a value", REMEDY.to_string())]));
        match value.get_ref() {
            DeValue::String(text) if is_expression(text) => self.evaluate_in(&path, value, text, section),
            DeValue::String(text) => match units::dimension_of(text) {
                Some(dimension) => match units::parse(text, dimension) {
                    Ok(si) => Ok(Measured::new(si, Some(dimension))),
                    Err(error) => refuse(format!("`{path}`: {error}")),
                },
                None => refuse(format!("`{path}`: `{text}` is not a number with a known unit")),
            },
            DeValue::Integer(_) | DeValue::Float(_) => match number(value.get_ref()) {
                Some(Value::Integer(integer)) => Ok(Measured::new(integer as f64, None)),
                Some(Value::Float(number)) if number.is_finite() => Ok(Measured::new(number, None)),
                _ => refuse(format!("`{path}` is not a finite number")),
            },
            other => refuse(format!("`{path}` is {}, but must be a single value", type_name(other))),
        }
    }

    /// Evaluates an expression; `key` is its key, for messages.
    ///
    /// # Errors
    /// Returns the problems of the expression. The list is empty if a parameter is invalid, because this has been
    /// reported.
    pub fn evaluate(&self, key: &str, value: &Spanned<DeValue<'_>>, text: &str) -> Result<Measured, Vec<Problem>> {
        self.evaluate_in(key, value, text, None).map_err(|failure| match failure {
            Failure::Problems(problems) => problems,
            Failure::Pending(_) => Vec::new(),
        })
    }

    /// The value of an expression; `None` if it has none.
    pub(crate) fn value(&self, text: &str) -> Option<Measured> {
        units::evaluate(text, &|name, span| self.lookup(name, span, None)).ok()
    }

    /// Value of a parameter; `None` if the parameter is unknown or invalid.
    pub fn get(&self, name: &str) -> Option<Measured> {
        *self.0.get(name)?
    }

    /// Names of the parameters.
    pub fn names(&self) -> Vec<&str> {
        self.0.keys().map(String::as_str).collect()
    }

    fn lookup(
        &self,
        name: &str,
        span: Range<usize>,
        section: Option<&Section<'_>>,
    ) -> Result<Measured, ExpressionError> {
        match self.0.get(name) {
            Some(value) => value.ok_or(ExpressionError::Reported),
            None if section.is_some_and(|section| section.contains_key(name)) => {
                Err(ExpressionError::Pending(name.to_string()))
            }
            None => {
                let names = section.map_or_else(
                    || self.names(),
                    |section| section.keys().map(|name| name.get_ref().as_ref()).collect(),
                );
                let (label, help) = unknown(name, &names);
                Err(ExpressionError::Problem { span, message: format!("unknown parameter `{name}`"), label, help })
            }
        }
    }

    fn evaluate_in(
        &self,
        key: &str,
        value: &Spanned<DeValue<'_>>,
        text: &str,
        section: Option<&Section<'_>>,
    ) -> Result<Measured, Failure> {
        units::evaluate(text, &|name, span| self.lookup(name, span, section)).map_err(|error| match error {
            ExpressionError::Pending(name) => Failure::Pending(name),
            ExpressionError::Reported => Failure::Problems(Vec::new()),
            ExpressionError::Problem { span, message, label, help } => {
                let file = value.span();
                // A string with escapes has other positions than its value.
                let is_verbatim = file.len() == text.len() + 2;
                let span = if is_verbatim { file.start + 1 + span.start..file.start + 1 + span.end } else { file };
                Failure::Problems(vec![Problem::new(Some(span), format!("`{key}`: {message}"), label, help)])
            }
        })
    }
}

/// Returns a remark on an unknown parameter, and the remedy.
pub fn unknown(name: &str, names: &[&str]) -> (String, String) {
    let label = closest_match(name, names).map_or("not a parameter".into(), |near| format!("did you mean `{near}`?"));
    let help = match names {
        [] => "this scene has no parameters; a file defines them in a section [parameters]".to_string(),
        _ => format!("parameters of this scene: {}; a file defines others in [parameters]", names.join(", ")),
    };
    (label, help)
}

/// Reason why a parameter has no value.
enum Failure {
    /// Another one has to be evaluated before.
    Pending(String),
    Problems(Vec<Problem>),
}
