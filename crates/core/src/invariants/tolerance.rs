//! Tolerances of the invariants, from the settings of a run.

use crate::scene::{Engine, Integrator, Response, Stepping};
use crate::trace::Model;

/// Tolerances due to discretisation. Invariants that hold exactly (finite values, no pulling contact) have none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Tolerance of energies, as a fraction of the energy throughput.
    pub energy: f64,
    /// Largest gap at which a contact force is accepted; the opening during a step of `step_s` is added.
    pub gap_m: f64,
    /// Tolerance of the friction force, as a fraction of the normal force.
    pub friction: f64,
    pub loop_gap_m: f64,
    /// Length of fixed steps; 0 for adaptive steps, which are as short as contacts need. A force acts for a whole step,
    /// at whose end the surfaces may already be separated.
    pub step_s: f64,
    /// Whether contacts follow the scene's laws. rapier's own contact has a different friction law and no spring that
    /// bounds the depth.
    pub laws: bool,
}

impl Tolerances {
    /// Tolerances of a model with its settings; `loop_gap_m` is the tolerance of the scene for the engine's joints.
    pub fn for_settings(model: Model, integrator: &Integrator, engine: &Engine, loop_gap_m: f64) -> Self {
        match model {
            Model::Analytic => Self::analytic(integrator),
            Model::Engine => Self::engine(engine, loop_gap_m),
        }
    }

    /// Contact forces follow the state to rounding errors; the energy is as accurate as the integration.
    fn analytic(settings: &Integrator) -> Self {
        Self {
            energy: (10.0 * settings.rtol).max(1e-9),
            gap_m: 1e-15,
            friction: 1e-9,
            loop_gap_m: 0.0,
            step_s: 0.0,
            laws: true,
        }
    }

    /// Forces act for a step with fixed geometry, so they miss rotations within the step.
    fn engine(settings: &Engine, loop_gap_m: f64) -> Self {
        let (energy, gap_m, friction, step_s) = match settings.stepping {
            Stepping::Adaptive { tolerance_m, .. } => {
                let coarsening = (tolerance_m / 1e-7).max(1.0);
                (1e-3 * coarsening.sqrt(), tolerance_m, 0.02, 0.0)
            }
            // Half of g dt² at the accelerations of these grippers, 1e4 m/s².
            Stepping::Fixed { step_s } => {
                (1e-3 + 1e3 * step_s, 1e-9 + 5e3 * step_s * step_s, 0.02 + 2e4 * step_s, step_s)
            }
        };
        match settings.response {
            Response::Laws => Self { energy, gap_m, friction, loop_gap_m, step_s, laws: true },
            // Rigid contacts have impulses instead of forces.
            Response::Rapier { .. } => {
                Self { energy: 1.0, gap_m: f64::INFINITY, friction: f64::INFINITY, loop_gap_m, step_s, laws: false }
            }
        }
    }
}
