//! The settings that a log records, read back: the inverse of [`metadata`](super::metadata()).

use std::collections::BTreeMap;

use phalanx_core::scene::table::{Table, recall};
use phalanx_core::scene::{Engine, Integrator, LogRates, Scene};
use phalanx_core::trace::Model;
use phalanx_core::units::LONGEST_S;

/// Everything that a run was made with beside its scene file: what the command line had overridden is in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    pub solver: Solver,
    pub duration_s: f64,
    pub log: LogRates,
    /// File name of the scene, which is the name of the attachment.
    pub scene_file: String,
}

/// The model and its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Solver {
    Analytic(Integrator),
    Engine(Engine),
}

/// Why settings cannot be read back.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SettingsError {
    #[error("the log does not record `{0}`, without which its run cannot be simulated again")]
    Missing(String),
    #[error(
        "the log records a setting `{key}` = \"{value}\" that this phalanx does not know; use the phalanx that wrote the log \
         (its metadata says which)"
    )]
    Unknown { key: String, value: String },
    #[error("the log records `{key}` = \"{value}\", but it must be {allowed}; its metadata has been changed")]
    Wrong { key: String, value: String, allowed: String },
}

/// Entries that say what wrote the log, and of what; they set nothing.
const ABOUT: [&str; 6] = ["phalanx_version", "mcap_version", "libm_version", "rapier_version", "kind", "scene"];

impl Settings {
    pub fn model(&self) -> Model {
        match self.solver {
            Solver::Analytic(_) => Model::Analytic,
            Solver::Engine(_) => Model::Engine,
        }
    }

    /// Puts the settings in place of those of a scene.
    pub fn impose(&self, scene: &mut Scene) {
        let Scene { duration_s, log, integrator, engine, .. } = scene;
        (*duration_s, *log) = (self.duration_s, self.log);
        match self.solver {
            Solver::Analytic(settings) => *integrator = settings,
            Solver::Engine(settings) => *engine = settings,
        }
    }
}

/// Reads the settings of a metadata record. Numbers come back as the same doubles.
///
/// # Errors
/// [`SettingsError`] for an entry that is missing, not known, or not one that a run can have.
pub fn settings(metadata: &BTreeMap<String, String>) -> Result<Settings, SettingsError> {
    let mut entries = Entries { metadata, used: ABOUT.map(str::to_string).to_vec() };
    let duration = entries.text("duration_s")?;
    let duration_s = duration.parse().ok().filter(|duration_s| 0.0 < *duration_s && *duration_s <= LONGEST_S);
    let allowed = || format!("a number above 0, and {LONGEST_S} at most");
    let duration_s = duration_s.ok_or_else(|| wrong("duration_s".into(), duration, allowed()))?;
    let model = entries.text("model")?;
    let solver = match model.as_str() {
        name if name == Model::Analytic.name() => Solver::Analytic(entries.section("integrator")?),
        name if name == Model::Engine.name() => Solver::Engine(entries.section("engine")?),
        _ => {
            let [analytic, engine] = [Model::Analytic, Model::Engine].map(Model::name);
            return Err(wrong("model".into(), model, format!("\"{analytic}\" or \"{engine}\"")));
        }
    };
    let log: LogRates = entries.section("log")?;
    if let Some(excess) = log.excess(duration_s) {
        let key = if excess.pictures { "log_picture_hz" } else { "log_numeric_hz" };
        return Err(wrong(key.into(), excess.rate_hz.to_string(), format!("lower: {excess}")));
    }
    let scene_file = entries.text("scene_file")?;
    entries.nothing_else()?;
    Ok(Settings { solver, duration_s, log, scene_file })
}

fn wrong(key: String, value: String, allowed: String) -> SettingsError {
    SettingsError::Wrong { key, value, allowed }
}

/// Entries of a record, and which of them have been looked at.
struct Entries<'a> {
    metadata: &'a BTreeMap<String, String>,
    used: Vec<String>,
}

impl Entries<'_> {
    fn text(&mut self, key: &str) -> Result<String, SettingsError> {
        self.used.push(key.to_string());
        self.metadata.get(key).cloned().ok_or_else(|| SettingsError::Missing(key.to_string()))
    }

    fn section<T: Table>(&mut self, path: &str) -> Result<T, SettingsError> {
        recall(path, |key| self.text(key), wrong)
    }

    /// An entry that nobody has asked for is a setting that would be lost.
    fn nothing_else(&self) -> Result<(), SettingsError> {
        match self.metadata.iter().find(|(key, _)| !self.used.contains(key)) {
            Some((key, value)) => Err(SettingsError::Unknown { key: key.clone(), value: value.clone() }),
            None => Ok(()),
        }
    }
}
