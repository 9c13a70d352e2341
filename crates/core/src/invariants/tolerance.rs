//! How much of each invariant a run may miss, by the settings it is made with.

use crate::scene::{Engine, Integrator, Response, Stepping};
use crate::trace::Model;

/// What discretisation leaves of the invariants. Where they hold exactly (finite, nothing pulls) there is no tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Part of the energy that went through the run.
    pub energy: f64,
    /// A force may still act where the gap has opened this far, beside what it opens in a step of `step_s`.
    pub gap_m: f64,
    /// Part of the normal force.
    pub friction: f64,
    pub loop_gap_m: f64,
    /// Longest step of fixed steps: a force belongs to a whole step, at whose end its surfaces may have parted. 0 where
    /// steps are as short as contact needs.
    pub step_s: f64,
    /// Whether contacts follow the scene's laws. rapier's own has neither their friction nor a spring that bounds depth.
    pub laws: bool,
}

impl Tolerances {
    /// Those of a model at its settings; `loop_gap_m` is what the scene allows the engine's joints.
    pub fn of(model: Model, integrator: &Integrator, engine: &Engine, loop_gap_m: f64) -> Self {
        match model {
            Model::Analytic => Self::analytic(integrator),
            Model::Engine => Self::engine(engine, loop_gap_m),
        }
    }

    /// Contact forces follow the state to rounding; energy is as good as the integration.
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

    /// Forces belong to a step whose geometry is frozen: they miss what turns meanwhile.
    fn engine(settings: &Engine, loop_gap_m: f64) -> Self {
        let (energy, gap_m, friction, step_s) = match settings.stepping {
            Stepping::Adaptive { tolerance_m, .. } => {
                let coarse = (tolerance_m / 1e-7).max(1.0);
                (1e-3 * coarse.sqrt(), tolerance_m, 0.02, 0.0)
            }
            // Half of g dt² at the accelerations of these grippers, 1e4 m/s².
            Stepping::Fixed { step_s } => {
                (1e-3 + 1e3 * step_s, 1e-9 + 5e3 * step_s * step_s, 0.02 + 2e4 * step_s, step_s)
            }
        };
        match settings.response {
            Response::Laws => Self { energy, gap_m, friction, loop_gap_m, step_s, laws: true },
            // A rigid contact has impulses instead of forces.
            Response::Rapier { .. } => {
                Self { energy: 1.0, gap_m: f64::INFINITY, friction: f64::INFINITY, loop_gap_m, step_s, laws: false }
            }
        }
    }
}
