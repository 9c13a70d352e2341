//! Finding where within a step a guard gives way.

use std::cell::OnceCell;

use super::{Dense, Guard, Hybrid, Look, Strain};
use crate::numeric::each;
use crate::numeric::elementary::powi;

/// The earliest crossing of a step.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    pub site: usize,
    /// Fraction of the step, on the far side of the crossing.
    pub theta: f64,
    /// A later one at which the guard is seen to be negative: what dips may be back at the end of the step.
    pub beyond: f64,
}

/// Looks for the first guard that is negative anywhere in a step of size `h`, given the guards at both of its ends.
///
/// The end is always looked at; a gap that may have closed in between, as its rates at the ends tell, is looked at half way,
/// and where it is smallest, so that a link can neither step over a thin object nor graze it unseen; values without a rate are looked at
/// inside the step.
pub fn first_crossing<const N: usize, const Z: usize, const S: usize, Y: Hybrid<N, Z, S>>(
    system: &Y,
    mode: &Y::Mode,
    start: &[Guard<N>; S],
    end: &[Guard<N>; S],
    h: f64,
    dense: &dyn Fn() -> Dense<N, Z>,
) -> Option<Crossing> {
    let suspects: [bool; S] = each(|site| end[site].value < 0.0 || may_dip(&start[site], &end[site], h));
    if !suspects.contains(&true) {
        return None;
    }
    let dense = dense();
    let guard = |theta: f64, site: usize| {
        let state = dense.at(theta);
        system.glance(&state.q, &state.v, mode, site)
    };
    // Of all suspects at once: most steps ask no more.
    let values = |theta: f64, wanted: &[bool; S]| {
        let state = dense.at(theta);
        system.values(&state.q, &state.v, mode, wanted)
    };
    let looks: [Look; S] = each(|site| look(&start[site], &end[site]));
    let gaps = || each(|site| suspects[site] && looks[site] == Look::Gap);
    let (half_way, thirds) = (OnceCell::new(), OnceCell::new());
    let at_half = |site: usize| half_way.get_or_init(|| values(0.5, &gaps()))[site];
    let at_thirds = |site: usize| {
        let [a, b] = thirds.get_or_init(|| [values(THIRDS[0], &suspects), values(THIRDS[1], &suspects)]);
        [a[site], b[site]]
    };
    let mut first: Option<Crossing> = None;
    for site in (0..S).filter(|site| suspects[*site]) {
        let value = |theta: f64| guard(theta, site).value;
        let over = end[site].value < 0.0;
        let bracket = match looks[site] {
            Look::End => over.then_some((0.0, 1.0)),
            Look::Smooth | Look::Fading if !over && !bends(start[site].value, end[site].value, at_thirds(site)) => None,
            Look::Inside | Look::Smooth | Look::Fading => {
                let parting =
                    (end[site].apart && !start[site].apart).then(|| parting(&|theta| guard(theta, site).apart));
                first_dip(start[site].value, end[site].value, parting, &value)
            }
            Look::Gap if at_half(site) < 0.0 => Some((0.0, 0.5)),
            Look::Gap if over => Some((0.5, 1.0)),
            Look::Gap if start[site].rate < 0.0 && end[site].rate > 0.0 => {
                let lowest = lowest_point(&|theta| guard(theta, site).rate);
                (value(lowest) < 0.0).then_some((0.0, lowest))
            }
            Look::Gap => None,
        };
        let Some((low, high)) = bracket else { continue };
        // Where another guard has given way this one still holds: it is later, by however much.
        if first.is_some_and(|f| f.theta < high && value(f.theta * (1.0 - SAME)) >= 0.0) {
            continue;
        }
        let theta = root(&value, low, high);
        if first.is_none_or(|f| theta < f.theta) {
            first = Some(Crossing { site, theta, beyond: high });
        }
    }
    first
}

/// Whether a guard that holds at both ends could have given way in between: a gap could if it moved at twice the larger of its
/// end rates throughout; of others only a look inside can tell.
fn may_dip<const N: usize>(start: &Guard<N>, end: &Guard<N>, h: f64) -> bool {
    let least = start.value.min(end.value);
    match look(start, end) {
        Look::End => false,
        Look::Inside | Look::Smooth => least.is_finite(),
        Look::Fading => least.is_finite() && loses_depth(start, end),
        Look::Gap => start.value.is_finite() && least < 2.0 * h * start.rate.abs().max(end.rate.abs()),
    }
}

/// How a guard is to be looked at within a step: inside if either end asks for it.
fn look<const N: usize>(start: &Guard<N>, end: &Guard<N>) -> Look {
    if matches!(start.look, Look::Inside | Look::Fading) { start.look } else { end.look }
}

/// Whether a contact loses half of its depth in a step. In shorter ones the step follows it.
fn loses_depth<const N: usize>(start: &Guard<N>, end: &Guard<N>) -> bool {
    match (&start.strain, &end.strain) {
        (Strain::Depth { depth: before, .. }, Strain::Depth { depth: after, .. }) => *after < 0.5 * before,
        _ => true,
    }
}

