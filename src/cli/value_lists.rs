//! Parsers of numbers, quantities, limits and numbers of threads. `expected` describes the values of a flag with an
//! example.

use crate::limits::MAX_THREADS;
use crate::units::{self, Dimension};

/// Parses a finite number for which `is_valid` holds; `name` names such numbers.
pub fn parse_number(item: &str, is_valid: impl Fn(f64) -> bool, name: &str, expected: &str) -> Result<f64, String> {
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
pub fn parse_limits(
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
pub fn parse_threads(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|threads| (1..=MAX_THREADS).contains(threads));
    number
        .ok_or_else(|| format!("expected a number of threads from 1 to {MAX_THREADS}; omit the flag to use all cores"))
}

/// Parses a number of threads; 0 selects all cores.
pub fn parse_threads_or_all(text: &str) -> Result<usize, String> {
    if text == "0" { Ok(0) } else { parse_threads(text) }
}

#[cfg(test)]
mod tests {
    use super::*;

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
