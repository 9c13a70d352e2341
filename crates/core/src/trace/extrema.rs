//! Extrema within one step: their search, and the positions that get samples of their own, so that the samples alone
//! yield the same extrema as the summary of the run.

#[cfg(feature = "engine")]
use super::{ContactSample, ContactSummary};
#[cfg(feature = "engine")]
use crate::engine::ContactExtremum;

/// Deviation of a force from the parabola through its values at both ends of a step and its mean, as a multiple of the deviation
/// of the mean from that of a straight line; that of the parabola itself from the straight line is 1.5.
const MEAN_MARGIN: f64 = 3.0;

/// Whether a force with these values at the ends of a step and this mean may exceed `peak` in between.
pub(super) fn may_exceed(peak: f64, [start, end]: [f64; 2], mean: f64) -> bool {
    start.max(end) + MEAN_MARGIN * (mean - 0.5 * (start + end)).abs() > peak
}

/// Depth between the ends of a step, as a multiple of that of a convex gap: the tangents of a convex gap bound it.
const DEPTH_MARGIN: f64 = 2.0;

/// Whether a penetration with these depths and gap rates at the ends of a step of length `step_s` has a maximum in between that may
/// exceed `largest`.
pub(super) fn may_be_deeper(largest: f64, depths: [f64; 2], [before, after]: [f64; 2], step_s: f64) -> bool {
    let reaches = before < 0.0 && after > 0.0;
    reaches && depths[0].max(depths[1]) + DEPTH_MARGIN * step_s * before * after / (before - after) > largest
}

/// Whether a force is monotonic over a step: a parabola is, if its mean deviates from that of a straight line by less than a sixth
/// of the difference of its ends.
pub(super) fn is_monotonic([start, end]: [f64; 2], mean: f64) -> bool {
    6.0 * MEAN_MARGIN * (mean - 0.5 * (start + end)).abs() < (end - start).abs()
}

/// Number of bisections of a step; they locate a time to 1e-12 of its length.
pub(super) const BISECTIONS: u32 = 40;

