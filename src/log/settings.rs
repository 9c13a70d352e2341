//! The settings that a log records, read back: the inverse of [`metadata`](super::metadata()).

use std::collections::BTreeMap;

use super::metadata::{construction_name, law_name, method_name, preset_name, stepping_name};
use crate::scene::{AnyScene, Construction, Engine, Integrator, LogRates, Method, Preset, Response, Stepping};
use crate::trace::{Model, Numerics};

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
    Missing(&'static str),
    #[error(
        "the log records a setting `{key}` = \"{value}\" that this phalanx does not know; use the phalanx that wrote the log \
         (its metadata says which)"
    )]
    Unknown { key: String, value: String },
    #[error("the log records `{key}` = \"{value}\", but it must be {allowed}; its metadata has been changed")]
    Wrong { key: &'static str, value: String, allowed: String },
}

/// Entries that say what wrote the log, and of what; they set nothing.
const ABOUT: [&str; 5] = ["phalanx_version", "mcap_version", "rapier_version", "kind", "scene"];

impl Settings {
    pub fn model(&self) -> Model {
        match self.solver {
            Solver::Analytic(_) => Model::Analytic,
            Solver::Engine(_) => Model::Engine,
        }
    }

    /// Puts the settings in place of those of a scene.
    pub fn impose(&self, scene: &mut AnyScene) {
        let Numerics { duration_s, log, integrator, engine } = scene.into();
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
    let mut entries = Entries { metadata, used: ABOUT.to_vec() };
    let duration_s = entries.positive("duration_s")?;
    let log = LogRates {
        numeric_hz: entries.positive("log_numeric_hz")?,
        picture_hz: entries.not_negative("log_picture_hz")?,
    };
    let solver = match entries.word("model", [Model::Analytic, Model::Engine], Model::name)? {
        Model::Analytic => Solver::Analytic(integrator(&mut entries)?),
        Model::Engine => Solver::Engine(engine(&mut entries)?),
    };
    let scene_file = entries.text("scene_file")?.to_string();
    entries.nothing_else()?;
    Ok(Settings { solver, duration_s, log, scene_file })
}

fn integrator(entries: &mut Entries<'_>) -> Result<Integrator, SettingsError> {
    Ok(Integrator {
        preset: entries.word("integrator_preset", [Preset::Engineering, Preset::Reference], preset_name)?,
        method: entries.word("integrator_method", [Method::Rodas5p, Method::RadauIIa5], method_name)?,
        rtol: entries.positive("integrator_rtol")?,
        atol_angle_rad: entries.positive("integrator_atol_angle_rad")?,
        atol_rate_rad_s: entries.positive("integrator_atol_rate_rad_s")?,
        max_steps: entries.count("integrator_max_steps")?,
    })
}

fn engine(entries: &mut Entries<'_>) -> Result<Engine, SettingsError> {
    let rigid = Response::Rapier { friction: 0.0, restitution: 0.0 };
    let response = match entries.word("engine_law", [Response::Laws, rigid], law_name)? {
        Response::Laws => Response::Laws,
        Response::Rapier { .. } => Response::Rapier {
            friction: entries.not_negative("engine_friction")?,
            restitution: entries.not_negative("engine_restitution")?,
        },
    };
    let (fixed, adaptive) = (Stepping::Fixed { step_s: 0.0 }, Stepping::Adaptive { tolerance_m: 0.0, max_step_s: 0.0 });
    let stepping = match entries.word("engine_stepping", [fixed, adaptive], stepping_name)? {
        Stepping::Fixed { .. } => Stepping::Fixed { step_s: entries.positive("engine_step_s")? },
        Stepping::Adaptive { .. } => Stepping::Adaptive {
            tolerance_m: entries.positive("engine_tolerance_m")?,
            max_step_s: entries.positive("engine_max_step_s")?,
        },
    };
    let iterations = entries.count("engine_iterations")?;
    Ok(Engine {
        construction: entries.word(
            "engine_construction",
            [Construction::Maximal, Construction::Reduced],
            construction_name,
        )?,
        response,
        stepping,
        iterations: u32::try_from(iterations).map_err(|_| SettingsError::Wrong {
            key: "engine_iterations",
            value: iterations.to_string(),
            allowed: "a whole number of sweeps within reason".to_string(),
        })?,
        max_steps: entries.count("engine_max_steps")?,
    })
}

/// Entries of a record, and which of them have been looked at.
struct Entries<'a> {
    metadata: &'a BTreeMap<String, String>,
    used: Vec<&'static str>,
}

impl<'a> Entries<'a> {
    fn text(&mut self, key: &'static str) -> Result<&'a str, SettingsError> {
        self.used.push(key);
        self.metadata.get(key).map(String::as_str).ok_or(SettingsError::Missing(key))
    }

    fn number(&mut self, key: &'static str, allowed: &str, fits: fn(f64) -> bool) -> Result<f64, SettingsError> {
        let text = self.text(key)?;
        let wrong = || SettingsError::Wrong { key, value: text.to_string(), allowed: allowed.to_string() };
        text.parse().ok().filter(|&value: &f64| value.is_finite() && fits(value)).ok_or_else(wrong)
    }

    fn positive(&mut self, key: &'static str) -> Result<f64, SettingsError> {
        self.number(key, "a number above 0", |value| value > 0.0)
    }

    fn not_negative(&mut self, key: &'static str) -> Result<f64, SettingsError> {
        self.number(key, "a number from 0", |value| value >= 0.0)
    }

    fn count(&mut self, key: &'static str) -> Result<u64, SettingsError> {
        let text = self.text(key)?;
        let allowed = "a whole number from 1".to_string();
        let wrong = || SettingsError::Wrong { key, value: text.to_string(), allowed };
        text.parse().ok().filter(|&count: &u64| count >= 1).ok_or_else(wrong)
    }

    /// A word, by the function that writes it.
    fn word<T: Copy>(
        &mut self,
        key: &'static str,
        all: [T; 2],
        name: fn(T) -> &'static str,
    ) -> Result<T, SettingsError> {
        let text = self.text(key)?;
        let wrong = || SettingsError::Wrong {
            key,
            value: text.to_string(),
            allowed: all.map(|value| format!("\"{}\"", name(value))).join(" or "),
        };
        all.into_iter().find(|&value| name(value) == text).ok_or_else(wrong)
    }

    /// An entry that nobody has asked for is a setting that would be lost.
    fn nothing_else(&self) -> Result<(), SettingsError> {
        match self.metadata.iter().find(|(key, _)| !self.used.contains(&key.as_str())) {
            Some((key, value)) => Err(SettingsError::Unknown { key: key.clone(), value: value.clone() }),
            None => Ok(()),
        }
    }
}
