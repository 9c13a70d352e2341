//! The integration methods with fixed steps: their order of convergence, and stiffness.
//!
//! Order: q1 = sin t + 0.3 cos 2t and q2 = cos 1.3t solve the nonlinear, time-dependent problem q̈1 = −q1³ + q2 q̇1 + p1(t),
//! q̈2 = −sin(q1) q̇2 − q2 + p2(t), with p chosen accordingly. Theory: both implicit methods are of order 5; the dense output of
//! Rodas5P is of order 4 (its error within one step falls as h⁵), the cubic collocation polynomial of Radau IIA of order
//! 3 (h⁴). DOP853 has orders 8 and 7. Stiffness: both implicit methods damp fast components and preserve slow ones, at steps far beyond the fast time scale.

use crate::wall::{OneMass, PointMass, mass_at, run_from};
use phalanx_integrator::{
    Attempt, Dense, Dop853, Fixed, FixedMatrix, Layout, Linearised, Method, Options, Radau5, Rates, Refinement,
    Rodas5p, State, StepStart, System, Tolerances,
};

/// Tight enough for Radau's Newton iteration to go down to rounding.
const TIGHT: Tolerances = Tolerances { atol_q: 1e-15, atol_v: 1e-15, rtol_v: 1e-15 };

/// Steps of DOP853 are complete only if their error is acceptable.
const LOOSE: Tolerances = Tolerances { atol_q: 1e3, atol_v: 1e3, rtol_v: 1e3 };

/// Memory for an attempt and its dense output.
fn step_memory<L: Layout>(layout: L) -> (Attempt<L>, Dense<L>) {
    let zero = || State::zero(layout);
    let (error_q, error_v) = (layout.vector(0.0), layout.vector(0.0));
    let attempt = Attempt { error: 0.0, rhs: 0, end: zero(), error_q, error_v };
    (attempt, Dense { t0: 0.0, h: 0.0, start: zero(), end: zero(), d: std::array::from_fn(|_| zero()), terms: 0 })
}

/// Takes `count` steps of size `h` and passes the dense output of every step to `visit`.
fn march<K: Method<Y::Layout>, Y: System>(
    system: &Y,
    mode: &Y::Mode,
    from: (f64, State<Y::Layout>),
    h: f64,
    count: usize,
    mut visit: impl FnMut(&Dense<Y::Layout>),
) -> State<Y::Layout> {
    let (t0, mut state) = from;
    let layout = system.layout();
    let (mut method, mut linearised) = (K::new(layout), Linearised::zero(layout));
    let tolerances = if method.error_order() > 5.0 { &LOOSE } else { &TIGHT };
    let (mut attempt, mut dense) = step_memory(layout);
    for i in 0..count {
        let t = t0 + i as f64 * h;
        system.linearise(t, &state.q, &state.v, mode, &mut linearised);
        let start_point = StepStart {
            system,
            mode,
            linearised: &linearised,
            tolerances,
            t,
            latest_time: f64::INFINITY,
            state: &state,
        };
        method.attempt(&start_point, h, &mut attempt);
        assert!(!attempt.error.is_nan(), "a step of {h} failed at {t}");
        method.accept_step();
        method.dense(Some(&linearised), &mut dense);
        visit(&dense);
        state.copy_from(&attempt.end);
    }
    state
}

/// Slopes of log error over log step size between successive halvings.
fn slopes(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect()
}

struct ForcedOscillators;

/// q and its first three derivatives.
fn exact(t: f64) -> [[f64; 4]; 2] {
    let ((s, c), (s2, c2)) = (t.sin_cos(), (2.0 * t).sin_cos());
    let w = 1.3f64;
    let (sw, cw) = (w * t).sin_cos();
    [[s + 0.3 * c2, c - 0.6 * s2, -s - 1.2 * c2, -c + 2.4 * s2], [cw, -w * sw, -w * w * cw, w.powi(3) * sw]]
}

/// p(t) and its derivative.
fn forcing(t: f64) -> [[f64; 2]; 2] {
    let [[a, a1, a2, a3], [b, b1, b2, b3]] = exact(t);
    [
        [a2 + a.powi(3) - b * a1, a3 + 3.0 * a * a * a1 - b1 * a1 - b * a2],
        [b2 + a.sin() * b1 + b, b3 + a.cos() * a1 * b1 + a.sin() * b2 + b1],
    ]
}

