//! Colour scales: mapping of values to colours, interpolated between stops.

use super::theme::{Colour, GREEN};

/// Stops from the smallest to the largest value: viridis (van der Walt and Smith) without its dark end, which would
/// resemble the unstable region.
pub const SEQUENTIAL: [Colour; 6] = [
    Colour(71, 72, 142),
    Colour(49, 107, 142),
    Colour(31, 146, 139),
    Colour(60, 180, 112),
    Colour(144, 214, 66),
    Colour(253, 231, 37),
];
/// Stops for negative values, ascending.
pub const NEGATIVE: [Colour; 3] = [Colour(184, 74, 0), Colour(240, 150, 66), Colour(255, 224, 190)];
/// Stops for positive values, ascending. They differ from [`NEGATIVE`] at zero, which makes the sign visible.
pub const POSITIVE: [Colour; 3] = [Colour(196, 226, 245), Colour(74, 160, 212), Colour(0, 92, 158)];
/// Colours of false and true.
pub const FLAG: [Colour; 2] = [Colour(222, 226, 232), GREEN];

/// Number of steps of a scale. More would not be distinguishable; adjacent tiles of equal colour are drawn as one.
const STEPS: f64 = 40.0;

/// Mapping of values to colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// Between the smallest and the largest value.
    Range {
        from: f64,
        to: f64,
    },
    /// Symmetric about zero; values below `-limit` have the colour of `-limit`.
    Signed {
        limit: f64,
    },
    Flag,
}

impl Scale {
    /// Scale from the smallest to the largest value. If the sign matters, the scale is symmetric about zero; its limit
    /// is the largest value, since values below the negative limit need not be distinguished.
    pub fn from_values(values: impl Iterator<Item = f64>, is_signed: bool) -> Scale {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        match () {
            () if low > high => Scale::Range { from: 0.0, to: 1.0 },
            () if is_signed => {
                Scale::Signed { limit: if high > 0.0 { high } else { low.abs().max(f64::MIN_POSITIVE) } }
            }
            () if high > low => Scale::Range { from: low, to: high },
            () => Scale::Range { from: low - 0.5 * low.abs().max(1e-12), to: high + 0.5 * high.abs().max(1e-12) },
        }
    }

    /// Returns the smallest and the largest value with a distinct colour.
    pub fn range(&self) -> [f64; 2] {
        match *self {
            Scale::Range { from, to } => [from, to],
            Scale::Signed { limit } => [-limit, limit],
            Scale::Flag => [0.0, 1.0],
        }
    }

    pub fn colour(&self, value: f64) -> Colour {
        match *self {
            Scale::Range { from, to } => interpolate_stops(&SEQUENTIAL, (value - from) / (to - from)),
            Scale::Signed { limit } if value < 0.0 => interpolate_stops(&NEGATIVE, 1.0 + value / limit),
            Scale::Signed { limit } => interpolate_stops(&POSITIVE, value / limit),
            Scale::Flag => FLAG[usize::from(value > 0.5)],
        }
    }
}

fn interpolate_stops(stops: &[Colour], fraction: f64) -> Colour {
    let step = (fraction.clamp(0.0, 1.0) * STEPS).round() / STEPS;
    let position = step * (stops.len() - 1) as f64;
    let below = (position as usize).min(stops.len() - 2);
    let (low, high, share) = (stops[below], stops[below + 1], position - below as f64);
    let channel = |from: u8, to: u8| (f64::from(from) + share * (f64::from(to) - f64::from(from))).round() as u8;
    Colour(channel(low.0, high.0), channel(low.1, high.1), channel(low.2, high.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_show_the_sign_and_clamp_at_the_ends() {
        let scale = Scale::from_values([-100.0, 3.0, 20.0].into_iter(), true);
        assert_eq!(scale, Scale::Signed { limit: 20.0 });
        assert_eq!(scale.colour(-1e-9), NEGATIVE[2]);
        assert_eq!(scale.colour(0.0), POSITIVE[0]);
        assert_eq!(scale.colour(20.0), POSITIVE[2]);
        assert_eq!((scale.colour(-20.0), scale.colour(-100.0)), (NEGATIVE[0], NEGATIVE[0]));
        let scale = Scale::from_values([2.0, 4.0].into_iter(), false);
        assert_eq!((scale.colour(2.0), scale.colour(4.0)), (SEQUENTIAL[0], SEQUENTIAL[5]));
    }

    #[test]
    fn scale_of_one_or_no_value_is_not_empty() {
        for values in [vec![], vec![0.0], vec![-3.0]] {
            for signed in [false, true] {
                let [from, to] = Scale::from_values(values.iter().copied(), signed).range();
                assert!(from < to, "{values:?}");
            }
        }
    }
}
