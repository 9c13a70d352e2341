//! Settings that override those of a scene, such as the flags of `phalanx run`. Settings without effect are rejected.

use super::Model;
use crate::scene::keywords::SceneKind;
use crate::scene::table::{self, SettingsSection};
use crate::scene::{Construction, Engine, Integrator, LogRates, Preset, Scene};
use crate::units::{self, Dimension};

const RTOL: &str = "expected a number between 0 and 1, such as 1e-6";
const STEP: &str = "a step must be longer than 0; expected a time such as \"1 us\"";
const TOLERANCE: &str = "a tolerance must be more than 0; expected a length such as \"0.02 um\"";
const NUMERIC_RATE: &str = "a rate must be more than 0; expected a frequency such as \"10 kHz\"";
const PICTURE_RATE: &str = "a rate must be at least 0; expected a frequency such as \"5 kHz\", or \"0 Hz\" for none";
const DURATION: &str = "a run must be longer than 0; expected a time such as \"30 ms\"";

/// Settings of a run that replace those of its scene. Texts have the format of a scene file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Method and tolerances of the analytic model.
    pub preset: Option<Preset>,
    /// Relative tolerance of the analytic model; absolute tolerances are scaled with it.
    pub rtol: Option<String>,
    /// Coordinates of the engine model.
    pub construction: Option<Construction>,
    /// Fixed step of the engine model.
    pub step: Option<String>,
    /// Adaptive steps of the engine model: largest joint opening per step.
    pub tolerance: Option<String>,
    /// Length of the run.
    pub duration_s: Option<f64>,
    /// Samples per second of simulated time.
    pub numeric_rate: Option<String>,
    /// Pictures per second of simulated time.
    pub picture_rate: Option<String>,
}

impl Overrides {
    /// Applies the settings to a scene.
    ///
    /// # Errors
    /// Returns an error if a setting belongs to the other model or to another kind of scene, or requests more samples
    /// than a run may have.
    pub fn apply(&self, model: Model, scene: &mut Scene) -> Result<(), String> {
        if self.construction == Some(Construction::Reduced) {
            let reason = match scene.kind() {
                SceneKind::Finger => None,
                SceneKind::Bodies => {
                    Some("a scene of discs has no joints; leave the flag out: every disc moves freely in the engine")
                }
                SceneKind::Gripper => Some(
                    "they are available for one finger only; leave the flag out: every body moves freely in the engine",
                ),
            };
            if let Some(reason) = reason {
                return Err(format!("--construction reduced uses joint coordinates, and {reason}"));
            }
        }
        self.reject_unused(model)?;
        if let Some(preset) = self.preset {
            scene.apply_preset(preset);
        }
        let Scene { duration_s: scene_duration_s, log, integrator, engine, .. } = scene;
        if let Some(construction) = self.construction {
            engine.construction = construction;
        }
        set_fields(integrator, "integrator", [("rtol", &self.rtol)])?;
        set_fields(engine, "engine", [("step", &self.step), ("tolerance", &self.tolerance)])?;
        set_fields(log, "log", [("numeric_rate", &self.numeric_rate), ("picture_rate", &self.picture_rate)])?;
        if let Some(duration_s) = self.duration_s {
            *scene_duration_s = duration_s;
        }
        match log.excess(*scene_duration_s) {
            None => Ok(()),
            Some(excess) => {
                let flag = if excess.pictures { "--picture-rate" } else { "--numeric-rate" };
                Err(format!("{excess}; use {flag} \"{}\" or a shorter --duration", excess.suggested_rate()))
            }
        }
    }

    /// Rejects settings that the model does not use.
    fn reject_unused(&self, model: Model) -> Result<(), String> {
        if self.step.is_some() && self.tolerance.is_some() {
            return Err("--step sets a fixed step and --tolerance adapts the step: leave one of them out".to_string());
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
        match flags.iter().find(|(_, is_given)| *is_given) {
            Some((flag, _)) => Err(format!(
                "{flag} is a setting of the {} model and has no effect here, because the {} model runs; leave {flag} out or \
                 use --model {}",
                other.name(),
                model.name(),
                other.name()
            )),
            None => Ok(()),
        }
    }
}

/// Checks a relative tolerance and returns its text.
///
/// # Errors
/// Returns an error if the text is not an allowed value; the message says what is allowed.
pub fn rtol(text: &str) -> Result<String, String> {
    check_field::<Integrator>("integrator", "rtol", RTOL, text)
}

/// Checks a fixed step of the engine, see [`rtol`].
///
/// # Errors
/// Returns an error if the text is not an allowed value; the message says what is allowed.
pub fn step(text: &str) -> Result<String, String> {
    check_field::<Engine>("engine", "step", STEP, text)
}

/// Checks a tolerance of the engine, see [`rtol`].
///
/// # Errors
/// Returns an error if the text is not an allowed value; the message says what is allowed.
pub fn tolerance(text: &str) -> Result<String, String> {
    check_field::<Engine>("engine", "tolerance", TOLERANCE, text)
}

/// Checks a sampling rate, see [`rtol`].
///
/// # Errors
/// Returns an error if the text is not an allowed value; the message says what is allowed.
pub fn numeric_rate(text: &str) -> Result<String, String> {
    check_field::<LogRates>("log", "numeric_rate", NUMERIC_RATE, text)
}

/// Checks a picture rate, see [`rtol`].
///
/// # Errors
/// Returns an error if the text is not an allowed value; the message says what is allowed.
pub fn picture_rate(text: &str) -> Result<String, String> {
    check_field::<LogRates>("log", "picture_rate", PICTURE_RATE, text)
}

/// Parses the duration of a run, in s.
///
/// # Errors
/// Returns an error if the text is not an allowed value; the message says what is allowed.
pub fn duration(text: &str) -> Result<f64, String> {
    units::parse_positive(text, Dimension::Time, DURATION)
}

/// Checks a field value as in a scene file; `expected` describes the allowed values.
fn check_field<T: SettingsSection>(path: &str, key: &str, expected: &str, text: &str) -> Result<String, String> {
    match table::set(&mut T::defaults(), path, key, text) {
        Ok(true) => Ok(text.to_string()),
        Ok(false) => Err(expected.to_string()),
        Err(error) => Err(format!("{error}; {expected}")),
    }
}

/// Replaces the fields of a section by the given values.
fn set_fields<T: SettingsSection, const N: usize>(
    section: &mut T,
    path: &str,
    values: [(&str, &Option<String>); N],
) -> Result<(), String> {
    let mut values = values.into_iter().filter_map(|(key, text)| Some((key, text.as_ref()?)));
    values.try_for_each(|(key, text)| table::set(section, path, key, text).map(drop))
}
