//! Flags of `phalanx run` that override fields of the scene.

use clap::Args;

use super::Failure;
use super::parsers::choice;
use crate::scene::{Construction, Preset, Scene};
use crate::trace::Model;
use crate::trace::overrides::{self, duration, numeric_rate, picture_rate, rtol, step, tolerance};

/// Settings of the simulation given on the command line.
#[derive(Debug, Args)]
pub struct Overrides {
    /// Preset of integrator method and tolerances of the analytic model: engineering for everyday runs, reference for
    /// reference results with tight tolerances [default: as in the scene]
    #[arg(long, value_parser = choice([("engineering", "", Preset::Engineering), ("reference", "", Preset::Reference)]))]
    preset: Option<Preset>,

    /// Relative tolerance of the analytic model [default: from the scene or preset]; absolute tolerances are scaled by
    /// the same factor
    #[arg(long, value_name = "X", value_parser = rtol)]
    rtol: Option<f64>,

    /// Coordinates of the engine model: maximal for free bodies, whose joints are all constraints; reduced for joint
    /// coordinates of a tree, closed by one constraint [default: as in the scene]
    #[arg(long, value_parser = choice([("maximal", "", Construction::Maximal), ("reduced", "", Construction::Reduced)]))]
    construction: Option<Construction>,

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
        let overrides = overrides::Overrides {
            preset: self.preset,
            rtol: self.rtol,
            construction: self.construction,
            step_s: self.step,
            tolerance_m: self.tolerance,
            duration_s: self.duration,
            numeric_hz: self.numeric_rate,
            picture_hz: self.picture_rate,
        };
        overrides.apply(model, scene).map_err(Failure::bad_input)
    }
}