/// Integrands of the quadratures: v1; d/dt (q1 q2); v̇1; cos t · q1.
const QUADRATURES: usize = 4;

type Pair = Fixed<2, QUADRATURES>;

fn exact_state(t: f64) -> State<Pair> {
    let [[a, a1, ..], [b, b1, ..]] = exact(t);
    let weighted = 0.5 * t.sin().powi(2) + 0.3 * (0.5 * t.sin() + (3.0 * t).sin() / 6.0);
    State { q: [a, b], v: [a1, b1], z: [a - 0.3, a * b - 0.3, a1 - 1.0, weighted] }
}

impl System for ForcedOscillators {
    type Layout = Pair;
    type Mode = ();

    fn layout(&self) -> Pair {
        Fixed
    }

    fn rates(&self, t: f64, q: &[f64; 2], v: &[f64; 2], _: &(), rates: &mut Rates<Pair>) {
        let [[p1, _], [p2, _]] = forcing(t);
        rates.a = [-q[0].powi(3) + q[1] * v[0] + p1, -q[0].sin() * v[1] - q[1] + p2];
        rates.g = [v[0], v[0] * q[1] + q[0] * v[1], rates.a[0], t.cos() * q[0]];
    }

    fn linearise(&self, t: f64, q: &[f64; 2], v: &[f64; 2], mode: &(), linearised: &mut Linearised<Pair>) {
        let [[_, p1], [_, p2]] = forcing(t);
        let a_q = [[-3.0 * q[0] * q[0], v[0]], [-q[0].cos() * v[1], -1.0]];
        let a_v = [[q[1], 0.0], [0.0, -q[0].sin()]];
        self.rates(t, q, v, mode, &mut linearised.rates);
        (linearised.a_q, linearised.a_v) = (FixedMatrix(a_q), FixedMatrix(a_v));
        linearised.a_t = [p1, p2];
        linearised.g_q.0 = [[0.0; 2], [v[1], v[0]], a_q[0], [t.cos(), 0.0]];
        linearised.g_v.0 = [[1.0, 0.0], [q[1], q[0]], a_v[0], [0.0; 2]];
        linearised.g_t = [0.0, 0.0, p1, -t.sin() * q[0]];
    }
}

