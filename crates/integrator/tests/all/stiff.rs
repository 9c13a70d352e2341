//! Stiffness: both methods damp fast components and preserve slow ones, at steps far beyond the fast time scale.

use crate::stepping::march;
use phalanx_integrator::{
    EventFunction, EventSet, Hybrid, Linearised, Method, Options, Radau5, Rates, Rodas5p, State, System, Tolerances,
    integrate,
};

/// q̈ = f(t, q, v) with its derivatives (f, f_t, f_q, f_v), as a hybrid system without events.
struct ScalarSystem<F: Fn(f64, f64, f64) -> [f64; 4]>(F);

impl<F: Fn(f64, f64, f64) -> [f64; 4]> System<1, 0> for ScalarSystem<F> {
    type Mode = ();

    fn rates(&self, t: f64, q: &[f64; 1], v: &[f64; 1], _: &()) -> Rates<1, 0> {
        Rates { a: [self.0(t, q[0], v[0])[0]], g: [] }
    }

    fn linearise(&self, t: f64, q: &[f64; 1], v: &[f64; 1], mode: &()) -> Linearised<1, 0> {
        let [_, a_t, a_q, a_v] = self.0(t, q[0], v[0]);
        let rates = self.rates(t, q, v, mode);
        Linearised { rates, a_q: [[a_q]], a_v: [[a_v]], a_t: [a_t], g_q: [], g_v: [], g_t: [] }
    }
}

impl<F: Fn(f64, f64, f64) -> [f64; 4]> Hybrid<1, 0, 0> for ScalarSystem<F> {
    fn next_discontinuity(&self, _: f64) -> f64 {
        f64::INFINITY
    }

    fn eval_events(&self, _: &[f64; 1], _: &[f64; 1], _: &()) -> EventSet<1, 0> {
        EventSet { functions: [], clearance: 1.0, clearance_rate: 0.0 }
    }

    fn event_tolerance(&self, _: usize, _: &()) -> f64 {
        0.0
    }

    fn mode_after_event(&self, _: usize, _: &[f64; 1], _: &[f64; 1], _: &()) {}

    fn mode_after_step(&self, _: &[EventFunction<1>; 0], _: &()) -> Option<()> {
        None
    }

    fn with_clamped_law(&self, _: usize, _: &()) {}

    fn mode_at(&self, _: f64, _: &[f64; 1], _: &[f64; 1]) {}

    fn restart_step(&self, _: usize, _: &[f64; 1], _: &[f64; 1], _: &()) -> Option<f64> {
        None
    }

    fn describe_obstacle(&self, _: &[f64; 1]) -> String {
        String::new()
    }
}

fn state(q: f64, v: f64) -> State<1, 0> {
    State { q: [q], v: [v], z: [] }
}

/// |R(z)| on v̇ = λ v for z = hλ: the rate after one step from a rate of 1.
fn remaining_rate<K: Method<1, 0>>(z: f64) -> f64 {
    march::<K, _, 1, 0>(&ScalarSystem(|_, _, v| [z * v, 0.0, 0.0, z]), &(), (0.0, state(0.0, 1.0)), 1.0, 1, |_| ()).v[0]
        .abs()
}

/// L-stability: R(z) → 0 like 1/z as z → −∞, since the numerator of both stability functions is one degree below the
/// denominator. For Radau IIA, the (2, 3) Padé approximant (1 + 2z/5 + z²/20)/(1 − 3z/5 + 3z²/20 − z³/60), |z R| tends
/// to 3.
#[test]
fn fast_decay_is_damped_in_one_step() {
    fn check<K: Method<1, 0>>(name: &str) {
        let remaining = [-1e2, -1e4, -1e6, -1e8, -1e10].map(|z| (z, remaining_rate::<K>(z)));
        println!("{name}: remaining fast rate {remaining:?}");
        for (z, remaining) in remaining {
            assert!(remaining < 20.0 / f64::abs(z), "{name}: {remaining:e} at {z:e}");
        }
    }
    check::<Rodas5p<1, 0>>("Rodas5P");
    check::<Radau5<1, 0>>("Radau IIA");
}

