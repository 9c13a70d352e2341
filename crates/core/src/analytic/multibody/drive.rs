//! Motors and brakes of the driven links.

use crate::law::Bristle;
use crate::scene::{Actuation, Brake, Motor, next_discontinuity, torque};

/// A motor with its brake. `weights` are the parts of its torque that act on the driven links (right, left).
#[derive(Clone, Debug)]
pub struct Drive {
    actuation: Actuation,
    pub weights: [f64; 2],
    no_load_speed: Option<f64>,
    brake: Option<Brake>,
}

/// A torque on a drive's shaft at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShaftTorque {
    /// Rate of the shaft, rad/s.
    pub rate: f64,
    /// Torque, N·m.
    pub torque: f64,
    /// Derivative of the torque with respect to the rate.
    pub by_rate: f64,
    /// Derivative of the torque with respect to time.
    pub by_time: f64,
}

/// The torque of a brake at one instant, and its effect on the state of its bristle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BrakeTorque {
    pub shaft: ShaftTorque,
    /// Derivative of the torque with respect to the bristle state.
    pub by_bristle: f64,
    /// Contribution to the rate of the bristle state: `gain` times the torque.
    pub bristle_rate: f64,
    pub gain: f64,
}

impl Drive {
    pub fn new(motor: &Motor, weights: [f64; 2]) -> Self {
        let Motor { actuation, no_load_speed_rad_s, brake, .. } = motor;
        Self { actuation: actuation.clone(), weights, no_load_speed: *no_load_speed_rad_s, brake: *brake }
    }

    #[inline(always)]
    fn rate(&self, driven_rates: [f64; 2]) -> f64 {
        self.weights[0] * driven_rates[0] + self.weights[1] * driven_rates[1]
    }

    /// Torque of the brake, if the drive has one.
    #[inline(always)]
    pub fn brake_torque(&self, t: f64, driven_rates: [f64; 2], bristle_state: Option<f64>) -> Option<BrakeTorque> {
        let (brake, rate) = (self.brake.as_ref()?, self.rate(driven_rates));
        let Some((bristle, bristle_state)) = brake.bristle.as_ref().zip(bristle_state) else {
            let [torque, by_rate, by_time] = brake.torque(t, rate);
            let shaft = ShaftTorque { rate, torque, by_rate, by_time };
            return Some(BrakeTorque { shaft, by_bristle: 0.0, bristle_rate: 0.0, gain: 0.0 });
        };
        let [torque, by_rate, by_time] = brake.bristle_torque(t, rate + bristle_state, bristle);
        // The torque acts on the bristle state in the opposite direction.
        let gain = -bristle.stretch_gain();
        Some(BrakeTorque {
            shaft: ShaftTorque { rate, torque, by_rate, by_time },
            by_bristle: by_rate,
            bristle_rate: gain * torque,
            gain,
        })
    }

    /// Motor torque τ − |τ| q̇/q̇0, for both directions of rotation.
    #[inline(always)]
    pub fn motor_torque(&self, t: f64, driven_rates: [f64; 2]) -> ShaftTorque {
        let rate = self.rate(driven_rates);
        let (full, slope) = torque(&self.actuation, t);
        let Some(speed) = self.no_load_speed else {
            return ShaftTorque { rate, torque: full, by_rate: 0.0, by_time: slope };
        };
        let by_rate = -full.abs() / speed;
        let by_time = slope - slope * full.signum() * rate / speed;
        ShaftTorque { rate, torque: full + by_rate * rate, by_rate, by_time }
    }

    /// Returns the bristle of the brake.
    pub fn bristle(&self) -> Option<Bristle> {
        self.brake.and_then(|brake| brake.bristle)
    }

    /// Next time at which the torque of the motor, or a property of the brake, is discontinuous.
    pub fn next_discontinuity(&self, t: f64) -> f64 {
        let brake = self.brake.as_ref().map_or(f64::INFINITY, |brake| brake.next_discontinuity(t));
        next_discontinuity(&self.actuation, t).min(brake)
    }
}