fn distance(a: &State<Pair>, b: &State<Pair>, quadratures: bool) -> f64 {
    let (x, y) = if quadratures { (a.z.to_vec(), b.z.to_vec()) } else { ([a.q, a.v].concat(), [b.q, b.v].concat()) };
    x.iter().zip(&y).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

const SPAN: f64 = 3.2;

/// Errors of states and of quadratures at the end, for these numbers of steps.
fn errors<K: Method<Pair>>(counts: &[usize]) -> [Vec<f64>; 2] {
    let run = |n: &usize| march::<K, _>(&ForcedOscillators, &(), (0.0, exact_state(0.0)), SPAN / *n as f64, *n, |_| ());
    let ends: Vec<_> = counts.iter().map(run).collect();
    [false, true].map(|z| ends.iter().map(|end| distance(end, &exact_state(SPAN), z)).collect())
}

#[test]
fn both_implicit_methods_are_of_order_five() {
    let counts = [16, 32, 64, 128];
    for (name, [states, quadratures]) in
        [("Rodas5P", errors::<Rodas5p<Pair>>(&counts)), ("Radau IIA", errors::<Radau5<Pair>>(&counts))]
    {
        let orders = [slopes(&states), slopes(&quadratures)].concat();
        assert!(orders.iter().all(|order| *order > 4.8), "{name}: {orders:?}");
    }
}

#[test]
fn the_explicit_method_is_of_order_eight() {
    let [states, quadratures] = errors::<Dop853<Pair>>(&[4, 8, 16]);
    let orders = [slopes(&states), slopes(&quadratures)].concat();
    assert!(orders.iter().all(|order| *order > 7.5), "{orders:?}; {states:?}");
    assert!(states[2] < 1e-9, "{states:?}");
}

/// Errors of the dense output of single steps that start on the exact solution.
fn dense_errors<K: Method<Pair>>(sizes: &[f64]) -> Vec<f64> {
    let worst_of = |h: &f64| {
        let h = *h;
        let mut worst = 0.0f64;
        for t0 in [0.0, 0.7, 1.9] {
            march::<K, _>(&ForcedOscillators, &(), (t0, exact_state(t0)), h, 1, |dense| {
                assert!((dense.t0 + dense.h - (t0 + h)).abs() < 1e-15);
                for i in 0..=20 {
                    let theta = f64::from(i) / 20.0;
                    let (actual, expected) = (dense.evaluate(theta), exact_state(t0 + theta * h));
                    worst = [false, true].map(|z| distance(&actual, &expected, z)).into_iter().fold(worst, f64::max);
                }
            });
        }
        worst
    };
    sizes.iter().map(worst_of).collect()
}

/// The errors of single steps fall with one order more.
#[test]
fn dense_output_is_of_order_four_three_and_seven() {
    let sizes = [0.2, 0.1, 0.05, 0.025];
    let rodas = slopes(&dense_errors::<Rodas5p<Pair>>(&sizes));
    assert!(rodas.iter().all(|order| *order > 4.8), "Rodas5P: {rodas:?}");
    let radau = slopes(&dense_errors::<Radau5<Pair>>(&sizes));
    assert!(radau.iter().all(|order| *order > 3.8), "Radau IIA: {radau:?}");
    let explicit = slopes(&dense_errors::<Dop853<Pair>>(&[0.8, 0.4, 0.2]));
    assert!(explicit.iter().all(|order| *order > 7.5), "DOP853: {explicit:?}");
}

/// A quadrature of a rate equals its coordinate, and a quadrature of an acceleration equals its rate, in every step at
/// any accuracy.
#[test]
fn quadratures_are_integrated_like_coordinates() {
    fn quadrature_error<K: Method<Pair>>() -> f64 {
        let mut worst = 0.0f64;
        march::<K, _>(&ForcedOscillators, &(), (0.0, exact_state(0.0)), 0.2, 16, |dense| {
            for theta in [0.3, 0.7, 1.0] {
                let s = dense.evaluate(theta);
                worst = worst.max((s.z[0] - (s.q[0] - 0.3)).abs()).max((s.z[2] - (s.v[0] - 1.0)).abs());
            }
        });
        worst
    }
    let (rodas, radau) = (quadrature_error::<Rodas5p<Pair>>(), quadrature_error::<Radau5<Pair>>());
    let explicit = quadrature_error::<Dop853<Pair>>();
    assert!(rodas < 1e-13 && radau < 1e-13 && explicit < 1e-13, "{rodas:e} {radau:e} {explicit:e}");
}

/// v = cos t under a damper of strength λ: a = −λ (v − cos t) − sin t.
struct Damper(f64);

impl System for Damper {
    type Layout = Fixed<1, 0>;
    type Mode = ();

    fn layout(&self) -> Fixed<1, 0> {
        Fixed
    }

    fn rates(&self, t: f64, _: &[f64; 1], v: &[f64; 1], (): &(), rates: &mut Rates<Fixed<1, 0>>) {
        rates.a = [-self.0 * (v[0] - t.cos()) - t.sin()];
    }

    fn linearise(&self, t: f64, q: &[f64; 1], v: &[f64; 1], mode: &(), linearised: &mut Linearised<Fixed<1, 0>>) {
        self.rates(t, q, v, mode, &mut linearised.rates);
        linearised.a_q.0 = [[0.0]];
        linearised.a_v.0 = [[-self.0]];
        linearised.a_t = [-self.0 * t.sin() - t.cos()];
    }
}

/// The force of a damper is a large multiple of the error of a rate. A refined state has this force; the dense output does
/// not.
#[test]
fn refined_states_have_the_force_of_a_stiff_damper() {
    let (system, h) = (Damper(1e8), 0.3);
    let state = State { q: [0.0], v: [1.0], z: [] };
    let mut linearised = Linearised::zero(Fixed);
    system.linearise(0.0, &state.q, &state.v, &(), &mut linearised);
    let origin = StepStart {
        system: &system,
        mode: &(),
        linearised: &linearised,
        tolerances: &Tolerances { atol_q: 1e-9, atol_v: 1e-9, rtol_v: 1e-9 },
        t: 0.0,
        latest_time: f64::INFINITY,
        state: &state,
    };
    let mut method = Rodas5p::<Fixed<1, 0>>::new(Fixed);
    let (mut attempt, mut dense) = step_memory(Fixed);
    method.attempt(&origin, h, &mut attempt);
    method.dense(Some(&linearised), &mut dense);
    for theta in [0.1, 0.5, 0.8] {
        let exact = (theta * h).cos();
        let mut refinement = Refinement::new(Fixed);
        assert!(method.refine(&origin, &dense, theta, &mut refinement), "a linear problem converges at once");
        let [before, after] = [dense.evaluate(theta), refinement.state].map(|state| (state.v[0] - exact).abs());
        assert!(before > 1e-9 && after < 1e-12, "{theta}: {before:e} {after:e}");
    }
}

/// Two masses with springs; the first one drags a bristle: σ̇ = v − σ/τ with the force −k σ.
struct Bristle<const SECOND_ORDER: usize>;

impl<const SECOND_ORDER: usize> System for Bristle<SECOND_ORDER> {
    type Layout = Fixed<3, 1>;
    type Mode = ();

    fn layout(&self) -> Fixed<3, 1> {
        Fixed
    }

    fn second_order_count(&self) -> usize {
        SECOND_ORDER
    }

    fn rates(&self, t: f64, q: &[f64; 3], v: &[f64; 3], (): &(), rates: &mut Rates<Fixed<3, 1>>) {
        rates.a = [t.cos() - q[0] + 0.5 * q[1] - 300.0 * v[2], 0.5 * q[0] - q[1] - 0.1 * v[1], v[0] - 40.0 * v[2]];
        rates.g = [v[0] * v[0] + q[1]];
    }

    fn linearise(&self, t: f64, q: &[f64; 3], v: &[f64; 3], mode: &(), linearised: &mut Linearised<Fixed<3, 1>>) {
        self.rates(t, q, v, mode, &mut linearised.rates);
        linearised.a_q.0 = [[-1.0, 0.5, 0.0], [0.5, -1.0, 0.0], [0.0; 3]];
        linearised.a_v.0 = [[0.0, 0.0, -300.0], [0.0, -0.1, 0.0], [1.0, 0.0, -40.0]];
        linearised.a_t = [-t.sin(), 0.0, 0.0];
        linearised.g_q.0 = [[0.0, 1.0, 0.0]];
        linearised.g_v.0 = [[2.0 * v[0], 0.0, 0.0]];
        linearised.g_t = [0.0];
    }
}

/// Elimination of first-order states does not change the motion. Their coordinates, which have no effect, stay at 0.
#[test]
fn first_order_states_are_eliminated_exactly() {
    fn difference<K: Method<Fixed<3, 1>>>() -> f64 {
        let start = State { q: [0.3, -0.2, 0.0], v: [1.0, 0.5, 0.01], z: [0.0] };
        let all = march::<K, _>(&Bristle::<3>, &(), (0.0, start.clone()), 0.1, 10, |_| ());
        let reduced = march::<K, _>(&Bristle::<2>, &(), (0.0, start), 0.1, 10, |_| ());
        assert!(all.q[2] != 0.0 && reduced.q[2] == 0.0);
        let of = |state: &State<Fixed<3, 1>>| [&state.q[..2], &state.v, &state.z].concat();
        of(&all).iter().zip(of(&reduced)).fold(0.0, |worst, (a, b)| f64::max(worst, (a - b).abs()))
    }
    let (rodas, radau) = (difference::<Rodas5p<Fixed<3, 1>>>(), difference::<Radau5<Fixed<3, 1>>>());
    assert!(rodas < 1e-13 && radau < 1e-12, "{rodas:e} {radau:e}");
}

/// Coordinate and rate after `count` steps of size `h` from time 0.
fn end<K: Method<OneMass>>(
    field: impl Fn(f64, f64, f64) -> [f64; 4],
    [q, v]: [f64; 2],
    h: f64,
    count: usize,
) -> [f64; 2] {
    let end = march::<K, _>(&PointMass::new(field, []), &[], (0.0, mass_at(q, v)), h, count, |_| ());
    [end.q[0], end.v[0]]
}

/// |R(z)| on v̇ = λ v for z = hλ: the rate after one step from a rate of 1.
fn remaining_rate<K: Method<OneMass>>(z: f64) -> f64 {
    end::<K>(|_, _, v| [z * v, 0.0, 0.0, z], [0.0, 1.0], 1.0, 1)[1].abs()
}

/// L-stability: R(z) → 0 like 1/z as z → −∞, since the numerator of both stability functions is one degree below the
/// denominator. For Radau IIA, the (2, 3) Padé approximant (1 + 2z/5 + z²/20)/(1 − 3z/5 + 3z²/20 − z³/60), |z R| tends
/// to 3.
#[test]
fn fast_decay_is_damped_in_one_step() {
    fn check<K: Method<OneMass>>(name: &str) {
        for z in [-1e2, -1e4, -1e6, -1e8, -1e10] {
            let remaining = remaining_rate::<K>(z);
            assert!(remaining < 20.0 / f64::abs(z), "{name}: {remaining:e} at {z:e}");
        }
    }
    check::<Rodas5p<OneMass>>("Rodas5P");
    check::<Radau5<OneMass>>("Radau IIA");
}

/// A-stability: no oscillation grows, whatever its frequency. q̈ = −ω² q over one step of 1: the energy never
/// increases.
#[test]
fn oscillations_never_grow() {
    fn check<K: Method<OneMass>>(name: &str) {
        let mut worst = 0.0f64;
        for i in 0..400 {
            let omega = 1e-2 * 1e8f64.powf(f64::from(i) / 399.0);
            let stiff = omega * omega;
            // The step is linear, so two phases span all others.
            let step = |q: f64, v: f64| {
                let [q, v] = end::<K>(|_, q, _| [-stiff * q, 0.0, -stiff, 0.0], [q, v * omega], 1.0, 1);
                [q, v / omega]
            };
            let (a, b) = (step(1.0, 0.0), step(0.0, 1.0));
            // Largest singular value of the step.
            let (p, r, s) = (a[0] * a[0] + a[1] * a[1], a[0] * b[0] + a[1] * b[1], b[0] * b[0] + b[1] * b[1]);
            let largest = 0.5 * (p + s) + (0.25 * (p - s).powi(2) + r * r).sqrt();
            worst = worst.max(largest.sqrt());
        }
        assert!(worst < 1.0 + 1e-9, "{name}: {worst}");
    }
    check::<Rodas5p<OneMass>>("Rodas5P");
    check::<Radau5<OneMass>>("Radau IIA");
}

/// The Prothero–Robinson problem for rates: v̇ = −λ (v − cos t) − sin t. Its solution v = cos t, q = sin t is
/// independent of λ.
#[test]
fn slow_motion_under_a_stiff_damper_is_accurate_at_large_steps() {
    fn worst<K: Method<OneMass>>(n: usize) -> f64 {
        let mut worst = 0.0f64;
        for lambda in [1e3, 1e5, 1e7, 1e9] {
            let field =
                |t: f64, _: f64, v: f64| [-lambda * (v - t.cos()) - t.sin(), -lambda * t.sin() - t.cos(), 0.0, -lambda];
            let [q, v] = end::<K>(field, [0.0, 1.0], 2.0 / n as f64, n);
            worst = worst.max((q - 2f64.sin()).abs()).max((v - 2f64.cos()).abs());
        }
        worst
    }
    // Stiffness reduces the order (to at least 3 for these methods); the errors must be small and decrease.
    for (name, coarse, fine) in [
        ("Rodas5P", worst::<Rodas5p<OneMass>>(20), worst::<Rodas5p<OneMass>>(80)),
        ("Radau IIA", worst::<Radau5<OneMass>>(20), worst::<Radau5<OneMass>>(80)),
    ] {
        assert!(coarse < 1e-5 && fine < coarse / 64.0, "{name}: {coarse:e} {fine:e}");
    }
}

/// Van der Pol oscillator, ε = 1e-6, from (2, 0) to t = 2: y = 1.706167732170483, ẏ = −0.8928097010247975 (reference
/// solution of problem VDPOL of the Bari test set for initial value problems).
#[test]
fn van_der_pol_matches_the_reference_solution() {
    let epsilon = 1e-6;
    let field = |_: f64, y: f64, v: f64| {
        let linear_coefficient = 1.0 - y * y;
        [(linear_coefficient * v - y) / epsilon, 0.0, (-2.0 * y * v - 1.0) / epsilon, linear_coefficient / epsilon]
    };
    let options = Options { tolerances: Tolerances { atol_q: 1e-11, atol_v: 1e-9, rtol_v: 1e-9 }, max_steps: 100_000 };
    for (name, end, _) in run_from(&PointMass::new(field, []), options, [2.0, 0.0], 2.0) {
        assert_eq!(end.time_s, 2.0);
        let error = [end.state.q[0] - 1.706167732170483, end.state.v[0] + 0.8928097010247975];
        assert!(error.iter().all(|e| e.abs() < 1e-7), "{name}: {error:?}");
    }
}
