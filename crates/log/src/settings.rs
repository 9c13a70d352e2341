//! Reads the settings recorded in a log: the inverse of [`metadata`](super::metadata()).

use std::collections::BTreeMap;

use super::metadata::LOG_VERSION;
use phalanx_core::scene::schema::{SettingsSection, restore};
use phalanx_core::scene::{Engine, Integrator, LogSettings, Scene};
use phalanx_core::trace::Model;
use phalanx_core::units::MAX_TIME_S;

/// Settings of a run, including those overridden on the command line.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    pub solver: Solver,
    pub duration_s: f64,
    pub log: LogSettings,
    /// File name of the scene and name of the attachment.
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
const INFORMATIONAL_KEYS: [&str; 7] =
    ["phalanx_version", LOG_VERSION.0, "mcap_version", "libm_version", "rapier_version", "kind", "scene"];

impl Settings {
    pub fn model(&self) -> Model {
        match self.solver {
            Solver::Analytic(_) => Model::Analytic,
            Solver::Engine(_) => Model::Engine,
        }
    }

    /// Replaces the settings of a scene by these.
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
    let mut entries = Entries { metadata, used: INFORMATIONAL_KEYS.map(str::to_string).to_vec() };
    let duration = entries.take_text("duration_s")?;
    let duration_s = duration.parse().ok().filter(|duration_s| 0.0 < *duration_s && *duration_s <= MAX_TIME_S);
    let allowed = || format!("a number above 0, and {MAX_TIME_S} at most");
    let duration_s = duration_s.ok_or_else(|| invalid("duration_s".into(), duration, allowed()))?;
    let model = entries.take_text("model")?;
    let solver = match model.as_str() {
        name if name == Model::Analytic.name() => Solver::Analytic(entries.take_section()?),
        name if name == Model::Engine.name() => Solver::Engine(entries.take_section()?),
        _ => {
            let [analytic, engine] = [Model::Analytic, Model::Engine].map(Model::name);
            return Err(invalid("model".into(), model, format!("\"{analytic}\" or \"{engine}\"")));
        }
    };
    let log: LogSettings = entries.take_section()?;
    if let Some(excess) = log.excess(duration_s) {
        let key = if excess.pictures { "log_picture_hz" } else { "log_numeric_hz" };
        return Err(invalid(key.into(), excess.rate_hz.to_string(), format!("lower: {excess}")));
    }
    let scene_file = entries.take_text("scene_file")?;
    entries.ensure_all_used()?;
    Ok(Settings { solver, duration_s, log, scene_file })
}

fn invalid(key: String, value: String, allowed: String) -> SettingsError {
    SettingsError::InvalidValue { key, value, allowed }
}

/// Entries of a metadata record and the keys already used.
struct Entries<'a> {
    metadata: &'a BTreeMap<String, String>,
    used: Vec<String>,
}

impl Entries<'_> {
    fn take_text(&mut self, key: &str) -> Result<String, SettingsError> {
        self.used.push(key.to_string());
        self.metadata.get(key).cloned().ok_or_else(|| SettingsError::MissingEntry(key.to_string()))
    }

    fn take_section<T: SettingsSection>(&mut self) -> Result<T, SettingsError> {
        restore(|key| self.take_text(key), invalid)
    }

    /// Rejects unused entries: they are settings that would be lost.
    fn ensure_all_used(&self) -> Result<(), SettingsError> {
        match self.metadata.iter().find(|(key, _)| !self.used.contains(key)) {
            Some((key, value)) => Err(SettingsError::UnknownSetting { key: key.clone(), value: value.clone() }),
            None => Ok(()),
        }
    }
}
