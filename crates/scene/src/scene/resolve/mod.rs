//! Resolves a scene as written to a scene as simulated: fills in defaults and checks the physics.
//!
//! Every part is resolved even after another one failed, so that all problems are reported at once.
//!
//! | file | contents |
//! |---|---|
//! | `system` | the system |
//! | `finger`, `start`, `driven_finger` | the links of a finger, its initial configuration, the finger with its drive |
//! | `drive`, `sizing`, `differential` | motor and spring, given or sized; one motor for two fingers |
//! | `object`, `disc`, `plane` | grasped object, discs, palm, ground and table |
//! | `object_range`, `target` | positions of the object within the positioning error, in the frame of each finger |
//! | `contact` | contact laws |
//! | `motion` | motion of the palm |
//! | `run` | settings of the run |
//! | `template` | a scene as the template of many designs |

mod contact;
mod differential;
mod disc;
mod drive;
mod driven_finger;
mod finger;
mod motion;
mod object;
mod object_range;
mod plane;
mod run;
mod sizing;
mod start;
mod system;
mod target;
mod template;

pub use template::template;

use std::path::Path;

use super::Scene;
use super::check::{Checker, POSITIVE};
use super::error::Problem;
use super::scene_input::SceneInput;
use super::table::input::SectionInput;
use super::table::scene::SceneSettings;
use super::table::{SettingsSection, read};
use super::value_kinds::Time;

/// Resolves a scene; its default name is derived from `file_name`.
///
/// # Errors
/// Returns all problems of the scene.
pub fn scene(input: &SceneInput, mut checker: Checker<'_>, file_name: &str) -> Result<Scene, Vec<Problem>> {
    let scene_settings = read(&mut checker, "", &input.top_level(), SceneSettings::defaults_for(input.kind));
    let (name, duration_s) = heading(&mut checker, &input.top_level(), &scene_settings, file_name);
    let system = system::system(&mut checker, input, &scene_settings);
    let run::Run { integrator, engine, bounds, thresholds, log } =
        run::run(&mut checker, &input.top_level(), system.as_ref(), duration_s);
    // Initial positions are checked only if everything else is valid.
    if let (Some(system), true) = (&system, checker.is_clean()) {
        disc::check_initial_positions(&mut checker, input, system);
    }
    match (system, duration_s) {
        (Some(system), Some(duration_s)) if checker.is_clean() => Ok(Scene {
            name,
            description: scene_settings.description,
            source: checker.text.to_string(),
            system,
            duration_s,
            integrator,
            engine,
            bounds,
            thresholds,
            log,
        }),
        _ => Err(checker.into_problems()),
    }
}

/// Returns name and duration; no duration if it is invalid.
fn heading(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    settings: &SceneSettings,
    file_name: &str,
) -> (String, Option<f64>) {
    if !settings.extends.is_empty() {
        let message = "`extends` refers to another file, but this text is not read from a file".to_string();
        checker.push(
            input.span("extends"),
            message,
            "relative to no file",
            "give the scene as a file, or include the contents of the extended scene",
        );
    }
    let name = if settings.name.is_empty() { stem(file_name) } else { settings.name.clone() };
    // An invalid duration has been reported.
    let is_valid = !input.has("duration") || input.value::<Time>("duration").is_some_and(POSITIVE.allowed);
    (name, is_valid.then_some(settings.duration_s))
}

/// Name of the file without its extension.
fn stem(file_name: &str) -> String {
    let stem = Path::new(file_name).file_stem().unwrap_or_default().to_string_lossy();
    if stem.trim().is_empty() { "scene".into() } else { stem.into_owned() }
}