/// A-stability: no oscillation grows, whatever its frequency. q̈ = −ω² q over one step of 1: the energy never
/// increases.
#[test]
fn oscillations_never_grow() {
    fn check<K: Method<1, 0>>(name: &str) {
        let mut worst = 0.0f64;
        for i in 0..400 {
            let omega = 1e-2 * 1e8f64.powf(f64::from(i) / 399.0);
            let stiff = omega * omega;
            // The step is linear, so two phases span all others.
            let step = |q: f64, v: f64| {
                let end = march::<K, _, 1, 0>(
                    &ScalarSystem(|_, q, _| [-stiff * q, 0.0, -stiff, 0.0]),
                    &(),
                    (0.0, state(q, v * omega)),
                    1.0,
                    1,
                    |_| (),
                );
                [end.q[0], end.v[0] / omega]
            };
            let (a, b) = (step(1.0, 0.0), step(0.0, 1.0));
            // Largest singular value of the step.
            let (p, r, s) = (a[0] * a[0] + a[1] * a[1], a[0] * b[0] + a[1] * b[1], b[0] * b[0] + b[1] * b[1]);
            let largest = 0.5 * (p + s) + (0.25 * (p - s).powi(2) + r * r).sqrt();
            worst = worst.max(largest.sqrt());
        }
        println!("{name}: largest growth {:.3e}", worst - 1.0);
        assert!(worst < 1.0 + 1e-9, "{name}: {worst}");
    }
    check::<Rodas5p<1, 0>>("Rodas5P");
    check::<Radau5<1, 0>>("Radau IIA");
}

/// The Prothero–Robinson problem for rates: v̇ = −λ (v − cos t) − sin t. Its solution v = cos t, q = sin t is
/// independent of λ.
#[test]
fn slow_motion_under_a_stiff_damper_is_accurate_at_large_steps() {
    fn worst<K: Method<1, 0>>(n: usize) -> f64 {
        let mut worst = 0.0f64;
        for lambda in [1e3, 1e5, 1e7, 1e9] {
            let system = ScalarSystem(move |t: f64, _, v| {
                [-lambda * (v - t.cos()) - t.sin(), -lambda * t.sin() - t.cos(), 0.0, -lambda]
            });
            let end = march::<K, _, 1, 0>(&system, &(), (0.0, state(0.0, 1.0)), 2.0 / n as f64, n, |_| ());
            worst = worst.max((end.q[0] - 2f64.sin()).abs()).max((end.v[0] - 2f64.cos()).abs());
        }
        worst
    }
    // Stiffness reduces the order (to at least 3 for these methods); the errors must be small and decrease.
    for (name, coarse, fine) in [
        ("Rodas5P", worst::<Rodas5p<1, 0>>(20), worst::<Rodas5p<1, 0>>(80)),
        ("Radau IIA", worst::<Radau5<1, 0>>(20), worst::<Radau5<1, 0>>(80)),
    ] {
        println!("{name}: h = 0.1 {coarse:.1e}, h = 0.025 {fine:.1e}, order {:.1}", (coarse / fine).log2() / 2.0);
        assert!(coarse < 1e-5 && fine < coarse / 64.0, "{name}: {coarse:e} {fine:e}");
    }
}

/// Van der Pol oscillator, ε = 1e-6, from (2, 0) to t = 2: y = 1.706167732170483, ẏ = −0.8928097010247975 (reference
/// solution of problem VDPOL of the Bari test set for initial value problems).
#[test]
fn van_der_pol_matches_the_reference_solution() {
    let epsilon = 1e-6;
    let system = ScalarSystem(|_, y: f64, v: f64| {
        let linear_coefficient = 1.0 - y * y;
        [(linear_coefficient * v - y) / epsilon, 0.0, (-2.0 * y * v - 1.0) / epsilon, linear_coefficient / epsilon]
    });
    let options = Options { tolerances: Tolerances { atol_q: 1e-11, atol_v: 1e-9, rtol_v: 1e-9 }, max_steps: 100_000 };
    let rodas = integrate::<1, 0, 0, _, Rodas5p<1, 0>, _>(&system, &options, 0.0, state(2.0, 0.0), 2.0, &mut ());
    let radau = integrate::<1, 0, 0, _, Radau5<1, 0>, _>(&system, &options, 0.0, state(2.0, 0.0), 2.0, &mut ());
    for (name, end) in [("Rodas5P", rodas), ("Radau IIA", radau)] {
        assert!(end.result.is_ok() && end.time_s == 2.0);
        let error = [end.state.q[0] - 1.706167732170483, end.state.v[0] + 0.8928097010247975];
        println!("{name}: {error:?} after {:?}", end.counters);
        assert!(error.iter().all(|e| e.abs() < 1e-7), "{name}: {error:?}");
    }
}
