//! Colour scales of a quantity: from a value to a colour, and the stops between which colours are mixed.

use super::theme::{Colour, GREEN};

/// From the least to the largest: viridis (van der Walt and Smith) without its dark end, which would look like the unstable
/// region.
pub const SEQUENTIAL: [Colour; 6] = [
    Colour(71, 72, 142),
    Colour(49, 107, 142),
    Colour(31, 146, 139),
    Colour(60, 180, 112),
    Colour(144, 214, 66),
    Colour(253, 231, 37),
];
/// Below zero, from far to near, and above it from near to far: they do not meet, so that the sign is seen.
pub const NEGATIVE: [Colour; 3] = [Colour(184, 74, 0), Colour(240, 150, 66), Colour(255, 224, 190)];
pub const POSITIVE: [Colour; 3] = [Colour(196, 226, 245), Colour(74, 160, 212), Colour(0, 92, 158)];
/// No and yes.
pub const FLAG: [Colour; 2] = [Colour(222, 226, 232), GREEN];

/// Steps of a scale: finer ones would not be told apart, and equal neighbours are drawn as one.
const STEPS: f64 = 40.0;

/// How values become colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// Between the least and the largest value.
    Range {
        from: f64,
        to: f64,
    },
    /// Both ways from zero; what is below `-limit` has the colour of the end.
    Signed {
        limit: f64,
    },
    Flag,
}

impl Scale {
    /// From the least to the largest value. A quantity of which the sign counts reaches as far below zero as above: what is
    /// further down is as bad.
    pub fn of(values: impl Iterator<Item = f64>, signed: bool) -> Scale {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        match () {
            () if low > high => Scale::Range { from: 0.0, to: 1.0 },
            () if signed => Scale::Signed { limit: if high > 0.0 { high } else { low.abs().max(f64::MIN_POSITIVE) } },
            () if high > low => Scale::Range { from: low, to: high },
            () => Scale::Range { from: low - 0.5 * low.abs().max(1e-12), to: high + 0.5 * high.abs().max(1e-12) },
        }
    }

    /// The least and the largest value with a colour of their own.
    pub fn ends(&self) -> [f64; 2] {
        match *self {
            Scale::Range { from, to } => [from, to],
            Scale::Signed { limit } => [-limit, limit],
            Scale::Flag => [0.0, 1.0],
        }
    }

    pub fn colour(&self, value: f64) -> Colour {
        match *self {
            Scale::Range { from, to } => mixed(&SEQUENTIAL, (value - from) / (to - from)),
            Scale::Signed { limit } if value < 0.0 => mixed(&NEGATIVE, 1.0 + value / limit),
            Scale::Signed { limit } => mixed(&POSITIVE, value / limit),
            Scale::Flag => FLAG[usize::from(value > 0.5)],
        }
    }
}

fn mixed(stops: &[Colour], part: f64) -> Colour {
    let step = (part.clamp(0.0, 1.0) * STEPS).round() / STEPS;
    let place = step * (stops.len() - 1) as f64;
    let below = (place as usize).min(stops.len() - 2);
    let (low, high, share) = (stops[below], stops[below + 1], place - below as f64);
    let channel = |from: u8, to: u8| (f64::from(from) + share * (f64::from(to) - f64::from(from))).round() as u8;
    Colour(channel(low.0, high.0), channel(low.1, high.1), channel(low.2, high.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_is_seen_and_ends_have_their_colours() {
        let scale = Scale::of([-100.0, 3.0, 20.0].into_iter(), true);
        assert_eq!(scale, Scale::Signed { limit: 20.0 });
        assert_eq!(scale.colour(-1e-9), NEGATIVE[2]);
        assert_eq!(scale.colour(0.0), POSITIVE[0]);
        assert_eq!(scale.colour(20.0), POSITIVE[2]);
        assert_eq!((scale.colour(-20.0), scale.colour(-100.0)), (NEGATIVE[0], NEGATIVE[0]));
        let scale = Scale::of([2.0, 4.0].into_iter(), false);
        assert_eq!((scale.colour(2.0), scale.colour(4.0)), (SEQUENTIAL[0], SEQUENTIAL[5]));
    }

    #[test]
    fn one_value_or_none_has_a_scale_too() {
        for values in [vec![], vec![0.0], vec![-3.0]] {
            for signed in [false, true] {
                let [from, to] = Scale::of(values.iter().copied(), signed).ends();
                assert!(from < to, "{values:?}");
            }
        }
    }
}
