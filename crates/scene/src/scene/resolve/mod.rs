//! Resolves a scene as written to a scene as simulated: fills in defaults and checks the physics.
//!
//! Every part is resolved even after another one failed, so that all problems are reported at once.
//!
//! | file | contents |
//! |---|---|
//! | `system` | the system |
//! | `finger`, `start` | the links of a finger, its bodies and its initial configuration |
//! | `drive` | motor, spring and their sizing |
//! | `object`, `disc` | grasped object with its positions, palm and table; discs |
//! | `contact` | contact laws |
//! | `motion` | motion of the palm |
//! | `template` | a scene as the template of many designs |

mod contact;
mod disc;
mod drive;
mod finger;
mod motion;
mod object;
mod start;
mod system;
mod template;

use std::path::Path;

pub use template::template;

use super::check::Checker;
use super::error::Problem;
use super::keywords::SceneKind;
use super::section_input::{SceneInput, SectionInput};
use super::settings::{Bounds, Engine, Integrator, LogRates, SceneSettings, Thresholds};
use super::{Construction, Preset, Response, Scene, Stepping, System};
use crate::units::{Dimension, format};

/// Resolves a scene; its default name is derived from `file_name`.
///
/// # Errors
/// Returns all problems of the scene.
pub fn scene(input: &SceneInput, checker: Checker<'_>, file_name: &str) -> Result<Scene, Vec<Problem>> {
    match resolve(input, &checker, file_name) {
        Some(scene) if checker.is_clean() => Ok(scene),
        _ => Err(checker.into_problems()),
    }
}

fn resolve(input: &SceneInput, checker: &Checker<'_>, file_name: &str) -> Option<Scene> {
    let root = input.top_level(checker);
    let settings: SceneSettings = root.read();
    if settings.extends.is_some() {
        let message = "`extends` refers to another file, but this text is not read from a file";
        let help = "give the scene as a file, or include the contents of the extended scene";
        root.report("extends", message, "relative to no file", help);
    }
    let duration_s = root.is_valid("duration").then_some(*settings.duration);
    let system = system::system(input, &root, &settings);
    let integrator = integrator(&root.subsection("integrator"));
    let engine = engine(&root.subsection("engine"), system.as_ref());
    let bounds = bounds(&root.subsection("validate"), duration_s);
    let thresholds = thresholds(&root.subsection("criteria"), system.as_ref(), duration_s);
    let log = log(&root.subsection("log"), duration_s);
    // Initial positions are checked only if everything else is valid.
    if let (Some(system), true) = (&system, checker.is_clean()) {
        disc::check_initial_positions(&root, system);
    }
    Some(Scene {
        name: settings.name.unwrap_or_else(|| stem(file_name)),
        description: settings.description.unwrap_or_default(),
        source: checker.text.to_string(),
        system: system?,
        duration_s: duration_s?,
        integrator,
        engine,
        bounds,
        thresholds,
        log,
    })
}

/// Name of the file without its extension.
fn stem(file_name: &str) -> String {
    let stem = Path::new(file_name).file_stem().unwrap_or_default().to_string_lossy();
    if stem.trim().is_empty() { "scene".into() } else { stem.into_owned() }
}

/// Resolves the settings of the integrator: preset and relative tolerance determine the defaults of the others.
fn integrator(input: &SectionInput<'_>) -> Integrator {
    let mut base = Integrator::engineering_for(input.kind);
    let Integrator { preset, rtol, .. } = input.read_over(&base);
    if preset == Preset::Reference {
        base = base.with_preset(preset);
    }
    if input.has("rtol") {
        base = base.with_rtol(rtol);
    }
    input.read_over(&base)
}

/// Default duration.
const DURATION_S: f64 = 0.020;

/// For links shorter than this, m, the default tolerance of steps is proportional to their length: the error of angles
/// is the tolerance divided by the length.
const SHORT_LINK_M: f64 = 2.5e-3;

/// Resolves the settings of the engine model. The default friction of rapier's contact is the static friction of the
/// scene's contact law.
fn engine(input: &SectionInput<'_>, system: Option<&System>) -> Engine {
    let mut engine: Engine = input.read();
    if let (Response::Rapier { friction, .. }, Some(mu_static), false) =
        (&mut engine.response, system.and_then(system::mu_static), input.has("friction"))
    {
        *friction = mu_static;
    }
    if let (Stepping::Adaptive { tolerance_m, .. }, Some(system), false) =
        (&mut engine.stepping, system, input.has("tolerance"))
    {
        *tolerance_m *= SHORT_LINK_M.min(system.shortest_link_m()) / SHORT_LINK_M;
    }
    if engine.construction == Construction::Reduced && input.kind != SceneKind::Finger {
        let (reason, label, what) = match input.kind {
            SceneKind::Bodies => ("a scene of discs has no joints", "no joints", "disc"),
            _ => ("joint coordinates are supported for one finger only", "one finger only", "body"),
        };
        let message = format!("`engine.construction` is \"reduced\", but {reason}");
        let help = format!("remove it: every {what} then has its own coordinates");
        input.report("construction", message, label, help);
    }
    engine
}

/// Resolves the tolerances of the validation; only the end of the comparison depends on the duration.
fn bounds(input: &SectionInput<'_>, duration_s: Option<f64>) -> Bounds {
    let defaults = Bounds::defaults_for_run(input.kind, duration_s.unwrap_or(DURATION_S));
    let bounds: Bounds = input.read_over(&defaults);
    let help = "lower it, raise `duration`, or remove it (default: the duration)";
    check_within_duration(input, "until", bounds.until_s, duration_s, help);
    bounds
}

/// Resolves the thresholds of the grasp criteria of a gripper.
fn thresholds(input: &SectionInput<'_>, system: Option<&System>, duration_s: Option<f64>) -> Thresholds {
    let motor_force_n = system.map_or(0.0, System::motor_force_n);
    let defaults = match input.kind {
        SceneKind::Gripper => Thresholds::defaults_for_run(duration_s.unwrap_or(DURATION_S), motor_force_n),
        SceneKind::Finger | SceneKind::Bodies => Thresholds::NONE,
    };
    let thresholds: Thresholds = input.read_over(&defaults);
    for (key, time_s) in [("loss_time", thresholds.loss_time_s), ("held_time", thresholds.held_time_s)] {
        check_within_duration(input, key, time_s, duration_s, "lower it, raise `duration`, or remove it");
    }
    thresholds
}

/// Reports a time that is longer than the run.
fn check_within_duration(input: &SectionInput<'_>, key: &str, time_s: f64, duration_s: Option<f64>, help: &str) {
    let Some(duration_s) = duration_s.filter(|duration_s| time_s > *duration_s) else { return };
    let [time, duration] = [time_s, duration_s].map(|time_s| format(time_s, Dimension::Time));
    let message = format!("`{}` is {time}, but must be at most the duration of {duration}", input.path(key));
    input.report(key, message, "after the end", help);
}

/// Resolves the rates of the log and checks their limits.
fn log(input: &SectionInput<'_>, duration_s: Option<f64>) -> LogRates {
    let rates: LogRates = input.read();
    if let Some(excess) = duration_s.and_then(|duration_s| rates.excess(duration_s)) {
        let key = if excess.pictures { "picture_rate" } else { "numeric_rate" };
        let help = format!("write `{key} = \"{}\"` in [log], or shorten the run", excess.suggested_rate());
        input.report(key, excess.to_string(), "too many", help);
    }
    rates
}
