//! SI to text that parses back to the same bits.

use super::parse::parse;
use super::{Dimension, Unit, number};

/// Units in the last place tried around the quotient before a unit is given up.
const NEIGHBOURS: i64 = 4;

/// A text of a finite value that [`parse`] turns into the same bits again.
///
/// Of the shown units, one that gives a number from 1 to 1000 is preferred, then the shortest text, then the unit later
/// in the list.
pub fn format(value_si: f64, dimension: Dimension) -> String {
    let candidates = dimension.units().iter().filter(|u| u.shown);
    candidates
        .filter_map(|unit| exact(value_si, unit, dimension))
        .rev()
        .min_by_key(|(text, handy)| (!handy, text.len()))
        .map(|(text, _)| text)
        .unwrap_or_else(|| format!("{} {}", number(value_si), dimension.units()[0].name))
}

/// Text of `value_si` in `unit`, if some decimal there gives back its bits, and whether that is a handy number.
fn exact(value_si: f64, unit: &Unit, dimension: Dimension) -> Option<(String, bool)> {
    let factor = unit.factor;
    let quotient = if factor == 1.0 { value_si } else { value_si / factor };
    let handy = (1.0..1000.0).contains(&quotient.abs());
    let mut best: Option<String> = None;
    for step in -NEIGHBOURS..=NEIGHBOURS {
        let neighbour = f64::from_bits(quotient.to_bits().wrapping_add_signed(step));
        let text = format!("{} {}", number(neighbour), unit.name);
        let same = parse(&text, dimension).is_ok_and(|back| back.to_bits() == value_si.to_bits());
        if same && best.as_ref().is_none_or(|b| text.len() < b.len()) {
            best = Some(text);
        }
    }
    best.map(|text| (text, handy))
}

#[cfg(test)]
mod tests {
    use super::Dimension::*;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn usual_values_are_shown_in_usual_units() {
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
        fn any_finite_value_comes_back_bit_for_bit(value in proptest::num::f64::NORMAL, index in 0usize..16) {
            let dimension = Dimension::ALL[index];
            // Everything that may be written in a scene, over all sizes.
            let value = if value.abs() > dimension.largest_si() { value.recip() } else { value };
            prop_assume!(value.abs() <= dimension.largest_si());
            let text = format(value, dimension);
            prop_assert_eq!(parse(&text, dimension).map(f64::to_bits), Ok(value.to_bits()), "{}", text);
        }

        #[test]
        fn any_text_is_read_or_refused_without_panic(text in "\\PC{0,24}", index in 0usize..16) {
            let _ = parse(&text, Dimension::ALL[index]);
        }
    }
}
