//! A sample between two others.

use super::{BodyState, ContactSample, Energy, FingerState, Sample};
use crate::numeric::plane::near_turn;

/// The sample at time `t` between `a` and `b`: coordinates by cubic Hermite interpolation with their rates, all else linear.
pub fn between(a: &Sample, b: &Sample, t: f64) -> Sample {
    let mut sample = Sample::default();
    sample.become_between(a, b, t);
    sample
}

impl Sample {
    /// Becomes what [`between`] gives, keeping what it has allocated.
    pub(super) fn become_between(&mut self, a: &Sample, b: &Sample, t: f64) {
        let h = b.time_s - a.time_s;
        if h <= 0.0 {
            self.clone_from(b);
            return;
        }
        let at = Between { h, x: ((t - a.time_s) / h).clamp(0.0, 1.0) };
        self.time_s = t;
        refill(&mut self.fingers, &a.fingers, &b.fingers, |a, b| at.finger(a, b));
        refill(&mut self.bodies, &a.bodies, &b.bodies, |a, b| at.body(a, b));
        refill(&mut self.contacts, &a.contacts, &b.contacts, |a, b| at.contact(a, b));
        self.energy = at.energy(&a.energy, &b.energy);
    }
}

fn refill<T>(parts: &mut Vec<T>, a: &[T], b: &[T], of: impl Fn(&T, &T) -> T) {
    parts.clear();
    parts.extend(a.iter().zip(b).map(|(a, b)| of(a, b)));
}

/// An instant between two samples.
#[derive(Clone, Copy, Debug)]
struct Between {
    /// From one sample to the other, and the part of that which has passed.
    h: f64,
    x: f64,
}

impl Between {
    /// On the straight line from `p` to `q`.
    fn line(&self, p: f64, q: f64) -> f64 {
        if p.is_finite() && q.is_finite() { p + self.x * (q - p) } else { q }
    }

    /// On the cubic from `p` to `q` that has the rates `v` and `w` there.
    fn cubic(&self, p: f64, v: f64, q: f64, w: f64) -> f64 {
        let Self { h, x, .. } = *self;
        let (x2, x3) = (x * x, x * x * x);
        p + (q - p) * (3.0 * x2 - 2.0 * x3) + h * (v * (x3 - 2.0 * x2 + x) + w * (x3 - x2))
    }

    fn finger(&self, a: &FingerState, b: &FingerState) -> FingerState {
        let of = |field: fn(&FingerState) -> f64| self.line(field(a), field(b));
        // A passive angle may come back at −π where it went out at π.
        let q = |angle: fn(&FingerState) -> f64, rate: fn(&FingerState) -> f64| {
            self.cubic(angle(a), rate(a), near_turn(angle(b), angle(a)), rate(b))
        };
        FingerState {
            q11_rad: q(|s| s.q11_rad, |s| s.qd11_rad_s),
            q21_rad: q(|s| s.q21_rad, |s| s.qd21_rad_s),
            q12_rad: q(|s| s.q12_rad, |s| s.qd12_rad_s),
            q22_rad: q(|s| s.q22_rad, |s| s.qd22_rad_s),
            q13_rad: q(|s| s.q13_rad, |s| s.qd21_rad_s + s.qd22_rad_s),
            qd11_rad_s: of(|s| s.qd11_rad_s),
            qd21_rad_s: of(|s| s.qd21_rad_s),
            qd12_rad_s: of(|s| s.qd12_rad_s),
            qd22_rad_s: of(|s| s.qd22_rad_s),
            motor_torque_n_m: of(|s| s.motor_torque_n_m),
        }
    }

    fn body(&self, a: &BodyState, b: &BodyState) -> BodyState {
        let axis = |i: usize| self.cubic(a.centre_m[i], a.velocity_m_s[i], b.centre_m[i], b.velocity_m_s[i]);
        BodyState {
            centre_m: [axis(0), axis(1)],
            angle_rad: self.cubic(a.angle_rad, a.spin_rad_s, b.angle_rad, b.spin_rad_s),
            velocity_m_s: self.pair(a.velocity_m_s, b.velocity_m_s),
            spin_rad_s: self.line(a.spin_rad_s, b.spin_rad_s),
        }
    }

    fn pair(&self, p: [f64; 2], q: [f64; 2]) -> [f64; 2] {
        [self.line(p[0], q[0]), self.line(p[1], q[1])]
    }

    fn contact(&self, a: &ContactSample, b: &ContactSample) -> ContactSample {
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

    fn energy(&self, a: &Energy, b: &Energy) -> Energy {
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
