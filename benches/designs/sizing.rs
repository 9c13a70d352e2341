//! Motor and spring sized to the rigid phase of the test trajectory (thesis §3.3.2).

use phalanx::fivebar::dynamics::{Dynamics, inverse_dynamics};
use phalanx::fivebar::kinematics::{directions, passive_rates, reference_gamma};
use phalanx::gripper::{Circle, Finger, contact_proximal, final_posture, start_posture};

/// k_s and τ11.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizing {
    pub motor_n_m: f64,
    pub spring_n_m: f64,
}

/// Length of the test trajectory.
const LENGTH_S: f64 = 0.010;
const SAMPLES: usize = 800;

/// q11 goes from start to final posture on s(x) = 35x⁴ − 84x⁵ + 70x⁶ − 20x⁷, x = t/T; the finger stays straight until the
/// proximal contact, a time t_c. With the inverse dynamics r = M q̈ + c:
/// k_s = max r2/|∂q22/∂q21| and τ11 = RMS of r1 + r2, both over 0 … t_c. `None` if the finger cannot grasp the disc.
pub fn rigid(finger: &Finger, disc: Circle, opening_rad: f64, gravity_m_s2: [f64; 2]) -> Option<Sizing> {
    let lengths = &finger.lengths;
    let gamma = reference_gamma(lengths);
    let dynamics = Dynamics::new(finger, gamma, gravity_m_s2);
    let start = start_posture(lengths, disc, opening_rad).ok()?;
    let end = final_posture(lengths, finger.assembly, disc).ok()?.posture;
    let swing = contact_proximal(lengths.half_width_m, disc).ok()?.q21_rad - start.q21_rad;
    let stroke = end.q11_rad - start.q11_rad;
    if stroke <= swing {
        return None;
    }
    let contact_s = LENGTH_S * bisect(|x| stroke * position(x) - swing);

    let (mut spring_n_m, mut squares) = (f64::MIN, 0.0);
    for i in 0..=SAMPLES {
        let x = contact_s / LENGTH_S * i as f64 / SAMPLES as f64;
        let (moved, speed) = (stroke * position(x), stroke * speed(x) / LENGTH_S);
        let acceleration = stroke * acceleration(x) / LENGTH_S.powi(2);
        let q = [start.q11_rad + moved, start.q21_rad + moved];
        let r = inverse_dynamics(&dynamics, q, [speed; 2], [acceleration; 2]);
        let slope = passive_rates(lengths, &directions(lengths, gamma, q)).a4[1] - 1.0;
        spring_n_m = spring_n_m.max(r[1] / slope.abs());
        let weight = if i == 0 || i == SAMPLES { 0.5 } else { 1.0 };
        squares += weight * (r[0] + r[1]).powi(2);
    }
    Some(Sizing { motor_n_m: (squares / SAMPLES as f64).sqrt(), spring_n_m })
}

fn position(x: f64) -> f64 {
    x.powi(4) * (35.0 + x * (-84.0 + x * (70.0 - 20.0 * x)))
}

fn speed(x: f64) -> f64 {
    140.0 * (x * (1.0 - x)).powi(3)
}

fn acceleration(x: f64) -> f64 {
    420.0 * (x * (1.0 - x)).powi(2) * (1.0 - 2.0 * x)
}

/// Where a growing function on 0…1 is zero.
fn bisect(value: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if value(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
