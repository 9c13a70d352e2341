//! Finding where within a step a guard gives way.

use super::{Dense, Hybrid};

/// The earliest crossing of a step.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    pub site: usize,
    /// Fraction of the step, on the far side of the crossing.
    pub theta: f64,
}

/// Steps longer than this are sampled inside as well, for guards whose rate is unknown.
const SAMPLED_FROM_S: f64 = 1e-6;

/// Looks for the first guard that is negative anywhere in the step.
///
/// The end is always looked at; a gap whose rate turns from closing to opening is looked at where it is smallest; a long
/// step is looked at half way too. So a link can neither step over a thin object nor graze it unseen.
pub fn first_crossing<const N: usize, const Z: usize, const S: usize, Y: Hybrid<N, Z, S>>(
    system: &Y,
    mode: &Y::Mode,
    dense: &Dense<N, Z>,
) -> Option<Crossing> {
    let guards = |theta: f64| {
        let state = dense.at(theta);
        system.guards(dense.t0 + theta * dense.h, &state.q, &state.v, mode)
    };
    let start = system.guards(dense.t0, &dense.start.q, &dense.start.v, mode);
    let end = system.guards(dense.end_time(), &dense.end.q, &dense.end.v, mode);
    let middle = if dense.h > SAMPLED_FROM_S {
        Some(guards(0.5))
    } else {
        None
    };
    let mut first: Option<Crossing> = None;
    for site in 0..S {
        let outside = |g: &[super::Guard; S]| g[site].value < 0.0;
        let inside = middle.as_ref().filter(|m| m[site].interpolates);
        let bracket = match inside {
            Some(m) if outside(m) => Some((0.0, 0.5)),
            _ if outside(&end) => Some((if inside.is_some() { 0.5 } else { 0.0 }, 1.0)),
            _ if start[site].rate < 0.0 && end[site].rate > 0.0 => {
                let lowest = lowest_point(|theta| guards(theta)[site].rate);
                (guards(lowest)[site].value < 0.0).then_some((0.0, lowest))
            }
            _ => None,
        };
        if let Some((low, high)) = bracket {
            let theta = root(|theta| guards(theta)[site].value, low, high);
            if first.is_none_or(|f| theta < f.theta) {
                first = Some(Crossing { site, theta });
            }
        }
    }
    first
}

/// Where a rate turns from negative to positive.
fn lowest_point(rate: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if rate(middle) < 0.0 {
            low = middle
        } else {
            high = middle
        }
    }
    0.5 * (low + high)
}

/// The far end of a tight bracket about the root of `value`, which is not negative at `low` and negative at `high`.
///
/// Illinois' variant of regula falsi, with bisection when it is slow: the guard of a clamp may jump.
fn root(value: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let (mut at_low, mut at_high) = (value(low).max(0.0), value(high));
    let mut kept = 0;
    for iteration in 0..80 {
        if high - low <= 4.0 * f64::EPSILON * high || at_high > -1e-300 {
            break;
        }
        let guess = if iteration % 4 == 3 {
            0.5 * (low + high)
        } else {
            low + (high - low) * at_low / (at_low - at_high)
        };
        let guess = if guess > low && guess < high {
            guess
        } else {
            0.5 * (low + high)
        };
        let at = value(guess);
        if at < 0.0 {
            let progress = at / at_high;
            (high, at_high) = (guess, at);
            if kept == 1 {
                at_low *= 0.5;
            }
            kept = 1;
            if progress < 1e-9 {
                break;
            }
        } else {
            (low, at_low) = (guess, at);
            if kept == -1 {
                at_high *= 0.5;
            }
            kept = -1;
            if at == 0.0 {
                break;
            }
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn root_finds_smooth_and_jumping_guards() {
        let smooth = root(|x| 0.3 - x * x, 0.0, 1.0);
        assert!((smooth - 0.3f64.sqrt()).abs() < 1e-9, "{smooth}");
        let jump = root(|x| if x < 0.7 { 5.0 } else { -1.0 }, 0.0, 1.0);
        assert!((jump - 0.7).abs() < 1e-9 && jump >= 0.7, "{jump}");
    }
}
