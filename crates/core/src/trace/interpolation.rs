//! Interpolation between two samples.

use super::{BodyState, ContactSample, Energy, FingerState, Sample};
use crate::numeric::plane::nearest_equivalent_angle;

/// Returns the sample at time `t` between `a` and `b`: cubic Hermite interpolation of coordinates with their rates,
/// linear interpolation of everything else.
pub fn interpolate(a: &Sample, b: &Sample, t: f64) -> Sample {
    let mut sample = Sample::default();
    sample.interpolate_from(a, b, t);
    sample
}

impl Sample {
    /// Sets this sample to the result of [`interpolate`], reusing its allocations.
    pub(super) fn interpolate_from(&mut self, a: &Sample, b: &Sample, t: f64) {
        let h = b.time_s - a.time_s;
        if h <= 0.0 {
            self.clone_from(b);
            return;
        }
        let instant = Instant { h, x: ((t - a.time_s) / h).clamp(0.0, 1.0) };
        self.time_s = t;
        refill(&mut self.fingers, &a.fingers, &b.fingers, |a, b| instant.finger(a, b));
        refill(&mut self.bodies, &a.bodies, &b.bodies, |a, b| instant.body(a, b));
        refill(&mut self.contacts, &a.contacts, &b.contacts, |a, b| instant.contact(a, b));
        self.energy = instant.energy(&a.energy, &b.energy);
    }
}

fn refill<T>(items: &mut Vec<T>, a: &[T], b: &[T], combine: impl Fn(&T, &T) -> T) {
    items.clear();
    items.extend(a.iter().zip(b).map(|(a, b)| combine(a, b)));
}

/// An instant between two samples.
#[derive(Clone, Copy, Debug)]
struct Instant {
    /// Time between the samples, s.
    h: f64,
    /// Elapsed fraction of the interval.
    x: f64,
}

impl Instant {
    /// Linear interpolation from `p` to `q`.
    fn linear(&self, p: f64, q: f64) -> f64 {
        if p.is_finite() && q.is_finite() { p + self.x * (q - p) } else { q }
    }

    /// Cubic Hermite interpolation from `p` to `q` with the rates `v` and `w`.
    fn cubic(&self, p: f64, v: f64, q: f64, w: f64) -> f64 {
        let Self { h, x } = *self;
        let (x2, x3) = (x * x, x * x * x);
        p + (q - p) * (3.0 * x2 - 2.0 * x3) + h * (v * (x3 - 2.0 * x2 + x) + w * (x3 - x2))
    }

    fn finger(&self, a: &FingerState, b: &FingerState) -> FingerState {
        let linear = |field: fn(&FingerState) -> f64| self.linear(field(a), field(b));
        // A passive angle can leave at π and return at −π.
        let angle = |position: fn(&FingerState) -> f64, rate: fn(&FingerState) -> f64| {
            self.cubic(position(a), rate(a), nearest_equivalent_angle(position(b), position(a)), rate(b))
        };
        FingerState {
            q11_rad: angle(|s| s.q11_rad, |s| s.qd11_rad_s),
            q21_rad: angle(|s| s.q21_rad, |s| s.qd21_rad_s),
            q12_rad: angle(|s| s.q12_rad, |s| s.qd12_rad_s),
            q22_rad: angle(|s| s.q22_rad, |s| s.qd22_rad_s),
            q13_rad: angle(|s| s.q13_rad, |s| s.qd21_rad_s + s.qd22_rad_s),
            qd11_rad_s: linear(|s| s.qd11_rad_s),
            qd21_rad_s: linear(|s| s.qd21_rad_s),
            qd12_rad_s: linear(|s| s.qd12_rad_s),
            qd22_rad_s: linear(|s| s.qd22_rad_s),
            motor_torque_n_m: linear(|s| s.motor_torque_n_m),
        }
    }

    fn body(&self, a: &BodyState, b: &BodyState) -> BodyState {
        let axis = |i: usize| self.cubic(a.centre_m[i], a.velocity_m_s[i], b.centre_m[i], b.velocity_m_s[i]);
        BodyState {
            centre_m: [axis(0), axis(1)],
            angle_rad: self.cubic(a.angle_rad, a.spin_rad_s, b.angle_rad, b.spin_rad_s),
            velocity_m_s: self.linear_pair(a.velocity_m_s, b.velocity_m_s),
            spin_rad_s: self.linear(a.spin_rad_s, b.spin_rad_s),
        }
    }

    fn linear_pair(&self, p: [f64; 2], q: [f64; 2]) -> [f64; 2] {
        [self.linear(p[0], q[0]), self.linear(p[1], q[1])]
    }

    fn contact(&self, a: &ContactSample, b: &ContactSample) -> ContactSample {
        ContactSample {
            gap_m: self.linear(a.gap_m, b.gap_m),
            gap_rate_m_s: self.linear(a.gap_rate_m_s, b.gap_rate_m_s),
            slip_m_s: self.linear(a.slip_m_s, b.slip_m_s),
            normal_n: self.linear(a.normal_n, b.normal_n),
            tangential_n: self.linear(a.tangential_n, b.tangential_n),
            impulse_n_s: self.linear(a.impulse_n_s, b.impulse_n_s),
            point_m: self.linear_pair(a.point_m, b.point_m),
            normal: self.linear_pair(a.normal, b.normal),
        }
    }

    fn energy(&self, a: &Energy, b: &Energy) -> Energy {
        let linear = |field: fn(&Energy) -> f64| self.linear(field(a), field(b));
        Energy {
            kinetic_j: linear(|e| e.kinetic_j),
            gravity_j: linear(|e| e.gravity_j),
            spring_j: linear(|e| e.spring_j),
            elastic_j: linear(|e| e.elastic_j),
            dissipated_j: linear(|e| e.dissipated_j),
            motor_work_j: linear(|e| e.motor_work_j),
            balance_j: linear(|e| e.balance_j),
        }
    }
}
