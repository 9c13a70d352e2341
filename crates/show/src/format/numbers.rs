//! Numbers with a given number of significant digits, and durations.

use crate::units::Dimension;
pub use crate::units::G_M_S2;

/// Converts strings to the cells of a row.
pub fn row<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.map(String::from).to_vec()
}

/// Formats a number with `digits` significant digits. From 1e-3 to 1e6 it has no exponent, beyond this range it has
/// one.
pub fn format_number(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".to_string();
    }
    if !value.is_finite() {
        return "–".to_string();
    }
    let decimals = digits.saturating_sub(1);
    // The exponent is that of the rounded number: 9.9996 with four digits becomes 10.00.
    let scientific = format!("{value:.decimals$e}");
    let exponent: i32 = scientific.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0);
    if !(-3..6).contains(&exponent) {
        return scientific;
    }
    let places = usize::try_from(decimals as i32 - exponent).unwrap_or(0);
    format!("{value:.places$}")
}

/// Formats a value; a missing value is a dash.
pub fn or_dash<T>(value: Option<T>, format: impl FnOnce(T) -> String) -> String {
    value.map_or("–".to_string(), format)
}

/// Returns a result in SI units, or 0 if it is below the resolution of its dimension, because its digits would then be
/// rounding errors. JSON documents contain the unrounded value.
pub fn zero_below_resolution(value_si: f64, dimension: Dimension) -> f64 {
    if value_si.abs() < dimension.resolution_si() { 0.0 } else { value_si }
}

/// Formats a duration in s, ms or µs, depending on its size.
pub fn format_duration(time_s: f64) -> String {
    let (value, unit) = match time_s {
        t if t >= 1.0 => (t, "s"),
        t if t >= 1e-3 || t == 0.0 => (t * 1e3, "ms"),
        t => (t * 1e6, "µs"),
    };
    // Six digits without trailing zeros.
    let text = format_number(value, 6);
    let text = match text.contains('.') && !text.contains('e') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    format!("{text} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_numbers_with_significant_digits() {
        for (value, expected) in [
            (0.0, "0"),
            (23.60921, "23.609"),
            (9.99996, "10.000"),
            (-0.0012345678, "-0.0012346"),
            (98765.4321, "98765"),
            (1.5e-9, "1.5000e-9"),
            (f64::INFINITY, "–"),
        ] {
            assert_eq!(format_number(value, 5), expected);
        }
    }

    #[test]
    fn selects_the_unit_of_a_duration_by_its_size() {
        for (time_s, expected) in [
            (20e-3, "20 ms"),
            (10.0, "10 s"),
            (1.5, "1.5 s"),
            (412e-6, "412 µs"),
            (4.501317e-3, "4.50132 ms"),
            (0.0, "0 ms"),
        ] {
            assert_eq!(format_duration(time_s), expected);
        }
    }
}
