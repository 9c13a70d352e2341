//! Formats values in SI units as text that parses back to the same bits.

use super::parse::parse;
use super::{Dimension, Unit};

/// Neighbours of the quotient, in units in the last place, tried before a unit is rejected.
const NEIGHBOURS: i64 = 4;

/// Formats a finite value such that [`parse`] returns the same bits.
///
/// Among the shown units it prefers one that gives a number from 1 to 1000, then the shortest text, then the unit later
/// in the list.
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

/// Returns the shortest decimal that parses back to the number, plain or with an exponent.
pub fn number(value: f64) -> String {
    let (plain, exponent) = (format!("{value}"), format!("{value:e}"));
    if plain.len() <= exponent.len() + 2 { plain } else { exponent }
}

#[cfg(test)]
mod tests {
    use super::Dimension::*;
    use super::*;
    use proptest::prelude::*;

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
