//! How a scene is run otherwise than it says: what `phalanx run` takes as flags. What would do nothing is refused.

use super::Model;
use crate::scene::table::{self, Table};
use crate::scene::words::SceneKind;
use crate::scene::{Construction, Engine, Integrator, LogRates, Preset, Scene};
use crate::units::{self, Dimension};

const RTOL: &str = "expected a number between 0 and 1, such as 1e-6";
const STEP: &str = "a step must be longer than 0; expected a time such as \"1 us\"";
const TOLERANCE: &str = "a tolerance must be more than 0; expected a length such as \"0.02 um\"";
const NUMERIC_RATE: &str = "a rate must be more than 0; expected a frequency such as \"10 kHz\"";
const PICTURE_RATE: &str = "a rate must be at least 0; expected a frequency such as \"5 kHz\", or \"0 Hz\" for none";
const DURATION: &str = "a run must be longer than 0; expected a time such as \"30 ms\"";

/// Settings of a run in place of those of its scene. Texts are as in a scene file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Method and tolerances of the analytic model.
    pub preset: Option<Preset>,
    /// Relative tolerance of the analytic model; absolute ones are scaled along.
    pub rtol: Option<String>,
    /// Coordinates of the engine model.
    pub construction: Option<Construction>,
    /// Fixed step of the engine model.
    pub step: Option<String>,
    /// Adaptive steps of the engine model: how far a joint may open in one.
    pub tolerance: Option<String>,
    /// Length of the run.
    pub duration_s: Option<f64>,
    /// Samples a second of simulated time.
    pub numeric_rate: Option<String>,
    /// Pictures a second of simulated time.
    pub picture_rate: Option<String>,
}

impl Overrides {
    /// Puts the settings into a scene.
    ///
    /// # Errors
    /// A setting of the model that does not run or of another kind of scene, or one that asks for more samples than a run may have.
    pub fn apply(&self, model: Model, scene: &mut Scene) -> Result<(), String> {
        if self.construction == Some(Construction::Reduced) {
            let why = match scene.kind() {
                SceneKind::Finger => None,
                SceneKind::Bodies => {
                    Some("a scene of discs has none; leave it out: every disc moves freely in the engine")
                }
                SceneKind::Gripper => {
                    Some("those of one finger only; leave it out: every body moves freely in the engine")
                }
            };
            if let Some(why) = why {
                return Err(format!("--construction reduced makes coordinates of joints, and {why}"));
            }
        }
        self.refuse_idle(model)?;
        if let Some(preset) = self.preset {
            scene.integrate_by(preset);
        }
        let Scene { duration_s: scene_duration_s, log, integrator, engine, .. } = scene;
        if let Some(construction) = self.construction {
            engine.construction = construction;
        }
        put(integrator, "integrator", [("rtol", &self.rtol)])?;
        put(engine, "engine", [("step", &self.step), ("tolerance", &self.tolerance)])?;
        put(log, "log", [("numeric_rate", &self.numeric_rate), ("picture_rate", &self.picture_rate)])?;
        if let Some(duration_s) = self.duration_s {
            *scene_duration_s = duration_s;
        }
        match log.excess(*scene_duration_s) {
            None => Ok(()),
            Some(excess) => {
                let flag = if excess.pictures { "--picture-rate" } else { "--numeric-rate" };
                Err(format!("{excess}; give {flag} \"{}\" or a shorter --duration", excess.remedy_rate()))
            }
        }
    }

    /// Refuses settings that the model would not look at.
    fn refuse_idle(&self, model: Model) -> Result<(), String> {
        if self.step.is_some() && self.tolerance.is_some() {
            return Err(
                "--step makes steps of one length and --tolerance chooses them: leave one of them out".to_string()
            );
        }
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
            Some((flag, _)) => Err(format!(
                "{flag} is a setting of the {} model and would do nothing here, where the {} model runs; leave {flag} out or \
                 say --model {}",
                other.name(),
                model.name(),
                other.name()
            )),
            None => Ok(()),
        }
    }
}

/// Checks a relative tolerance; gives back its text.
///
/// # Errors
/// What is allowed.
pub fn rtol(text: &str) -> Result<String, String> {
    field::<Integrator>("integrator", "rtol", RTOL, text)
}

/// Checks a step of the engine, see [`rtol`].
///
/// # Errors
/// What is allowed.
pub fn step(text: &str) -> Result<String, String> {
    field::<Engine>("engine", "step", STEP, text)
}

/// Checks a tolerance of the engine, see [`rtol`].
///
/// # Errors
/// What is allowed.
pub fn tolerance(text: &str) -> Result<String, String> {
    field::<Engine>("engine", "tolerance", TOLERANCE, text)
}

/// Checks a rate of samples, see [`rtol`].
///
/// # Errors
/// What is allowed.
pub fn numeric_rate(text: &str) -> Result<String, String> {
    field::<LogRates>("log", "numeric_rate", NUMERIC_RATE, text)
}

/// Checks a rate of pictures, see [`rtol`].
///
/// # Errors
/// What is allowed.
pub fn picture_rate(text: &str) -> Result<String, String> {
    field::<LogRates>("log", "picture_rate", PICTURE_RATE, text)
}

/// The length of a run, in s.
///
/// # Errors
/// What is allowed.
pub fn duration(text: &str) -> Result<f64, String> {
    units::positive(text, Dimension::Time, DURATION)
}

/// A value of a field, read as a scene reads it; `wanted` says what is allowed.
fn field<T: Table>(path: &str, key: &str, wanted: &str, text: &str) -> Result<String, String> {
    match table::set(&mut T::usual(), path, key, text) {
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
) -> Result<(), String> {
    let mut given = given.into_iter().filter_map(|(key, text)| Some((key, text.as_ref()?)));
    given.try_for_each(|(key, text)| table::set(section, path, key, text).map(drop))
}