/// Points at which a value without a rate is looked at within a step, its ends included.
const LOOKS: usize = 9;

/// Crossings nearer to each other than this part of their place in a step are one.
const SAME: f64 = 1e-9;

const THIRDS: [f64; 2] = [1.0 / 3.0, 2.0 / 3.0];

/// Whether a value between these ends bends so much, at the thirds between them, that it might dip below zero elsewhere.
fn bends(start: f64, end: f64, thirds: [f64; 2]) -> bool {
    let straight = |theta: f64| start + theta * (end - start);
    let bend = (thirds[0] - straight(THIRDS[0])).abs().max((thirds[1] - straight(THIRDS[1])).abs());
    let least = start.min(end).min(thirds[0]).min(thirds[1]);
    // What is no number bends.
    least < 4.0 * bend || !(least - bend).is_finite()
}

/// Looks on the way to where surfaces part, each at a part of what the one before leaves: a damper that fades with the depth leaves
/// the last of it to the spring, whose force returns as late as it likes.
const PARTING_LOOKS: i32 = 12;
const PARTING_PART: f64 = 0.25;

/// A bracket about the first place where a value gives way that may dip and come back between its ends; `parting`: where the
/// surfaces part.
fn first_dip(start: f64, end: f64, parting: Option<f64>, value: &dyn Fn(f64) -> f64) -> Option<(f64, f64)> {
    let place = |i: usize| i as f64 / (LOOKS - 1) as f64;
    let at: [f64; LOOKS] = std::array::from_fn(|i| match i {
        0 => start,
        i if i == LOOKS - 1 => end,
        i => value(place(i)),
    });
    let below = (1..LOOKS).find(|i| at[*i] < 0.0);
    // A dip between two points, before the first that is below: also one about an end, whose own value is the lowest of those looked at.
    for i in 0..below.unwrap_or(LOOKS) {
        let (before, after) = (i.saturating_sub(1), (i + 1).min(LOOKS - 1));
        let middle = i.clamp(1, LOOKS - 2);
        let bend = at[middle - 1].max(at[middle + 1]) - at[i];
        if at[i] <= at[before] && at[i] <= at[after] && at[i] < 4.0 * bend {
            let lowest = golden(value, place(before), place(after));
            if value(lowest) < 0.0 {
                return Some((place(before), lowest));
            }
        }
    }
    let evenly = below.map(|i| (place(i - 1), place(i)));
    evenly.or_else(|| {
        let end = parting?;
        let near = |look: i32| end * (1.0 - powi(PARTING_PART, look));
        (1..PARTING_LOOKS).find(|look| value(near(*look)) < 0.0).map(|look| (near(look - 1), near(look)))
    })
}

/// Where surfaces part that are together at the start of a step and apart at its end.
fn parting(apart: &dyn Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while high - low > 4.0 * f64::EPSILON * high {
        let middle = 0.5 * (low + high);
        if apart(middle) { high = middle } else { low = middle }
    }
    low
}

