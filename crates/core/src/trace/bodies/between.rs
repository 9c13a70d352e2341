//! A sample of discs between two others.

use super::{BodiesSample, DiscState};
use crate::trace::between::{contact, energy};

/// The sample at time `t` between `a` and `b`: centres and angles by cubic Hermite interpolation with their rates, all else
/// linear.
pub fn between(a: &BodiesSample, b: &BodiesSample, t: f64) -> BodiesSample {
    let h = b.time_s - a.time_s;
    if h <= 0.0 {
        return b.clone();
    }
    let x = ((t - a.time_s) / h).clamp(0.0, 1.0);
    let line = |p: f64, q: f64| if p.is_finite() && q.is_finite() { p + x * (q - p) } else { q };
    let disc = |(a, b): (&DiscState, &DiscState)| {
        let cubic = |p: f64, v: f64, q: f64, w: f64| {
            let (x2, x3) = (x * x, x * x * x);
            p + (q - p) * (3.0 * x2 - 2.0 * x3) + h * (v * (x3 - 2.0 * x2 + x) + w * (x3 - x2))
        };
        let axis = |i: usize| cubic(a.centre_m[i], a.velocity_m_s[i], b.centre_m[i], b.velocity_m_s[i]);
        DiscState {
            centre_m: [axis(0), axis(1)],
            angle_rad: cubic(a.angle_rad, a.spin_rad_s, b.angle_rad, b.spin_rad_s),
            velocity_m_s: [0, 1].map(|i| line(a.velocity_m_s[i], b.velocity_m_s[i])),
            spin_rad_s: line(a.spin_rad_s, b.spin_rad_s),
        }
    };
    BodiesSample {
        time_s: t,
        discs: a.discs.iter().zip(&b.discs).map(disc).collect(),
        contacts: a.contacts.iter().zip(&b.contacts).map(|(a, b)| contact(a, b, &line)).collect(),
        energy: energy(&a.energy, &b.energy, &line),
    }
}
