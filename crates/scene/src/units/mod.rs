//! Quantities as text, a number with its unit, to and from plain `f64` in SI units: `"480 N*mm"` → 0.48 → `"480 N*mm"`.

mod expression;
mod measured;
mod table;

pub use expression::{ExpressionError, FUNCTIONS, Lookup, evaluate, is_expression};
pub use measured::Measured;
pub use table::{Dimension, G_M_S2, MAX_TIME_S, Unit, number};

use crate::numeric::elementary::{log10, powi};

/// Error for a text that is not the expected quantity. Messages name the problem and the allowed values.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum QuantityError {
    #[error("`{text}` does not begin with a number; expected {}, such as \"{}\"", .expected.name(), .expected.example())]
    NotANumber { text: String, expected: Dimension },
    #[error("`{text}` has a decimal comma; write a decimal point, as in \"{}\"", .text.replacen(',', ".", 1))]
    DecimalComma { text: String },
    #[error("`{text}` is not a finite number")]
    NotFinite { text: String },
    #[error("`{text}` is too large: {} may be {} {} at most", .expected.name(), number(.expected.max_si()), .expected.units()[0].name)]
    TooLarge { text: String, expected: Dimension },
    #[error("`{text}` has no unit; expected {}: {}", .expected.name(), .expected.unit_list())]
    MissingUnit { text: String, expected: Dimension },
    #[error("unknown unit `{unit}`{}; expected {}: {}", did_you_mean(.suggestion), .expected.name(), .expected.unit_list())]
    UnknownUnit { unit: String, suggestion: Option<&'static str>, expected: Dimension },
    #[error("{text} is {}; expected {}: {}", .found.name(), .expected.name(), .expected.unit_list())]
    WrongDimension { text: String, found: Dimension, expected: Dimension },
}

/// Parses a quantity that must be above 0 and returns it in SI units.
///
/// # Errors
/// Returns a message about the text, or `otherwise` if the value is not above 0.
pub fn parse_positive(text: &str, expected: Dimension, otherwise: &str) -> Result<f64, String> {
    match parse(text, expected) {
        Ok(value) if value > 0.0 => Ok(value),
        Ok(_) => Err(otherwise.to_string()),
        Err(error) => Err(error.to_string()),
    }
}

/// Parses a quantity of dimension `expected` and returns it in SI units.
///
/// The number is a decimal with an optional exponent. Units are listed in [`Dimension::units`] and are case-sensitive.
/// A product may be written with `*`, `·` or a space, a square as `^2` or `²`, micro as `u` or `µ`, degrees as `deg` or
/// `°`.
pub fn parse(text: &str, expected: Dimension) -> Result<f64, QuantityError> {
    let text = text.trim();
    let (number, rest) = text.split_at(number_length(text));
    if number.is_empty() {
        let unsigned = text.trim_start_matches(['+', '-']).to_ascii_lowercase();
        return Err(match unsigned.starts_with("inf") || unsigned.starts_with("nan") {
            true => QuantityError::NotFinite { text: text.into() },
            false => QuantityError::NotANumber { text: text.into(), expected },
        });
    }
    if rest.starts_with(',') && rest[1..].starts_with(|c: char| c.is_ascii_digit()) {
        return Err(QuantityError::DecimalComma { text: text.into() });
    }
    let name = canonical(rest);
    if name.is_empty() {
        return Err(QuantityError::MissingUnit { text: text.into(), expected });
    }
    let Some(unit) = expected.units().iter().find(|u| u.name == name) else {
        return Err(match dimension_of(text) {
            Some(found) => QuantityError::WrongDimension { text: text.into(), found, expected },
            None => QuantityError::UnknownUnit {
                unit: rest.trim().into(),
                suggestion: similar_unit(&name, expected),
                expected,
            },
        });
    };
    match to_si(number, unit.factor) {
        Some(si) if si.abs() <= expected.max_si() => Ok(si),
        Some(si) if si.is_finite() => Err(QuantityError::TooLarge { text: text.into(), expected }),
        Some(_) => Err(QuantityError::NotFinite { text: text.into() }),
        None => Err(QuantityError::NotANumber { text: text.into(), expected }),
    }
}

/// Returns the unit of the expected dimension with the same letters and digits: `N*mm` for `Nmm`, `kg/m^3` for `kg/m3`.
fn similar_unit(name: &str, expected: Dimension) -> Option<&'static str> {
    let letters = |unit: &str| unit.chars().filter(|c| c.is_alphanumeric()).collect::<String>();
    let name = letters(name);
    expected.units().iter().map(|unit| unit.name).find(|unit| letters(unit) == name)
}

fn did_you_mean(unit: &Option<&str>) -> String {
    unit.map_or(String::new(), |unit| format!(" (did you mean {unit}?)"))
}