/// Returns the zero in [0, 1] of a rate that starts positive and ends negative.
pub(super) fn bisect(rate: &mut dyn FnMut(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if rate(middle) > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Part of a step to which crossings are located; beyond them forces are interpolated.
const CROSSING_TOLERANCE: f64 = 1e-4;

/// Returns the zero in [0, 1] of a value with these values of opposite sign at the ends (Illinois method).
pub(super) fn find_crossing([at_start, at_end]: [f64; 2], value: &mut dyn FnMut(f64) -> f64) -> f64 {
    let ((mut a, mut at_a), (mut b, mut at_b)) = ((0.0_f64, at_start), (1.0, at_end));
    while (b - a).abs() > CROSSING_TOLERANCE {
        let next = (a * at_b - b * at_a) / (at_b - at_a);
        let (last, at_next) = (b, value(next));
        if (at_next > 0.0) == (at_b > 0.0) {
            at_a *= 0.5;
        } else {
            (a, at_a) = (b, at_b);
        }
        (b, at_b) = (next, at_next);
        if (next - last).abs() < CROSSING_TOLERANCE {
            break;
        }
    }
    b
}

/// Returns position and value of the largest value of a smooth function on [0, 1], found by successive parabolic
/// interpolation; the end values are given.
pub(super) fn parabola_peak(at_start: f64, at_end: f64, value: &mut dyn FnMut(f64) -> f64) -> (f64, f64) {
    let mut points = [(0.0, at_start), (0.5, value(0.5)), (1.0, at_end)];
    let greater_value = |a: (f64, f64), b: (f64, f64)| if b.1 > a.1 { b } else { a };
    let mut peak = points.into_iter().fold((0.0, f64::MIN), greater_value);
    for _ in 0..3 {
        let [(a, fa), (b, fb), (c, fc)] = points;
        let (p, q) = ((b - a) * (fb - fc), (b - c) * (fb - fa));
        let vertex = b - 0.5 * ((b - a) * p - (b - c) * q) / (p - q);
        if !(vertex > a && vertex < c) || (vertex - b).abs() < 1e-4 {
            break;
        }
        let at_vertex = value(vertex);
        peak = greater_value(peak, (vertex, at_vertex));
        points =
            if vertex < b { [(a, fa), (vertex, at_vertex), (b, fb)] } else { [(b, fb), (vertex, at_vertex), (c, fc)] };
        if at_vertex < fb {
            // Keep the larger of the two inner points as the middle point.
            points = if vertex < b {
                [(vertex, at_vertex), (b, fb), (c, fc)]
            } else {
                [(a, fa), (b, fb), (vertex, at_vertex)]
            };
        }
    }
    peak
}

/// Positions within one step at which a penetration or a contact force exceeds all earlier values: fractions of the
/// step, or times after its start, each with what is known there.
#[derive(Clone, Debug, Default)]
pub(super) struct StepExtrema<T> {
    /// Positions inside the step, in order of time after `sort`.
    inside: Vec<(f64, T)>,
    /// Whether there is also an extremum at the end of the step (analytic model).
    pub at_end: bool,
}

impl<T> StepExtrema<T> {
    pub fn clear(&mut self) {
        self.inside.clear();
        self.at_end = false;
    }

    pub fn sort(&mut self) {
        self.inside.sort_by(|a, b| a.0.total_cmp(&b.0));
    }

    /// Removes and returns the first extremum if it lies before a position.
    pub(crate) fn next_before(&mut self, position: f64) -> Option<(f64, T)> {
        self.inside.first().is_some_and(|(first, _)| *first < position).then(|| self.inside.remove(0))
    }

    /// Removes and returns the next extremum if it lies exactly at a position.
    pub(crate) fn next_at(&mut self, position: f64) -> Option<T> {
        self.inside.first().is_some_and(|(first, _)| *first == position).then(|| self.inside.remove(0).1)
    }
}

/// Why an instant within a step gets a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Reason {
    #[default]
    /// A force or a penetration exceeds all earlier ones.
    Peak,
    /// A force crosses the threshold of the criteria.
    Crossing,
}

impl StepExtrema<Reason> {
    /// Adds a fraction of the step; the start of the step is ignored.
    pub fn push(&mut self, theta: f64, reason: Reason) {
        if theta >= 1.0 {
            self.at_end = true;
        } else if theta > 0.0 {
            self.inside.push((theta, reason));
        }
    }
}

/// Fraction of a step beyond which an instant counts as the end of the step.
#[cfg(feature = "engine")]
const STEP_END: f64 = 1.0 - 1e-9;

/// Extrema of an engine step, each with the index of its contact.
#[cfg(feature = "engine")]
impl StepExtrema<(usize, ContactExtremum)> {
    /// Adds one contact over a step of length `dt_s`: its extrema within the step, if contact was solved by sub-steps,
    /// and force and penetration at the end.
    pub(crate) fn add_contact(
        &mut self,
        contact: usize,
        summary: &mut ContactSummary,
        within: Option<[ContactExtremum; 2]>,
        dt_s: f64,
        [force, depth]: [f64; 2],
    ) {
        if let Some([peak, deepest]) = within {
            // The geometry is frozen within a step, so extrema at its end are read from the end sample.
            let inside = |extremum: &ContactExtremum| extremum.after_s > 0.0 && extremum.after_s < STEP_END * dt_s;
            if inside(&peak) && summary.update_peak_force(peak.normal) {
                self.inside.push((peak.after_s, (contact, peak)));
            }
            if inside(&deepest) && summary.update_max_penetration(-deepest.gap) && deepest.after_s != peak.after_s {
                self.inside.push((deepest.after_s, (contact, deepest)));
            }
        }
        summary.update((force, depth));
    }
}

#[cfg(feature = "engine")]
impl ContactSample {
    /// Sets the values at an instant within a step; `impulse_n_s` is the impulse up to the start of the step.
    pub(super) fn set_extremum(&mut self, extremum: &ContactExtremum, impulse_n_s: f64) {
        (self.gap_m, self.gap_rate_m_s, self.slip_m_s) = (extremum.gap, extremum.gap_rate, extremum.slip);
        (self.normal_n, self.tangential_n) = (extremum.normal, extremum.tangential);
        self.impulse_n_s = impulse_n_s + extremum.impulse;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ends and mean of the parabola `start + slope θ + curvature θ²` over a step, and its largest value.
    fn parabola(start: f64, slope: f64, curvature: f64) -> ([f64; 2], f64, f64) {
        let at = |theta: f64| start + slope * theta + curvature * theta * theta;
        let largest = (0..=1000).map(|i| at(i as f64 / 1000.0)).fold(f64::MIN, f64::max);
        ([start, at(1.0)], start + slope / 2.0 + curvature / 3.0, largest)
    }

    #[test]
    fn the_bound_of_a_force_contains_parabolas_and_their_ends_where_they_are_monotonic() {
        for slope in [-8.0, -2.0, -0.1, 0.0, 0.3, 4.0] {
            for curvature in [-9.0, -1.0, 0.0, 0.05, 3.0] {
                let (ends, mean, largest) = parabola(5.0, slope, curvature);
                assert!(may_exceed(largest - 1e-6, ends, mean), "{slope} {curvature}");
                if is_monotonic(ends, mean) {
                    assert!(largest <= ends[0].max(ends[1]), "{slope} {curvature}");
                }
            }
        }
        let (ends, mean, _) = parabola(5.0, 1.0, -0.1);
        assert!(is_monotonic(ends, mean) && !may_exceed(6.0, ends, mean));
    }

    #[test]
    fn the_bound_of_a_depth_contains_the_maximum_of_a_parabola() {
        // Depth d + v θ h − a (θ h)² / 2, whose largest value is d + v² / (2 a).
        let (depth, speed, acceleration, step_s) = (1e-4, 0.2, 900.0, 5e-4);
        let end = depth + speed * step_s - 0.5 * acceleration * step_s * step_s;
        let rates = [-speed, acceleration * step_s - speed];
        let largest = depth + speed * speed / (2.0 * acceleration);
        assert!(may_be_deeper(0.99 * largest, [depth, end], rates, step_s));
        assert!(!may_be_deeper(3.0 * largest, [depth, end], rates, step_s));
        assert!(!may_be_deeper(0.0, [depth, end], [-0.1, -0.05], step_s), "it only gets deeper");
    }
}
