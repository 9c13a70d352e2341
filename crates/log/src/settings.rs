//! Reads the settings recorded in a log: the inverse of [`metadata`](super::metadata()).

use std::collections::BTreeMap;

use super::metadata::LOG_VERSION;
use phalanx_core::scene::schema::restore;
use phalanx_core::scene::{Engine, Integrator, LogSettings, Scene};
use phalanx_core::trace::Model;
use phalanx_core::units::MAX_TIME_S;

/// Settings of a run, including those overridden on the command line.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    pub solver: Solver,
    pub duration_s: f64,
    pub log: LogSettings,
    /// File name of the scene, which is also the name of the attachment.
    pub scene_file: String,
}

/// Model and its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Solver {
    Analytic(Integrator),
    Engine(Engine),
}

/// Error while reading settings from metadata.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SettingsError {
    #[error("the log does not record `{0}`, which is required to simulate its run again")]
    MissingEntry(String),
    #[error(
        "the log records a setting `{key}` = \"{value}\" that this version of phalanx does not know; use the version that wrote \
         the log (see its metadata)"
    )]
    UnknownSetting { key: String, value: String },
    #[error("the log records `{key}` = \"{value}\", but it must be {allowed}; its metadata has been changed")]
    InvalidValue { key: String, value: String, allowed: String },
}

/// Entries that identify the writer and the scene; they are not settings.
const INFORMATIONAL_KEYS: [&str; 8] =
    ["phalanx_version", LOG_VERSION.0, "mcap_version", "libm_version", "rapier_version", "kind", "fingers", "scene"];

impl Settings {
    pub fn model(&self) -> Model {
        match self.solver {
            Solver::Analytic(_) => Model::Analytic,
            Solver::Engine(_) => Model::Engine,
        }
    }

    /// Replaces the settings of a scene with these settings.
    pub fn apply_to(&self, scene: &mut Scene) {
        let Scene { duration_s, log, integrator, engine, .. } = scene;
        (*duration_s, *log) = (self.duration_s, self.log);
        match self.solver {
            Solver::Analytic(settings) => *integrator = settings,
            Solver::Engine(settings) => *engine = settings,
        }
    }
}

/// Reads the settings from a metadata record. Numbers are recovered exactly.
///
/// # Errors
/// Returns [`SettingsError`] for a missing, unknown or invalid entry.
pub fn settings(metadata: &BTreeMap<String, String>) -> Result<Settings, SettingsError> {
    let mut entries = metadata.clone();
    entries.retain(|key, _| !INFORMATIONAL_KEYS.contains(&key.as_str()));
    let mut take = |key: &str| entries.remove(key).ok_or_else(|| SettingsError::MissingEntry(key.to_string()));
    let duration = take("duration_s")?;
    let duration_s = duration.parse().ok().filter(|duration_s| 0.0 < *duration_s && *duration_s <= MAX_TIME_S);
    let allowed = || format!("a number above 0, and {MAX_TIME_S} at most");
    let duration_s = duration_s.ok_or_else(|| invalid("duration_s".into(), duration, allowed()))?;
    let model = take("model")?;
    let solver = match model.as_str() {
        name if name == Model::Analytic.name() => Solver::Analytic(restore(&mut take, invalid)?),
        name if name == Model::Engine.name() => Solver::Engine(restore(&mut take, invalid)?),
        _ => {
            let [analytic, engine] = [Model::Analytic, Model::Engine].map(Model::name);
            return Err(invalid("model".into(), model, format!("\"{analytic}\" or \"{engine}\"")));
        }
    };
    let log: LogSettings = restore(&mut take, invalid)?;
    if let Some(excess) = log.excess(duration_s) {
        let key = if excess.pictures { "log_picture_hz" } else { "log_numeric_hz" };
        return Err(invalid(key.into(), excess.rate_hz.to_string(), format!("lower: {excess}")));
    }
    let scene_file = take("scene_file")?;
    // An unused entry is a setting that would be lost.
    match entries.pop_first() {
        Some((key, value)) => Err(SettingsError::UnknownSetting { key, value }),
        None => Ok(Settings { solver, duration_s, log, scene_file }),
    }
}

fn invalid(key: String, value: String, allowed: String) -> SettingsError {
    SettingsError::InvalidValue { key, value, allowed }
}
