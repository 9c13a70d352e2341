//! Flags of `phalanx run` that are names for fields of the scene.

use clap::{Args, ValueEnum};

use super::Failure;
use crate::scene::{Construction, Preset, Scene};
use crate::trace::Model;
use crate::trace::overrides::{self as of, duration, numeric_rate, picture_rate, rtol, step, tolerance};
pub(super) use crate::units::positive;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PresetArg {
    /// For everyday runs
    Engineering,
    /// Tight tolerances, for figures to compare with
    Reference,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ConstructionArg {
    /// Free bodies, every joint a constraint
    Maximal,
    /// A tree of joints in its own coordinates, closed by one constraint
    Reduced,
}

/// Settings given on the command line.
#[derive(Debug, Args)]
pub struct Overrides {
    /// Integrator method and tolerances of the analytic model, instead of those of the scene
    #[arg(long, value_enum)]
    preset: Option<PresetArg>,

    /// Relative tolerance of the analytic model, instead of that of the scene or preset; absolute ones are scaled along
    #[arg(long, value_name = "X", value_parser = rtol)]
    rtol: Option<String>,

    /// Coordinates of the engine model, instead of those of the scene
    #[arg(long, value_enum)]
    construction: Option<ConstructionArg>,

    /// Fixed step of the engine model with its unit, such as "1 us", instead of the stepping of the scene
    #[arg(long, value_name = "TIME", value_parser = step, conflicts_with = "tolerance")]
    step: Option<String>,

    /// Adaptive steps of the engine model: how far a joint may open in one, such as "0.02 um", instead of the stepping
    /// of the scene
    #[arg(long, value_name = "LENGTH", value_parser = tolerance)]
    tolerance: Option<String>,

    /// Length of the run with its unit, such as "30 ms", instead of that of the scene
    #[arg(long, value_name = "TIME", value_parser = duration)]
    duration: Option<f64>,

    /// Samples a second of simulated time in the log, such as "20 kHz", instead of that of the scene; impacts are logged
    /// at every step besides
    #[arg(long, value_name = "FREQUENCY", value_parser = numeric_rate)]
    numeric_rate: Option<String>,

    /// Pictures a second of simulated time in the log, such as "1 kHz" ("0 Hz": none), instead of that of the scene
    #[arg(long, value_name = "FREQUENCY", value_parser = picture_rate)]
    picture_rate: Option<String>,
}

impl Overrides {
    /// Puts the flags into a scene.
    ///
    /// # Errors
    /// A flag of the model that does not run, or, for a scene of discs, of a finger.
    pub fn apply(&self, model: Model, scene: &mut Scene) -> Result<(), Failure> {
        let preset = self.preset.map(|preset| match preset {
            PresetArg::Engineering => Preset::Engineering,
            PresetArg::Reference => Preset::Reference,
        });
        let construction = self.construction.map(|construction| match construction {
            ConstructionArg::Maximal => Construction::Maximal,
            ConstructionArg::Reduced => Construction::Reduced,
        });
        let overrides = of::Overrides {
            preset,
            rtol: self.rtol.clone(),
            construction,
            step: self.step.clone(),
            tolerance: self.tolerance.clone(),
            duration_s: self.duration,
            numeric_rate: self.numeric_rate.clone(),
            picture_rate: self.picture_rate.clone(),
        };
        overrides.apply(model, scene).map_err(Failure::bad_input)
    }
}
