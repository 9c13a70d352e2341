//! Motors and brakes of the driven links.

use crate::law::Bristle;
use crate::scene::{Actuation, Brake, Motor, next_corner, torque};

/// A motor: which of the driven links (right, left) it turns, and by how much of its torque.
#[derive(Clone, Debug)]
pub struct Drive {
    actuation: Actuation,
    pub weights: [f64; 2],
    no_load_speed: Option<f64>,
    brake: Option<Brake>,
}

/// What a drive gives at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Pull {
    /// Rate of its shaft, rad/s.
    pub rate: f64,
    /// Torque, N·m, and its derivatives by rate and time.
    pub torque: f64,
    pub by_rate: f64,
    pub by_time: f64,
}

/// What a brake gives at one instant, and what that does to the memory of its bristle.
#[derive(Clone, Copy, Debug)]
pub struct Hold {
    pub pull: Pull,
    /// Derivative of its torque by the memory.
    pub by_memory: f64,
    /// What it adds to the memory's rate: `gain` times its torque.
    pub driven: f64,
    pub gain: f64,
}

impl Drive {
    pub fn new(motor: &Motor, weights: [f64; 2]) -> Self {
        let Motor { actuation, no_load_speed_rad_s, brake, .. } = motor;
        Self { actuation: actuation.clone(), weights, no_load_speed: *no_load_speed_rad_s, brake: *brake }
    }

    #[inline(always)]
    fn rate(&self, driven: [f64; 2]) -> f64 {
        self.weights[0] * driven[0] + self.weights[1] * driven[1]
    }

    /// What the brake holds it with, if it has one.
    #[inline(always)]
    pub fn hold(&self, t: f64, driven: [f64; 2], memory: Option<f64>) -> Option<Hold> {
        let (brake, rate) = (self.brake.as_ref()?, self.rate(driven));
        let Some((bristle, memory)) = brake.bristle.as_ref().zip(memory) else {
            let [torque, by_rate, by_time] = brake.torque(t, rate);
            let pull = Pull { rate, torque, by_rate, by_time };
            return Some(Hold { pull, by_memory: 0.0, driven: 0.0, gain: 0.0 });
        };
        let [torque, by_rate, by_time] = brake.held(t, rate + memory, bristle);
        // On the memory it acts the other way than on the shaft.
        let gain = -bristle.driven();
        Some(Hold { pull: Pull { rate, torque, by_rate, by_time }, by_memory: by_rate, driven: gain * torque, gain })
    }

    /// τ − |τ| q̇/q̇0, whichever way it turns.
    #[inline(always)]
    pub fn pull(&self, t: f64, driven: [f64; 2]) -> Pull {
        let rate = self.rate(driven);
        let (full, slope) = torque(&self.actuation, t);
        let Some(speed) = self.no_load_speed else { return Pull { rate, torque: full, by_rate: 0.0, by_time: slope } };
        let by_rate = -full.abs() / speed;
        let by_time = slope - slope * full.signum() * rate / speed;
        Pull { rate, torque: full + by_rate * rate, by_rate, by_time }
    }

    /// The bristle of its brake.
    pub fn bristle(&self) -> Option<Bristle> {
        self.brake.and_then(|brake| brake.bristle)
    }

    /// The next time at which its torque, or something of its brake, jumps.
    pub fn next_corner(&self, t: f64) -> f64 {
        let brake = self.brake.as_ref().map_or(f64::INFINITY, |brake| brake.next_corner(t));
        next_corner(&self.actuation, t).min(brake)
    }
}
