//! Settings that override those of a scene, such as the flags of `phalanx run`. Settings without effect are rejected.

use super::Model;
use crate::scene::{ENGINE_MAX_STEP_S, Preset, Scene, Stepping};
use crate::units::{self, Dimension};

/// Settings of a run that replace those of its scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Method and tolerances of the analytic model.
    pub preset: Option<Preset>,
    /// Relative tolerance of the analytic model; absolute tolerances are scaled with it.
    pub rtol: Option<f64>,
    /// Fixed step of the engine model.
    pub step_s: Option<f64>,
    /// Largest joint opening per step, for adaptive steps of the engine model.
    pub tolerance_m: Option<f64>,
    /// Length of the run.
    pub duration_s: Option<f64>,
    /// Samples per second of simulated time.
    pub numeric_hz: Option<f64>,
    /// Pictures per second of simulated time.
    pub picture_hz: Option<f64>,
}

impl Overrides {
    /// Applies the settings to a scene.
    ///
    /// # Errors
    /// Returns an error if a setting belongs to the other model, or requests more samples than a run may have.
    pub fn apply(&self, model: Model, scene: &mut Scene) -> Result<(), String> {
        self.reject_unused(model)?;
        if let Some(preset) = self.preset {
            scene.apply_preset(preset);
        }
        let Scene { duration_s: scene_duration_s, log, integrator, engine, .. } = scene;
        if let Some(rtol) = self.rtol {
            *integrator = integrator.with_rtol(rtol);
        }
        if let Some(step_s) = self.step_s {
            engine.stepping = Stepping::Fixed { step_s };
        }
        if let Some(tolerance_m) = self.tolerance_m {
            let max_step_s = match engine.stepping {
                Stepping::Adaptive { max_step_s, .. } => max_step_s,
                Stepping::Fixed { .. } => ENGINE_MAX_STEP_S,
            };
            engine.stepping = Stepping::Adaptive { tolerance_m, max_step_s };
        }
        log.numeric_hz = self.numeric_hz.unwrap_or(log.numeric_hz);
        log.picture_hz = self.picture_hz.unwrap_or(log.picture_hz);
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
    ///
    /// # Errors
    /// Returns an error that names the setting and the model that uses it.
    pub fn reject_unused(&self, model: Model) -> Result<(), String> {
        if self.step_s.is_some() && self.tolerance_m.is_some() {
            return Err("--step sets a fixed step and --tolerance adapts the step: leave one of them out".to_string());
        }
        let (flags, other) = match model {
            Model::Analytic => {
                ([("--step", self.step_s.is_some()), ("--tolerance", self.tolerance_m.is_some())], Model::Engine)
            }
            Model::Engine => ([("--preset", self.preset.is_some()), ("--rtol", self.rtol.is_some())], Model::Analytic),
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

/// Parses a relative tolerance.
///
/// # Errors
/// Returns an error with the allowed values if the text is not one of them.
pub fn rtol(text: &str) -> Result<f64, String> {
    let allowed = text.parse().ok().filter(|rtol| 0.0 < *rtol && *rtol < 1.0);
    allowed.ok_or_else(|| "expected a number between 0 and 1, such as 1e-6".to_string())
}

/// Parses a fixed step of the engine, in s; errors as in [`rtol`].
pub fn step(text: &str) -> Result<f64, String> {
    let expected = "a step must be longer than 0; expected a time such as \"1 us\"";
    quantity(text, Dimension::Time, |step_s| step_s > 0.0, expected)
}

/// Parses a tolerance of the engine, in m; errors as in [`rtol`].
pub fn tolerance(text: &str) -> Result<f64, String> {
    let expected = "a tolerance must be more than 0; expected a length such as \"0.02 um\"";
    quantity(text, Dimension::Length, |tolerance_m| tolerance_m > 0.0, expected)
}

/// Parses a sampling rate, in Hz; errors as in [`rtol`].
pub fn numeric_rate(text: &str) -> Result<f64, String> {
    let expected = "a rate must be more than 0; expected a frequency such as \"10 kHz\"";
    quantity(text, Dimension::Frequency, |rate_hz| rate_hz > 0.0, expected)
}

/// Parses a picture rate, in Hz; errors as in [`rtol`].
pub fn picture_rate(text: &str) -> Result<f64, String> {
    let expected = "a rate must be at least 0; expected a frequency such as \"5 kHz\", or \"0 Hz\" for none";
    quantity(text, Dimension::Frequency, |rate_hz| rate_hz >= 0.0, expected)
}

/// Parses the duration of a run, in s; errors as in [`rtol`].
pub fn duration(text: &str) -> Result<f64, String> {
    let expected = "a run must be longer than 0; expected a time such as \"30 ms\"";
    units::parse_positive(text, Dimension::Time, expected)
}

/// Parses a quantity within a range; `expected` describes the allowed values.
fn quantity(text: &str, dimension: Dimension, is_allowed: fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    match units::parse(text, dimension) {
        Ok(si) if is_allowed(si) => Ok(si),
        Ok(_) => Err(expected.to_string()),
        Err(error) => Err(format!("{error}; {expected}")),
    }
}