/// Converts the decimal `number` in a unit of `factor` SI units to SI; `None` if it is not a number.
///
/// A power of ten shifts the decimal point, so that 4.73 g becomes the double nearest to 0.00473.
fn to_si(number: &str, factor: f64) -> Option<f64> {
    let shift = log10(factor).round();
    if (factor / powi(10.0, shift as i32) - 1.0).abs() < 1e-14 {
        let (mantissa, exponent) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
        if let Ok(exponent) = exponent.parse::<i32>() {
            return format!("{mantissa}e{}", exponent.saturating_add(shift as i32)).parse().ok();
        }
    }
    number.parse::<f64>().ok().map(|value| value * factor)
}

/// Returns the first dimension that has the unit of a quantity; `None` if no dimension has it.
pub fn dimension_of(text: &str) -> Option<Dimension> {
    let name = canonical(split_quantity(text).1);
    Dimension::ALL.into_iter().find(|dimension| dimension.units().iter().any(|unit| unit.name == name))
}

/// Splits a text into its leading number and the rest, which is the unit.
pub fn split_quantity(text: &str) -> (&str, &str) {
    let text = text.trim();
    let (number, unit) = text.split_at(number_length(text));
    (number, unit.trim_start())
}

/// Length in bytes of the number at the beginning of `text`; 0 if there is none.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let count_digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let sign_length = |position: usize| usize::from(matches!(bytes.get(position), Some(b'+' | b'-')));

    let start = sign_length(0);
    let integer_digits = count_digits(start);
    let mut end = start + integer_digits;
    let mut fraction_digits = 0;
    if bytes.get(end) == Some(&b'.') {
        fraction_digits = count_digits(end + 1);
        end += 1 + fraction_digits;
    }
    if integer_digits + fraction_digits == 0 {
        return 0;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let exponent_start = end + 1 + sign_length(end + 1);
        let exponent_digits = count_digits(exponent_start.min(bytes.len()));
        if exponent_digits > 0 {
            end = exponent_start + exponent_digits;
        }
    }
    end
}

/// Returns the spelling used in the unit table.
fn canonical(unit: &str) -> String {
    let name =
        unit.replace(['·', '⋅', '•', '×'], "*").replace(['µ', 'μ'], "u").replace('°', "deg").replace(['Ω', 'Ω'], "ohm");
    let name = name.replace('²', "^2").replace('³', "^3");
    // A space is a product, except next to an operator.
    let mut joined = String::with_capacity(name.len());
    for word in name.split_whitespace() {
        let operator = |c: char| matches!(c, '*' | '/' | '^');
        if !joined.is_empty() && !joined.ends_with(operator) && !word.starts_with(operator) {
            joined.push('*');
        }
        joined.push_str(word);
    }
    joined
}

/// Neighbours of the quotient, in units in the last place, tried before a unit is rejected.
const NEIGHBOURS: i64 = 4;

/// Formats a finite value in such a way that [`parse`] returns the same bits.
///
/// Among the shown units, it prefers those that give a number from 1 to 1000. Of these, it takes the one with the
/// shortest text; of several, the last one in the list.
pub fn format(value_si: f64, dimension: Dimension) -> String {
    let candidates = dimension.units().iter().filter(|u| u.shown);
    candidates
        .filter_map(|unit| exact(value_si, unit, dimension))
        .rev()
        .min_by_key(|(text, is_handy)| (!is_handy, text.len()))
        .map(|(text, _)| text)
        .unwrap_or_else(|| format!("{} {}", number(value_si), dimension.units()[0].name))
}

/// Formats `value_si` in `unit`, with whether the number is from 1 to 1000; `None` if no decimal in `unit` parses back
/// to the same bits.
fn exact(value_si: f64, unit: &Unit, dimension: Dimension) -> Option<(String, bool)> {
    let factor = unit.factor;
    let quotient = if factor == 1.0 { value_si } else { value_si / factor };
    let is_handy = (1.0..1000.0).contains(&quotient.abs());
    let mut best: Option<String> = None;
    for step in -NEIGHBOURS..=NEIGHBOURS {
        let neighbour = f64::from_bits(quotient.to_bits().wrapping_add_signed(step));
        let text = format!("{} {}", number(neighbour), unit.name);
        let same = parse(&text, dimension).is_ok_and(|back| back.to_bits() == value_si.to_bits());
        if same && best.as_ref().is_none_or(|b| text.len() < b.len()) {
            best = Some(text);
        }
    }
    best.map(|text| (text, is_handy))
}

#[cfg(test)]
mod tests {
    use super::Dimension::*;
    use super::*;
    use proptest::prelude::*;

