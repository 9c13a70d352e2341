//! Flags of `phalanx run` that override fields of the scene.

use clap::{Args, ValueEnum};

use super::Failure;
use crate::scene::{Construction, Preset, Scene};
use crate::trace::Model;
use crate::trace::overrides::{self, duration, numeric_rate, picture_rate, rtol, step, tolerance};

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PresetArg {
    /// For everyday runs
    Engineering,
    /// Tight tolerances, for reference results
    Reference,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ConstructionArg {
    /// Free bodies; every joint is a constraint
    Maximal,
    /// Joint coordinates of a tree, closed by one constraint
    Reduced,
}

/// Settings of the simulation given on the command line.
#[derive(Debug, Args)]
pub struct Overrides {
    /// Preset of integrator method and tolerances of the analytic model [default: as in the scene]
    #[arg(long, value_enum)]
    preset: Option<PresetArg>,

    /// Relative tolerance of the analytic model [default: from the scene or preset]; absolute tolerances are scaled by
    /// the same factor
    #[arg(long, value_name = "X", value_parser = rtol)]
    rtol: Option<f64>,

    /// Coordinates of the engine model [default: as in the scene]
    #[arg(long, value_enum)]
    construction: Option<ConstructionArg>,

    /// Use fixed steps of this size in the engine model, such as "1 us" [default: stepping of the scene]
    #[arg(long, value_name = "TIME", value_parser = step, conflicts_with = "tolerance")]
    step: Option<f64>,

    /// Use adaptive steps in the engine model, with this largest opening of a joint per step, such as "0.02 um"
    /// [default: stepping of the scene]
    #[arg(long, value_name = "LENGTH", value_parser = tolerance)]
    tolerance: Option<f64>,

    /// Duration of the run with its unit, such as "30 ms" [default: as in the scene]
    #[arg(long, value_name = "TIME", value_parser = duration)]
    duration: Option<f64>,

    /// Samples per simulated second in the log, such as "20 kHz" [default: as in the scene]; during impacts every step
    /// is also logged
    #[arg(long, value_name = "FREQUENCY", value_parser = numeric_rate)]
    numeric_rate: Option<f64>,

    /// Pictures per simulated second in the log, such as "1 kHz" ("0 Hz": none) [default: as in the scene]
    #[arg(long, value_name = "FREQUENCY", value_parser = picture_rate)]
    picture_rate: Option<f64>,
}

impl Overrides {
    /// Applies the flags to a scene.
    ///
    /// # Errors
    /// Returns an error if a flag belongs to the model that is not run, or if a flag for fingers is given for a scene
    /// of discs.
    pub fn apply(&self, model: Model, scene: &mut Scene) -> Result<(), Failure> {
        let Overrides { rtol, step, tolerance, duration, numeric_rate, picture_rate, .. } = self;
        let overrides = overrides::Overrides {
            preset: self.preset.map(|preset| match preset {
                PresetArg::Engineering => Preset::Engineering,
                PresetArg::Reference => Preset::Reference,
            }),
            rtol: *rtol,
            construction: self.construction.map(|construction| match construction {
                ConstructionArg::Maximal => Construction::Maximal,
                ConstructionArg::Reduced => Construction::Reduced,
            }),
            step_s: *step,
            tolerance_m: *tolerance,
            duration_s: *duration,
            numeric_hz: *numeric_rate,
            picture_hz: *picture_rate,
        };
        overrides.apply(model, scene).map_err(Failure::bad_input)
    }
}
