//! Flags of `phalanx run` that are names for fields of the scene, and refusals of those that would do nothing.

use clap::{Args, ValueEnum};

use super::Failure;
use crate::scene::table::{self, Table};
use crate::scene::{AnyScene, Construction, Engine, Integrator, LogRates, Preset};
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

const RTOL: &str = "expected a number between 0 and 1, such as 1e-6";
const STEP: &str = "a step must be longer than 0; expected a time such as \"1 us\"";
const TOLERANCE: &str = "a tolerance must be more than 0; expected a length such as \"0.02 um\"";
const NUMERIC_RATE: &str = "a rate must be more than 0; expected a frequency such as \"10 kHz\"";
const PICTURE_RATE: &str = "a rate must be at least 0; expected a frequency such as \"5 kHz\", or \"0 Hz\" for none";

/// Settings given on the command line.
#[derive(Debug, Args)]
pub struct Overrides {
    /// Integrator method and tolerances of the analytic model, instead of those of the scene
    #[arg(long, value_enum)]
    preset: Option<PresetArg>,

    /// Relative tolerance of the analytic model, instead of that of the scene or preset; absolute ones are scaled along
    #[arg(long, value_name = "X", value_parser = field::<Integrator>("integrator", "rtol", RTOL))]
    rtol: Option<String>,

    /// Coordinates of the engine model, instead of those of the scene
    #[arg(long, value_enum)]
    construction: Option<ConstructionArg>,

    /// Fixed step of the engine model with its unit, such as "1 us", instead of the stepping of the scene
    #[arg(long, value_name = "TIME", value_parser = field::<Engine>("engine", "step", STEP), conflicts_with = "tolerance")]
    step: Option<String>,

    /// Adaptive steps of the engine model: how far a joint may open in one, such as "0.02 um", instead of the stepping
    /// of the scene
    #[arg(long, value_name = "LENGTH", value_parser = field::<Engine>("engine", "tolerance", TOLERANCE))]
    tolerance: Option<String>,

    /// Length of the run with its unit, such as "30 ms", instead of that of the scene
    #[arg(long, value_name = "TIME", value_parser = duration)]
    duration: Option<f64>,

    /// Samples a second of simulated time in the log, such as "20 kHz", instead of that of the scene; impacts are logged
    /// at every step besides
    #[arg(long, value_name = "FREQUENCY", value_parser = field::<LogRates>("log", "numeric_rate", NUMERIC_RATE))]
    numeric_rate: Option<String>,

    /// Pictures a second of simulated time in the log, such as "1 kHz" ("0 Hz": none), instead of that of the scene
    #[arg(long, value_name = "FREQUENCY", value_parser = field::<LogRates>("log", "picture_rate", PICTURE_RATE))]
    picture_rate: Option<String>,
}

impl Overrides {
    /// Puts the flags into a scene.
    ///
    /// # Errors
    /// A flag of the model that does not run, or, for a scene of discs, of a finger.
    pub fn apply(&self, model: Model, scene: &mut AnyScene) -> Result<(), Failure> {
        if self.construction == Some(ConstructionArg::Reduced) {
            let why = match scene {
                AnyScene::Finger(_) => None,
                AnyScene::Bodies(_) => {
                    Some("a scene of discs has none; leave it out: every disc moves freely in the engine")
                }
                AnyScene::Gripper(_) => {
                    Some("those of one finger only; leave it out: every body moves freely in the engine")
                }
            };
            if let Some(why) = why {
                return Err(Failure::bad_input(format!(
                    "--construction reduced makes coordinates of joints, and {why}"
                )));
            }
        }
        let mut numerics = Numerics::from(scene);
        self.refuse_idle(model)?;
        if let Some(preset) = self.preset {
            let preset = match preset {
                PresetArg::Engineering => Preset::Engineering,
                PresetArg::Reference => Preset::Reference,
            };
            numerics.integrate_by(preset);
        }
        let Numerics { duration_s: scene_duration_s, log, integrator, engine, .. } = numerics;
        if let Some(construction) = self.construction {
            engine.construction = match construction {
                ConstructionArg::Maximal => Construction::Maximal,
                ConstructionArg::Reduced => Construction::Reduced,
            };
        }
        put(integrator, "integrator", [("rtol", &self.rtol)])?;
        put(engine, "engine", [("step", &self.step), ("tolerance", &self.tolerance)])?;
        put(log, "log", [("numeric_rate", &self.numeric_rate), ("picture_rate", &self.picture_rate)])?;
        if let Some(duration_s) = self.duration {
            *scene_duration_s = duration_s;
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

/// A value of a field, read as a scene reads it; `wanted` says what is allowed.
fn field<T: Table>(
    path: &'static str,
    key: &'static str,
    wanted: &'static str,
) -> impl Fn(&str) -> Result<String, String> + Clone {
    move |text| match table::set(&mut T::usual(), path, key, text) {
        Ok(true) => Ok(text.to_string()),
        Ok(false) => Err(wanted.to_string()),
        Err(error) => Err(format!("{error}; {wanted}")),
    }
}

/// Puts what is given in place of what the scene says.
fn put<T: Table, const N: usize>(
    section: &mut T,
    path: &str,
    given: [(&str, &Option<String>); N],
) -> Result<(), Failure> {
    let mut given = given.into_iter().filter_map(|(key, text)| Some((key, text.as_ref()?)));
    given.try_for_each(|(key, text)| table::set(section, path, key, text).map(drop)).map_err(Failure::bad_input)
}

fn duration(text: &str) -> Result<f64, String> {
    positive(text, Dimension::Time, "a run must be longer than 0; expected a time such as \"30 ms\"")
}

/// A quantity above 0.
pub(super) fn positive(text: &str, dimension: Dimension, otherwise: &str) -> Result<f64, String> {
    match units::parse(text, dimension) {
        Ok(value) if value > 0.0 => Ok(value),
        Ok(_) => Err(otherwise.to_string()),
        Err(error) => Err(error.to_string()),
    }
}
