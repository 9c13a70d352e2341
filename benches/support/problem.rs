//! A closing: a scene with its model and initial state.

use phalanx::analytic::{Model, QUADRATURES};
use phalanx::integrator::{Fixed, State};
use phalanx::scene::{Profile, Scene, parse};

/// Size of the ensemble.
pub const MEMBERS: usize = 15;

/// Relative change of the motor torque between members. It is negligible for the mechanics, but changes rounding errors and
/// step sizes.
pub const TORQUE_STEP: f64 = 1e-9;

/// A closing to integrate.
#[derive(Clone, Debug)]
pub struct Problem {
    pub scene: Scene,
    pub model: Model,
    pub start: State<Fixed<2, QUADRATURES>>,
}

impl Problem {
    pub fn new(scene: Scene) -> Self {
        let initial = &scene.finger().initial;
        let start = State {
            q: [initial.q11_rad, initial.q21_rad],
            v: [initial.qd11_rad_s, initial.qd21_rad_s],
            z: [0.0; QUADRATURES],
        };
        Self { model: Model::new(&scene.hand), start, scene }
    }

    /// Returns the closing with its constant motor torque multiplied by `factor`.
    pub fn with_torque(&self, factor: f64) -> Self {
        let mut scene = self.scene.clone();
        if let Profile::Constant { value } = &mut scene.finger_mut().motor.actuation {
            *value *= factor;
        }
        Self::new(scene)
    }

    pub fn duration_s(&self) -> f64 {
        self.scene.duration_s
    }
}

/// Returns design 95 of the thesis.
pub fn design_95() -> Problem {
    let text = include_str!("../../scenes/experiment-95.toml");
    match parse(text, "experiment-95.toml") {
        Ok(scene) => Problem::new(scene),
        Err(error) => panic!("the scene cannot be loaded: {error}"),
    }
}

/// Returns design 95 with τ11 (1 + i · 1e-9), i = 0 … 14.
pub fn ensemble() -> Vec<Problem> {
    let nominal = design_95();
    (0..MEMBERS).map(|i| nominal.with_torque(1.0 + i as f64 * TORQUE_STEP)).collect()
}
