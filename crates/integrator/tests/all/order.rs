//! Order of convergence of both methods on a smooth, nonlinear, time-dependent problem with a known solution.
//!
//! q1 = sin t + 0.3 cos 2t and q2 = cos 1.3t solve q̈1 = −q1³ + q2 q̇1 + p1(t), q̈2 = −sin(q1) q̇2 − q2 + p2(t), with p
//! chosen accordingly. Theory: both methods are of order 5; the dense output of Rodas5P is of order 4 (its error within
//! one step falls as h⁵), the cubic collocation polynomial of Radau IIA of order 3 (h⁴).

use crate::stepping::{march, slopes};
use phalanx_integrator::{Linearised, Method, Radau5, Rates, Rodas5p, State, System};

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

fn exact_state(t: f64) -> State<2, QUADRATURES> {
    let [[a, a1, ..], [b, b1, ..]] = exact(t);
    let weighted = 0.5 * t.sin().powi(2) + 0.3 * (0.5 * t.sin() + (3.0 * t).sin() / 6.0);
    State { q: [a, b], v: [a1, b1], z: [a - 0.3, a * b - 0.3, a1 - 1.0, weighted] }
}

impl System<2, QUADRATURES> for ForcedOscillators {
    type Mode = ();

    fn rates(&self, t: f64, q: &[f64; 2], v: &[f64; 2], _: &()) -> Rates<2, QUADRATURES> {
        let [[p1, _], [p2, _]] = forcing(t);
        let a = [-q[0].powi(3) + q[1] * v[0] + p1, -q[0].sin() * v[1] - q[1] + p2];
        Rates { a, g: [v[0], v[0] * q[1] + q[0] * v[1], a[0], t.cos() * q[0]] }
    }

    fn linearise(&self, t: f64, q: &[f64; 2], v: &[f64; 2], mode: &()) -> Linearised<2, QUADRATURES> {
        let [[_, p1], [_, p2]] = forcing(t);
        let a_q = [[-3.0 * q[0] * q[0], v[0]], [-q[0].cos() * v[1], -1.0]];
        let a_v = [[q[1], 0.0], [0.0, -q[0].sin()]];
        Linearised {
            rates: self.rates(t, q, v, mode),
            a_q,
            a_v,
            a_t: [p1, p2],
            g_q: [[0.0; 2], [v[1], v[0]], a_q[0], [t.cos(), 0.0]],
            g_v: [[1.0, 0.0], [q[1], q[0]], a_v[0], [0.0; 2]],
            g_t: [0.0, 0.0, p1, -t.sin() * q[0]],
        }
    }
}

fn distance(a: &State<2, QUADRATURES>, b: &State<2, QUADRATURES>, quadratures: bool) -> f64 {
    let (x, y) = if quadratures { (a.z.to_vec(), b.z.to_vec()) } else { ([a.q, a.v].concat(), [b.q, b.v].concat()) };
    x.iter().zip(&y).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

const SPAN: f64 = 3.2;

/// Errors of states and of quadratures at the end, for successively halved steps.
fn errors<K: Method<2, QUADRATURES>>() -> [Vec<f64>; 2] {
    let run = |n: usize| {
        march::<K, _, 2, QUADRATURES>(&ForcedOscillators, &(), (0.0, exact_state(0.0)), SPAN / n as f64, n, |_| ())
    };
    let ends: Vec<_> = [16, 32, 64, 128].map(run).into();
    [false, true].map(|z| ends.iter().map(|end| distance(end, &exact_state(SPAN), z)).collect())
}

fn assert_order<K: Method<2, QUADRATURES>>(name: &str) {
    let [states, quadratures] = errors::<K>();
    println!(
        "{name}: states {states:?} {:.2?}, quadratures {quadratures:?} {:.2?}",
        slopes(&states),
        slopes(&quadratures)
    );
    for order in [slopes(&states), slopes(&quadratures)].concat() {
        assert!(order > 4.8, "{name}: {order}");
    }
}

#[test]
fn rodas5p_is_of_order_five() {
    assert_order::<Rodas5p<2, QUADRATURES>>("Rodas5P");
}

#[test]
fn radau_iia_is_of_order_five() {
    assert_order::<Radau5<2, QUADRATURES>>("Radau IIA");
}

/// Errors of the dense output of single steps that start on the exact solution.
fn dense_errors<K: Method<2, QUADRATURES>>() -> Vec<f64> {
    [0.2, 0.1, 0.05, 0.025]
        .map(|h| {
            let mut worst = 0.0f64;
            for t0 in [0.0, 0.7, 1.9] {
                march::<K, _, 2, QUADRATURES>(&ForcedOscillators, &(), (t0, exact_state(t0)), h, 1, |dense| {
                    assert!((dense.t0 + dense.h - (t0 + h)).abs() < 1e-15);
                    for i in 0..=20 {
                        let theta = f64::from(i) / 20.0;
                        let expected = exact_state(t0 + theta * h);
                        let interpolated = dense.evaluate(theta);
                        worst = worst.max(distance(&interpolated, &expected, false)).max(distance(
                            &interpolated,
                            &expected,
                            true,
                        ));
                    }
                });
            }
            worst
        })
        .to_vec()
}

#[test]
fn dense_output_of_rodas5p_is_of_order_four() {
    let errors = dense_errors::<Rodas5p<2, QUADRATURES>>();
    println!("Rodas5P dense {errors:?} {:.2?}", slopes(&errors));
    assert!(slopes(&errors).iter().all(|s| *s > 4.8), "{:?}", slopes(&errors));
}

#[test]
fn dense_output_of_radau_iia_is_of_order_three() {
    let errors = dense_errors::<Radau5<2, QUADRATURES>>();
    println!("Radau IIA dense {errors:?} {:.2?}", slopes(&errors));
    assert!(slopes(&errors).iter().all(|s| *s > 3.8), "{:?}", slopes(&errors));
}

/// A quadrature of a rate equals its coordinate, and a quadrature of an acceleration equals its rate, in every step at
/// any accuracy.
#[test]
fn quadratures_are_integrated_like_coordinates() {
    fn quadrature_error<K: Method<2, QUADRATURES>>() -> f64 {
        let mut worst = 0.0f64;
        march::<K, _, 2, QUADRATURES>(&ForcedOscillators, &(), (0.0, exact_state(0.0)), 0.2, 16, |dense| {
            for theta in [0.3, 0.7, 1.0] {
                let s = dense.evaluate(theta);
                worst = worst.max((s.z[0] - (s.q[0] - 0.3)).abs()).max((s.z[2] - (s.v[0] - 1.0)).abs());
            }
        });
        worst
    }
    let (rodas, radau) = (quadrature_error::<Rodas5p<2, QUADRATURES>>(), quadrature_error::<Radau5<2, QUADRATURES>>());
    println!("quadratures against coordinates: Rodas5P {rodas:.1e}, Radau IIA {radau:.1e}");
    assert!(rodas < 1e-13 && radau < 1e-13, "{rodas:e} {radau:e}");
}
