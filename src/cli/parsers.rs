//! Value parsers of flags; their messages name what is allowed, with an example. `expected` describes the values of a
//! flag with an example.

use std::ops::RangeInclusive;
use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::limits::MAX_THREADS;
use crate::sizing::Rule;
use crate::trace::Model;
use crate::units::{self, Dimension, parse_positive};

/// Returns a parser of a quantity that must be positive. `example` begins with its article: `a time such as "40 ms"`.
pub fn positive(
    dimension: Dimension,
    example: &'static str,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| parse_positive(text, dimension, &format!("must be more than 0; expected {example}"))
}

/// Returns a parser of a number that must be accepted. `expected` describes the accepted numbers.
pub fn number<T: FromStr + Clone + Send + Sync + 'static>(
    is_accepted: fn(&T) -> bool,
    expected: &'static str,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text| text.trim().parse().ok().filter(is_accepted).ok_or_else(|| format!("expected {expected}"))
}

/// Returns a parser of a count within a range.
pub fn count(
    range: RangeInclusive<usize>,
    example: &'static str,
) -> impl Fn(&str) -> Result<usize, String> + Clone + Send + Sync + 'static {
    move |text| match text.trim().parse() {
        Ok(count) if range.contains(&count) => Ok(count),
        _ => Err(format!("expected a number from {} to {}, such as {example}", range.start(), range.end())),
    }
}

/// Returns a parser of one of several named values, each with its name and its help, which may be empty.
pub fn choice<T: Clone + Send + Sync + 'static, const N: usize>(
    choices: [(&'static str, &'static str, T); N],
) -> impl TypedValueParser<Value = T> {
    let values = choices.each_ref().map(|(name, help, _)| match help.is_empty() {
        true => PossibleValue::new(*name),
        false => PossibleValue::new(*name).help(*help),
    });
    PossibleValuesParser::new(values).map(move |name| {
        choices.iter().find(|(known, ..)| *known == name).expect("one of the possible values").2.clone()
    })
}

/// Returns the parser of simulation models.
pub fn model() -> impl TypedValueParser<Value = Model> {
    choice([
        ("analytic", "Closed-form Lagrange model with its own stiff integrator", Model::Analytic),
        ("engine", "Rigid-body engine with the same contact laws", Model::Engine),
    ])
}

/// Returns the parser of sizing rules.
pub fn rule() -> impl TypedValueParser<Value = Rule> {
    choice([
        ("rigid", "RMS of the net motor torque until the proximal contact", Rule::Rigid),
        ("whole", "RMS over the whole trajectory, against the constant spring", Rule::Whole),
    ])
}

/// Parses a finite number for which `is_valid` holds; `name` names such numbers.
pub(crate) fn parse_number(
    item: &str,
    is_valid: impl Fn(f64) -> bool,
    name: &str,
    expected: &str,
) -> Result<f64, String> {
    let number = item.trim().parse().ok().filter(|value: &f64| value.is_finite() && is_valid(*value));
    number.ok_or_else(|| format!("`{}` is not {name}; expected {expected}", item.trim()))
}

/// Parses a quantity for which `is_valid` holds; `requirement` is the message for all others.
pub fn parse_quantity(
    item: &str,
    dimension: Dimension,
    is_valid: impl Fn(f64) -> bool,
    requirement: &str,
    expected: &str,
) -> Result<f64, String> {
    match units::parse(item, dimension) {
        Ok(value) if is_valid(value) => Ok(value),
        Ok(_) => Err(format!("`{}`: {requirement}; expected {expected}", item.trim())),
        Err(error) => Err(format!("{error}; expected {expected}")),
    }
}

/// Parses two comma-separated values, the lower one first.
pub(crate) fn parse_limits(
    text: &str,
    expected: &str,
    read: impl Fn(&str) -> Result<f64, String>,
) -> Result<[f64; 2], String> {
    match text.split(',').map(read).collect::<Result<Vec<_>, _>>()?[..] {
        [from, to] if from <= to => Ok([from, to]),
        [_, _] => Err(format!("the first limit is greater than the second; expected {expected}")),
        [_] => Err(format!("1 value was given; expected {expected}")),
        ref values => Err(format!("{} values were given; expected {expected}", values.len())),
    }
}

/// Parses a number of threads.
pub(crate) fn parse_threads(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|threads| (1..=MAX_THREADS).contains(threads));
    number
        .ok_or_else(|| format!("expected a number of threads from 1 to {MAX_THREADS}; omit the flag to use all cores"))
}

/// Parses a number of threads; 0 selects all cores.
pub(crate) fn parse_threads_or_all(text: &str) -> Result<usize, String> {
    if text == "0" { Ok(0) } else { parse_threads(text) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_what_is_allowed() {
        let length = positive(Dimension::Length, "a length such as \"3.5 mm\"");
        let odd = number(|count: &usize| count % 2 == 1, "an odd number");
        assert_eq!((length("3.5 mm"), odd("15")), (Ok(3.5e-3), Ok(15)));
        for (error, message) in [
            (length("0 mm").err(), "more than 0; expected a length such as \"3.5 mm\""),
            (length("-1 mm").err(), "more than 0"),
            (length("3").err(), "no unit"),
            (odd("4").err(), "expected an odd number"),
            (odd("x").err(), "expected an odd number"),
            (count(1..=360, "8")("0").err(), "expected a number from 1 to 360, such as 8"),
        ] {
            assert!(error.as_ref().is_some_and(|error| error.contains(message)), "{message}: {error:?}");
        }
    }

    #[test]
    fn messages_name_the_value_and_an_example() {
        let length =
            |item: &str| parse_quantity(item, Dimension::Length, |m| m > 0.0, "it must be more than 0", "1 mm");
        let factor = |item: &str| parse_number(item, |value| value > 0.0, "a factor above 0", "2");
        assert_eq!((length(" 12 mm"), factor("0.5")), (Ok(0.012), Ok(0.5)));
        assert_eq!(parse_limits("0.25,1", "factors", factor), Ok([0.25, 1.0]));
        assert_eq!((parse_threads("2"), parse_threads_or_all("0")), (Ok(2), Ok(0)));
        for (error, part) in [
            (length("12").unwrap_err(), "no unit"),
            (length("").unwrap_err(), "number"),
            (length("1 deg").unwrap_err(), "is an angle"),
            (length("0 mm").unwrap_err(), "`0 mm`: it must be more than 0"),
            (factor("nan").unwrap_err(), "`nan` is not a factor above 0"),
            (parse_limits("2,1", "factors", factor).unwrap_err(), "greater than the second"),
            (parse_limits("1", "factors", factor).unwrap_err(), "1 value was given"),
            (parse_threads("0").unwrap_err(), "from 1"),
        ] {
            assert!(error.contains(part) && error.contains("expected"), "{error}");
        }
    }
}
