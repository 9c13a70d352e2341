//! A sample between two others.

use super::{ContactSample, Energy, Sample};
use crate::numeric::plane::near_turn;

/// The sample at time `t` between `a` and `b`: angles by cubic Hermite interpolation with their rates, all else linear.
pub fn between(a: &Sample, b: &Sample, t: f64) -> Sample {
    let h = b.time_s - a.time_s;
    if h <= 0.0 {
        return *b;
    }
    let x = ((t - a.time_s) / h).clamp(0.0, 1.0);
    let line = |p: f64, q: f64| if p.is_finite() && q.is_finite() { p + x * (q - p) } else { q };
    let cubic = |p: f64, v: f64, q: f64, w: f64| {
        // A passive angle may come back at −π where it went out at π.
        let q = near_turn(q, p);
        let (x2, x3) = (x * x, x * x * x);
        p + (q - p) * (3.0 * x2 - 2.0 * x3) + h * (v * (x3 - 2.0 * x2 + x) + w * (x3 - x2))
    };
    let q = |angle: fn(&Sample) -> f64, rate: fn(&Sample) -> f64| cubic(angle(a), rate(a), angle(b), rate(b));
    let of = |field: fn(&Sample) -> f64| line(field(a), field(b));
    Sample {
        time_s: t,
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
        proximal: contact(&a.proximal, &b.proximal, &line),
        distal: contact(&a.distal, &b.distal, &line),
        limit: contact(&a.limit, &b.limit, &line),
        energy: energy(&a.energy, &b.energy, &line),
    }
}

pub(super) fn contact(a: &ContactSample, b: &ContactSample, line: &impl Fn(f64, f64) -> f64) -> ContactSample {
    let pair = |p: [f64; 2], q: [f64; 2]| [line(p[0], q[0]), line(p[1], q[1])];
    ContactSample {
        gap_m: line(a.gap_m, b.gap_m),
        gap_rate_m_s: line(a.gap_rate_m_s, b.gap_rate_m_s),
        slip_m_s: line(a.slip_m_s, b.slip_m_s),
        normal_n: line(a.normal_n, b.normal_n),
        tangential_n: line(a.tangential_n, b.tangential_n),
        impulse_n_s: line(a.impulse_n_s, b.impulse_n_s),
        point_m: pair(a.point_m, b.point_m),
        normal: pair(a.normal, b.normal),
    }
}

pub(super) fn energy(a: &Energy, b: &Energy, line: &impl Fn(f64, f64) -> f64) -> Energy {
    let of = |field: fn(&Energy) -> f64| line(field(a), field(b));
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
