//! Parsers of comma-separated numbers and quantities, and of numbers of threads.

use crate::limits::MAX_THREADS;
use crate::units::{self, Dimension};

/// Values of one flag, in the given order.
#[derive(Clone, Debug, PartialEq)]
pub struct Numbers(pub Vec<f64>);

/// Parses comma-separated values with `read`; `expected` describes them with an example.
pub fn parse_numbers(
    text: &str,
    expected: &str,
    read: impl Fn(&str) -> Result<f64, String>,
) -> Result<Numbers, String> {
    let values = text.split(',').map(|item| read(item.trim())).collect::<Result<_, _>>();
    values.map(Numbers).map_err(|message| format!("{message}; expected {expected}"))
}

/// Parses different comma-separated values and sorts them.
pub fn parse_sorted(text: &str, expected: &str, read: impl Fn(&str) -> Result<f64, String>) -> Result<Numbers, String> {
    let Numbers(mut values) = parse_numbers(text, expected, read)?;
    values.sort_by(f64::total_cmp);
    match values.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(format!("{} is given twice; expected {expected}", pair[0])),
        None => Ok(Numbers(values)),
    }
}

/// Parses two comma-separated values, the lower one first.
pub fn parse_limits(
    text: &str,
    expected: &str,
    read: impl Fn(&str) -> Result<f64, String>,
) -> Result<[f64; 2], String> {
    match parse_numbers(text, expected, read)?.0[..] {
        [from, to] if from <= to => Ok([from, to]),
        [_, _] => Err(format!("the first limit is greater than the second; expected {expected}")),
        [_] => Err(format!("1 value was given; expected {expected}")),
        ref values => Err(format!("{} values were given; expected {expected}", values.len())),
    }
}

/// Parses a finite number for which `is_valid` holds; `name` names such numbers in messages.
pub fn parse_number(item: &str, is_valid: impl Fn(f64) -> bool, name: &str) -> Result<f64, String> {
    let number = item.parse().ok().filter(|value: &f64| value.is_finite() && is_valid(*value));
    number.ok_or_else(|| format!("`{item}` is not {name}"))
}

/// Parses a quantity for which `is_valid` holds; `requirement` is the message for all others.
pub fn parse_quantity(
    item: &str,
    dimension: Dimension,
    is_valid: impl Fn(f64) -> bool,
    requirement: &str,
) -> Result<f64, String> {
    let value = units::parse(item, dimension).map_err(|error| error.to_string())?;
    if is_valid(value) { Ok(value) } else { Err(format!("`{item}`: {requirement}")) }
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
            |item: &str| parse_quantity(item, Dimension::Length, |value| value > 0.0, "it must be more than 0");
        let factor = |item: &str| parse_number(item, |value| value > 0.0, "a factor above 0");
        assert_eq!(parse_numbers("12 mm, 0.5 cm", "lengths", length), Ok(Numbers(vec![0.012, 0.005])));
        assert_eq!(parse_sorted("10,1", "factors", factor), Ok(Numbers(vec![1.0, 10.0])));
        assert_eq!(parse_limits("0.25,1", "factors", factor), Ok([0.25, 1.0]));
        assert_eq!((parse_threads("2"), parse_threads_or_all("0")), (Ok(2), Ok(0)));
        for (error, part) in [
            (parse_numbers("12", "lengths", length).unwrap_err(), "no unit"),
            (parse_numbers("12 mm,,1 mm", "lengths", length).unwrap_err(), "number"),
            (parse_numbers("1 deg", "lengths", length).unwrap_err(), "is an angle"),
            (parse_numbers("0 mm", "lengths", length).unwrap_err(), "`0 mm`: it must be more than 0"),
            (parse_numbers("1,nan", "factors", factor).unwrap_err(), "`nan` is not a factor above 0"),
            (parse_sorted("1,1.0", "factors", factor).unwrap_err(), "1 is given twice"),
            (parse_limits("2,1", "factors", factor).unwrap_err(), "greater than the second"),
            (parse_limits("1", "factors", factor).unwrap_err(), "1 value was given"),
            (parse_threads("0").unwrap_err(), "from 1"),
        ] {
            assert!(error.contains(part) && error.contains("expected"), "{error}");
        }
    }
}
