//! A sample between two others.

use super::{ContactSample, Energy, Instant};

/// The sample at time `t` between `a` and `b`: coordinates by cubic Hermite interpolation with their rates, all else linear.
pub fn between<S: Instant>(a: &S, b: &S, t: f64) -> S {
    let h = b.time_s() - a.time_s();
    if h <= 0.0 {
        return b.clone();
    }
    let x = ((t - a.time_s()) / h).clamp(0.0, 1.0);
    S::blend(a, b, &Between { time_s: t, h, x })
}

/// An instant between two samples.
#[derive(Clone, Copy, Debug)]
pub struct Between {
    pub time_s: f64,
    /// From one sample to the other, and the part of that which has passed.
    h: f64,
    x: f64,
}

impl Between {
    /// On the straight line from `p` to `q`.
    pub fn line(&self, p: f64, q: f64) -> f64 {
        if p.is_finite() && q.is_finite() { p + self.x * (q - p) } else { q }
    }

    /// On the cubic from `p` to `q` that has the rates `v` and `w` there.
    pub fn cubic(&self, p: f64, v: f64, q: f64, w: f64) -> f64 {
        let Self { h, x, .. } = *self;
        let (x2, x3) = (x * x, x * x * x);
        p + (q - p) * (3.0 * x2 - 2.0 * x3) + h * (v * (x3 - 2.0 * x2 + x) + w * (x3 - x2))
    }

    pub fn pair(&self, p: [f64; 2], q: [f64; 2]) -> [f64; 2] {
        [self.line(p[0], q[0]), self.line(p[1], q[1])]
    }

    pub fn contact(&self, a: &ContactSample, b: &ContactSample) -> ContactSample {
        ContactSample {
            gap_m: self.line(a.gap_m, b.gap_m),
            gap_rate_m_s: self.line(a.gap_rate_m_s, b.gap_rate_m_s),
            slip_m_s: self.line(a.slip_m_s, b.slip_m_s),
            normal_n: self.line(a.normal_n, b.normal_n),
            tangential_n: self.line(a.tangential_n, b.tangential_n),
            impulse_n_s: self.line(a.impulse_n_s, b.impulse_n_s),
            point_m: self.pair(a.point_m, b.point_m),
            normal: self.pair(a.normal, b.normal),
        }
    }

    pub fn energy(&self, a: &Energy, b: &Energy) -> Energy {
        let of = |field: fn(&Energy) -> f64| self.line(field(a), field(b));
        Energy {
            kinetic_j: of(|e| e.kinetic_j),
            gravity_j: of(|e| e.gravity_j),
            spring_j: of(|e| e.spring_j),
            elastic_j: of(|e| e.elastic_j),
            dissipated_j: of(|e| e.dissipated_j),
            motor_work_j: of(|e| e.motor_work_j),
            balance_j: of(|e| e.balance_j),
        }
    }
}