    fn ok(text: &str, dimension: Dimension) -> f64 {
        parse(text, dimension).unwrap_or_else(|e| panic!("{text}: {e}"))
    }

    fn message(text: &str, dimension: Dimension) -> String {
        parse(text, dimension).expect_err(text).to_string()
    }

    #[test]
    fn converts_numbers_and_the_unit_of_the_expected_dimension() {
        assert_eq!(ok("24.4324mm", Length), 0.0244324);
        assert_eq!(ok("-3.5e-2 um", Length), -3.5e-8);
        assert_eq!(ok("4.73 g", Mass), 0.00473);
        assert_eq!(["9.81 m/s^2", "2 g"].map(|text| ok(text, Acceleration)), [9.81, 19.62]);
    }

    #[test]
    fn accepts_equivalent_spellings_of_units() {
        for text in ["480 N*mm", "480 N·mm", "480 N mm", "480N*mm", " 480  N * mm ", "480 N⋅mm"] {
            assert_eq!(ok(text, Torque), 0.48, "{text}");
        }
        for text in ["10 um", "10 µm", "10 μm", "1e1 um", "+10. um", "1.0E+1um"] {
            assert_eq!(ok(text, Length), 1e-5, "{text}");
        }
        assert_eq!(ok("90°", Angle), ok("90 deg", Angle));
        assert_eq!(ok("9.81 m/s²", Acceleration), 9.81);
        assert_eq!(ok("9.81 m / s ^ 2", Acceleration), 9.81);
        assert_eq!(ok("1 °/s", AngularRate), ok("1 deg/s", AngularRate));
    }

    #[test]
    fn accepts_every_listed_unit_and_example() {
        for dimension in Dimension::ALL {
            ok(dimension.example(), dimension);
            for unit in dimension.units() {
                let reparsed = ok(&format!("1 {}", unit.name), dimension);
                assert!((reparsed / unit.factor - 1.0).abs() < 1e-15, "{}", unit.name);
            }
        }
    }

    #[test]
    fn error_messages_name_value_and_allowed_units() {
        // Other messages are those of the broken scenes.
        for (text, dimension, unit) in
            [("1 kg/m3", Density, "kg/m^3"), ("2 N.s/m", LinearDamping, "N*s/m"), ("3 gmm2", Inertia, "g*mm^2")]
        {
            assert!(message(text, dimension).contains(&format!("did you mean {unit}?")), "{text}");
        }
        assert_eq!(message("1e300 mm", Length), "`1e300 mm` is too large: a length may be 1000 m at most");
        assert_eq!(message("-2 h", Time), "unknown unit `h`; expected a time: s, ms, us");
        assert_eq!(message("3601 s", Time), "`3601 s` is too large: a time may be 3600 s at most");
        for text in ["inf mm", "NaN mm", "-infinity m", "1e999 m", "1e308 GPa"] {
            let dimension = if text.ends_with("Pa") { Pressure } else { Length };
            assert_eq!(message(text, dimension), format!("`{text}` is not a finite number"));
        }
    }

    #[test]
    fn rejects_malformed_texts() {
        for text in
            ["", " ", "+", "-", ".", "e", "1e", "1e+", ".e5 mm", "--1 mm", "1 m m", "1 *", "1 /", "𝟙 mm", "1 °°", "1e5"]
        {
            assert!(parse(text, Length).is_err(), "{text}");
        }
    }

    #[test]
    fn formats_values_in_common_units() {
        for (value, dimension, text) in [
            (0.015, Length, "15 mm"),
            (1e-5, Length, "10 um"),
            (0.0244324, Length, "24.4324 mm"),
            (0.0, Length, "0 m"),
            (120f64.to_radians(), Angle, "120 deg"),
            (0.48, Torque, "480 N*mm"),
            (0.02, Time, "20 ms"),
            (9.81, Acceleration, "9.81 m/s^2"),
            (1e9, AngularDamping, "1e9 N*m*s/rad"),
            (1e4, Frequency, "10 kHz"),
        ] {
            assert_eq!(format(value, dimension), text);
        }
    }

    proptest! {
        #[test]
        fn formatted_values_parse_back_to_the_same_bits(value in proptest::num::f64::NORMAL, index in 0usize..16) {
            let dimension = Dimension::ALL[index];
            // The allowed range in SI units, over all orders of magnitude.
            let value = if value.abs() > dimension.max_si() { value.recip() } else { value };
            prop_assume!(value.abs() <= dimension.max_si());
            let text = format(value, dimension);
            prop_assert_eq!(parse(&text, dimension).map(f64::to_bits), Ok(value.to_bits()), "{}", text);
        }

        #[test]
        fn parsing_never_panics(text in "\\PC{0,24}", index in 0usize..16) {
            let _ = parse(&text, Dimension::ALL[index]);
        }
    }
}