/// Where a value with one minimum between two places is smallest (golden section).
fn golden(value: &dyn Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    const SECTION: f64 = 0.618_033_988_749_894_9;
    let (mut a, mut b) = (high - SECTION * (high - low), low + SECTION * (high - low));
    let (mut at_a, mut at_b) = (value(a), value(b));
    for _ in 0..20 {
        if at_a < 0.0 {
            return a;
        }
        if at_b < 0.0 {
            return b;
        }
        if at_a < at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - SECTION * (high - low);
            at_a = value(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + SECTION * (high - low);
            at_b = value(b);
        }
    }
    if at_a < at_b { a } else { b }
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
fn lowest_point(rate: &dyn Fn(f64) -> f64) -> f64 {
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
fn root(value: &dyn Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
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
    use crate::state::State;
    use crate::system::{Linearised, Rates, System, Watch};

    /// Something that moves evenly past marks, in no mode.
    struct Marks([f64; 3]);

    impl System<1, 0> for Marks {
        type Mode = ();

        fn rates(&self, _: f64, _: &[f64; 1], _: &[f64; 1], (): &()) -> Rates<1, 0> {
            Rates { a: [0.0], g: [] }
        }

        fn linearise(&self, t: f64, q: &[f64; 1], v: &[f64; 1], mode: &()) -> Linearised<1, 0> {
            let rates = self.rates(t, q, v, mode);
            Linearised { rates, a_q: [[0.0]], a_v: [[0.0]], a_t: [0.0], g_q: [], g_v: [], g_t: [] }
        }
    }

    impl Hybrid<1, 0, 3> for Marks {
        fn next_corner(&self, _: f64) -> f64 {
            f64::INFINITY
        }

        fn watch(&self, q: &[f64; 1], _: &[f64; 1], (): &()) -> Watch<1, 3> {
            let guards = self.0.map(|mark| Guard { value: mark - q[0], ..Guard::QUIET });
            Watch { guards, clearance: f64::INFINITY, clearance_rate: 0.0 }
        }

        fn landing_tolerance(&self, _: usize, (): &()) -> f64 {
            0.0
        }

        fn switch(&self, _: usize, _: &[f64; 1], _: &[f64; 1], (): &()) {}

        fn relax(&self, _: &[Guard<1>; 3], (): &()) -> Option<()> {
            None
        }

        fn with_natural(&self, _: usize, (): &()) {}

        fn read_mode(&self, _: f64, _: &[f64; 1], _: &[f64; 1]) {}

        fn restart_step(&self, _: usize, _: &[f64; 1], _: &[f64; 1], (): &()) -> Option<f64> {
            None
        }

        fn obstacle(&self, _: &[f64; 1]) -> String {
            String::new()
        }
    }

    #[test]
    fn the_first_of_several_crossings_is_found_whichever_comes_first_among_the_guards() {
        let state = |q: f64| State { q: [q], v: [1.0], z: [] };
        let (start, end, still) = (state(0.0), state(1.0), State { q: [0.0], v: [0.0], z: [] });
        let dense = || Dense { t0: 0.0, h: 1.0, start, end, d: [still; 3] };
        for (marks, site, theta) in
            [([0.3, 0.6, 2.0], 0, 0.3), ([0.6, 0.3, 0.9], 1, 0.3), ([0.9, 0.6, 0.3], 2, 0.3), ([2.0, 0.7, 0.7], 1, 0.7)]
        {
            let system = Marks(marks);
            let [before, after] = [&start, &end].map(|at| system.watch(&at.q, &at.v, &()).guards);
            let first = first_crossing(&system, &(), &before, &after, 1.0, &dense).expect("a crossing");
            assert_eq!(first.site, site, "{marks:?}");
            assert!((first.theta - theta).abs() < 1e-12, "{marks:?}: {first:?}");
        }
    }

    #[test]
    fn root_finds_smooth_and_jumping_guards() {
        let smooth = root(&|x| 0.3 - x * x, 0.0, 1.0);
        assert!((smooth - 0.3f64.sqrt()).abs() < 1e-9, "{smooth}");
        let jump = root(&|x| if x < 0.7 { 5.0 } else { -1.0 }, 0.0, 1.0);
        assert!((jump - 0.7).abs() < 1e-9 && jump >= 0.7, "{jump}");
    }

    #[test]
    fn dips_are_found_between_the_points_that_are_looked_at() {
        for place in [0.03, 0.31, 0.5, 0.77, 0.97] {
            let narrow = |x: f64| (x - place) * (x - place) - 1e-5;
            let (low, high) = first_dip(narrow(0.0), narrow(1.0), None, &narrow).expect("a dip");
            assert!(
                narrow(low) >= 0.0 && narrow(high) < 0.0 && high > place - 4e-3 && low < place,
                "{place}: {low} {high}"
            );
            let above = |x: f64| narrow(x) + 2e-5;
            assert!(first_dip(above(0.0), above(1.0), None, &above).is_none(), "{place}");
        }
        assert_eq!(first_dip(1.0, -1.0, None, &|x| 1.0 - 2.0 * x), Some((0.5, 0.625)));
    }

    /// A linear spring behind a damper that fades with the square of the depth: its force returns in the last 1e-5 of the way.
    #[test]
    fn forces_that_return_just_before_surfaces_part_are_found() {
        let parts = 0.7;
        let force = |x: f64| {
            let delta = (parts - x).max(0.0);
            delta - 1e5 * delta * delta
        };
        let value = |x: f64| 1e-9 - force(x);
        let parting = parting(&|x| x > parts);
        assert!((parting - parts).abs() < 1e-12);
        let (low, high) = first_dip(value(0.0), value(1.0), Some(parting), &value).expect("a return");
        assert!(value(low) >= 0.0 && value(high) < 0.0 && high > parts - 1e-5);
    }

    #[test]
    fn root_that_is_met_exactly_is_returned() {
        assert_eq!(root(&|x| 0.75 - x, 0.5, 1.0), 0.75);
    }

    #[test]
    fn a_value_is_looked_at_closely_where_it_bends_enough_to_dip() {
        let look = |value: fn(f64) -> f64| bends(value(0.0), value(1.0), THIRDS.map(value));
        assert!(!look(|x| 1.0 + x), "straight");
        assert!(!look(|x| 1.0 + 0.1 * x * (1.0 - x)), "hardly bent");
        assert!(look(|x| 1.0 - 4.4 * x * (1.0 - x)), "dips below zero half way");
        assert!(look(|x| 1.0 + 15.0 * x * (x - 0.5) * (x - 1.0)), "as much above half way as below");
        assert!(look(|x| if x > 0.5 { f64::NAN } else { 1.0 }), "no number");
    }
}
