//! Flags of `phalanx run` that stand in for what the scene says, and refusals of those that would do nothing.

use clap::{Args, ValueEnum};

use super::Failure;
use crate::scene::{AnyScene, Construction, Engine, Preset, Stepping};
use crate::trace::{Model, Numerics};
use crate::units::{self, Dimension};

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
    #[arg(long, value_name = "X", value_parser = relative)]
    rtol: Option<f64>,

    /// Coordinates of the engine model, instead of those of the scene
    #[arg(long, value_enum)]
    construction: Option<ConstructionArg>,

    /// Fixed step of the engine model with its unit, such as "1 us", instead of the stepping of the scene
    #[arg(long, value_name = "TIME", value_parser = step, conflicts_with = "tolerance")]
    step: Option<f64>,

    /// Adaptive steps of the engine model: how far a joint may open in one, such as "0.02 um", instead of the stepping
    /// of the scene
    #[arg(long, value_name = "LENGTH", value_parser = opening)]
    tolerance: Option<f64>,

    /// Length of the run with its unit, such as "30 ms", instead of that of the scene
    #[arg(long, value_name = "TIME", value_parser = duration)]
    duration: Option<f64>,

    /// Samples a second of simulated time in the log, such as "20 kHz", instead of that of the scene; impacts are logged
    /// at every step besides
    #[arg(long, value_name = "FREQUENCY", value_parser = numeric_rate)]
    numeric_rate: Option<f64>,

    /// Pictures a second of simulated time in the log, such as "1 kHz" ("0 Hz": none), instead of that of the scene
    #[arg(long, value_name = "FREQUENCY", value_parser = picture_rate)]
    picture_rate: Option<f64>,
}

impl Overrides {
    /// Puts the flags into a scene.
    ///
    /// # Errors
    /// A flag of the model that does not run, or, for a scene of discs, of a finger.
    pub fn apply(&self, model: Model, scene: &mut AnyScene) -> Result<(), Failure> {
        if matches!(scene, AnyScene::Bodies(_)) && self.construction == Some(ConstructionArg::Reduced) {
            return Err(Failure::bad_input(
                "--construction reduced makes coordinates of joints, and a scene of discs has none; leave it out: every disc \
                 moves freely in the engine",
            ));
        }
        let Numerics { duration_s: scene_duration_s, log, integrator, engine } = scene.into();
        self.refuse_idle(model)?;
        if let Some(preset) = self.preset {
            let preset = match preset {
                PresetArg::Engineering => Preset::Engineering,
                PresetArg::Reference => Preset::Reference,
            };
            *integrator = integrator.with_preset(preset);
        }
        if let Some(rtol) = self.rtol {
            *integrator = integrator.with_rtol(rtol);
        }
        if let Some(construction) = self.construction {
            engine.construction = match construction {
                ConstructionArg::Maximal => Construction::Maximal,
                ConstructionArg::Reduced => Construction::Reduced,
            };
        }
        if let Some(step_s) = self.step {
            engine.stepping = Stepping::Fixed { step_s };
        }
        if let Some(tolerance_m) = self.tolerance {
            let max_step_s = longest_step(engine);
            engine.stepping = Stepping::Adaptive { tolerance_m, max_step_s };
        }
        if let Some(duration_s) = self.duration {
            *scene_duration_s = duration_s;
        }
        if let Some(numeric_hz) = self.numeric_rate {
            log.numeric_hz = numeric_hz;
        }
        if let Some(picture_hz) = self.picture_rate {
            log.picture_hz = picture_hz;
        }
        match log.excess(*scene_duration_s) {
            None => Ok(()),
            Some(excess) => {
                let flag = if excess.pictures { "--picture-rate" } else { "--numeric-rate" };
                Err(Failure::bad_input(format!(
                    "{excess}; give {flag} \"{}\" or a shorter --duration",
                    excess.remedy_rate()
                )))
            }
        }
    }

    /// Refuses flags that the model would not look at.
    fn refuse_idle(&self, model: Model) -> Result<(), Failure> {
        let (flags, other) = match model {
            Model::Analytic => (
                [
                    ("--construction", self.construction.is_some()),
                    ("--step", self.step.is_some()),
                    ("--tolerance", self.tolerance.is_some()),
                ],
                Model::Engine,
            ),
            Model::Engine => {
                ([("--preset", self.preset.is_some()), ("--rtol", self.rtol.is_some()), ("", false)], Model::Analytic)
            }
        };
        match flags.iter().find(|(_, given)| *given) {
            Some((flag, _)) => Err(Failure::bad_input(format!(
                "{flag} is a setting of the {} model and would do nothing here, where the {} model runs; leave {flag} out or \
                 say --model {}",
                other.name(),
                model.name(),
                other.name()
            ))),
            None => Ok(()),
        }
    }
}

/// The longest adaptive step of the scene; the default where its steps are fixed.
fn longest_step(engine: &Engine) -> f64 {
    match (engine.stepping, Engine::DEFAULT.stepping) {
        (Stepping::Adaptive { max_step_s, .. }, _) | (_, Stepping::Adaptive { max_step_s, .. }) => max_step_s,
        (Stepping::Fixed { step_s }, Stepping::Fixed { .. }) => step_s,
    }
}

fn relative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("expected a number between 0 and 1, such as 1e-6".to_string()),
    }
}

fn duration(text: &str) -> Result<f64, String> {
    positive(text, Dimension::Time, "a run must be longer than 0; expected a time such as \"30 ms\"")
}

fn step(text: &str) -> Result<f64, String> {
    positive(text, Dimension::Time, "a step must be longer than 0; expected a time such as \"1 us\"")
}

fn numeric_rate(text: &str) -> Result<f64, String> {
    positive(text, Dimension::Frequency, "a rate must be more than 0; expected a frequency such as \"10 kHz\"")
}

fn picture_rate(text: &str) -> Result<f64, String> {
    match units::parse(text, Dimension::Frequency) {
        Ok(value) if value >= 0.0 => Ok(value),
        Ok(_) => {
            Err("a rate must be at least 0; expected a frequency such as \"5 kHz\", or \"0 Hz\" for none".to_string())
        }
        Err(error) => Err(error.to_string()),
    }
}

fn opening(text: &str) -> Result<f64, String> {
    positive(text, Dimension::Length, "a tolerance must be more than 0; expected a length such as \"0.02 um\"")
}

/// A quantity above 0.
pub(super) fn positive(text: &str, dimension: Dimension, otherwise: &str) -> Result<f64, String> {
    match units::parse(text, dimension) {
        Ok(value) if value > 0.0 => Ok(value),
        Ok(_) => Err(otherwise.to_string()),
        Err(error) => Err(error.to_string()),
    }
}
