//! Value parsers of flags; their messages name what is allowed, with an example.

use std::ops::RangeInclusive;
use std::str::FromStr;

use crate::units::{Dimension, parse_positive};

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
}
