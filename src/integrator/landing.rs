//! Finding where within a step a guard gives way.

use super::{Dense, Guard, Hybrid};

/// The earliest crossing of a step.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    pub site: usize,
    /// Fraction of the step, on the far side of the crossing.
    pub theta: f64,
}

/// Looks for the first guard that is negative anywhere in a step of size `h`, given the guards at both of its ends.
///
/// The end is always looked at; a gap that may have closed in between, as its rates at the ends tell, is looked at half way,
/// and where it is smallest. So a link can neither step over a thin object nor graze it unseen.
pub fn first_crossing<const N: usize, const Z: usize, const S: usize, Y: Hybrid<N, Z, S>>(
    system: &Y,
    mode: &Y::Mode,
    start: &[Guard; S],
    end: &[Guard; S],
    h: f64,
    dense: impl Fn() -> Dense<N, Z>,
) -> Option<Crossing> {
    let suspect = |site: usize| end[site].value < 0.0 || may_dip(&start[site], &end[site], h);
    if !(0..S).any(suspect) {
        return None;
    }
    let dense = dense();
    let guard = |theta: f64, site: usize| {
        let state = dense.at(theta);
        system.watch(&state.q, &state.v, mode).guards[site]
    };
    let mut first: Option<Crossing> = None;
    for site in (0..S).filter(|site| suspect(*site)) {
        let inside = if end[site].interpolates { guard(0.5, site).value } else { f64::INFINITY };
        let bracket = if inside < 0.0 {
            Some((0.0, 0.5))
        } else if end[site].value < 0.0 {
            Some((if end[site].interpolates { 0.5 } else { 0.0 }, 1.0))
        } else if start[site].rate < 0.0 && end[site].rate > 0.0 {
            let lowest = lowest_point(|theta| guard(theta, site).rate);
            (guard(lowest, site).value < 0.0).then_some((0.0, lowest))
        } else {
            None
        };
        if let Some((low, high)) = bracket {
            let theta = root(|theta| guard(theta, site).value, low, high);
            if first.is_none_or(|f| theta < f.theta) {
                first = Some(Crossing { site, theta });
            }
        }
    }
    first
}

/// Whether a gap that is open at both ends could have closed in between: it could if it moved at twice the larger of its end
/// rates throughout.
fn may_dip(start: &Guard, end: &Guard, h: f64) -> bool {
    start.interpolates
        && start.value.is_finite()
        && start.value.min(end.value) < 2.0 * h * start.rate.abs().max(end.rate.abs())
}

/// Whether a quantity with these end values and rates may have passed below zero within a step of size `h`: its cubic does.
///
/// A linkage that meets a fold of its loop bounces off it numerically, though in truth it snaps through: the rate jumps from
/// closing to opening, and the cubic through both ends dips under the fold.
pub fn may_have_passed(start: (f64, f64), end: (f64, f64), h: f64) -> bool {
    const SAMPLES: usize = 16;
    let ((y0, r0), (y1, r1)) = (start, end);
    r0 < 0.0
        && r1 > 0.0
        && (1..SAMPLES).any(|i| {
            let x = i as f64 / SAMPLES as f64;
            let (up, down) = (x * x, (1.0 - x) * (1.0 - x));
            down * ((1.0 + 2.0 * x) * y0 + x * h * r0) + up * ((3.0 - 2.0 * x) * y1 - (1.0 - x) * h * r1) < 0.0
        })
}

/// Where a rate turns from negative to positive.
fn lowest_point(rate: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if rate(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The far end of a tight bracket about the root of `value`, which is not negative at `low` and negative at `high`; the root
/// itself where it is met exactly.
///
/// Illinois' variant of regula falsi, with bisection when it is slow: the guard of a clamp may jump.
fn root(value: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let (mut at_low, mut at_high) = (value(low).max(0.0), value(high));
    let mut kept = 0;
    for iteration in 0..80 {
        if high - low <= 4.0 * f64::EPSILON * high || at_high > -1e-300 {
            break;
        }
        let guess =
            if iteration % 4 == 3 { 0.5 * (low + high) } else { low + (high - low) * at_low / (at_low - at_high) };
        let guess = if guess > low && guess < high { guess } else { 0.5 * (low + high) };
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
                // Exactly on it: the old far end would be far off.
                return guess;
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

    #[test]
    fn root_that_is_met_exactly_is_returned() {
        assert_eq!(root(|x| 0.75 - x, 0.5, 1.0), 0.75);
    }
}
