//! From the scene as written to the scene as simulated: defaults filled in, physics checked.
//!
//! Every part is resolved even after another one failed, so that all problems are reported at once.
//!
//! | file | job |
//! |---|---|
//! | `system` | all of the system, of its parts |
//! | `finger`, `start`, `driven` | the links of a finger, where it starts, all of it |
//! | `drive`, `sizing`, `differential` | motor and spring, as given or sized; one motor for two fingers |
//! | `object`, `disc`, `plane` | what fingers grasp, discs, palm, ground and table |
//! | `room`, `seen` | where the object may be, as each finger sees it |
//! | `contact` | the laws of contacts |
//! | `motion` | how the palm moves |
//! | `run` | how the scene is run |
//! | `template` | a scene as the template of many designs |

mod contact;
mod differential;
mod disc;
mod drive;
mod driven;
mod finger;
mod motion;
mod object;
mod plane;
mod room;
mod run;
mod seen;
mod sizing;
mod start;
mod system;
mod template;

pub use template::template;

use std::path::Path;

use super::Scene;
use super::check::{Checker, POSITIVE};
use super::error::Problem;
use super::kinds::Time;
use super::raw::Raw;
use super::table::keys::Keys;
use super::table::top::Top;
use super::table::{Table, read};

/// Resolves a scene; `file_name` gives its default name.
pub fn scene(raw: &Raw, mut c: Checker<'_>, file_name: &str) -> Result<Scene, Vec<Problem>> {
    let top = read(&mut c, "", &raw.whole(), Top::usual_in(raw.kind));
    let (name, duration_s) = heading(&mut c, &raw.whole(), &top, file_name);
    let system = system::system(&mut c, raw, &top);
    let mu_static = system.as_ref().and_then(system::mu_static);
    let run::Run { integrator, mut engine, bounds, log } = run::run(&mut c, &raw.whole(), mu_static, duration_s);
    if let Some(system) = &system {
        run::suit_links(&mut engine, &raw.whole().inner("engine"), system);
    }
    // Starts are judged only if everything they stand on is sound.
    if let (Some(system), true) = (&system, c.is_clean()) {
        disc::judge_starts(&mut c, raw, system);
    }
    match (system, duration_s) {
        (Some(system), Some(duration_s)) if c.is_clean() => Ok(Scene {
            name,
            description: top.description,
            source: c.text.to_string(),
            system,
            duration_s,
            integrator,
            engine,
            bounds,
            log,
        }),
        _ => Err(c.into_problems()),
    }
}

/// What every scene begins with: its name, and how long it is unless that is wrong.
fn heading(c: &mut Checker<'_>, raw: &Keys<'_>, said: &Top, file_name: &str) -> (String, Option<f64>) {
    if !said.extends.is_empty() {
        let message = "`extends` names another file, but this text is read by itself".to_string();
        c.push(
            raw.span("extends"),
            message,
            "no file to look from",
            "give the scene as a file, or put what it extends into it",
        );
    }
    let name = if said.name.is_empty() { stem(file_name) } else { said.name.clone() };
    // A wrong one is noted already.
    let is_sound = !raw.has("duration") || raw.value::<Time>("duration").is_some_and(POSITIVE.allowed);
    (name, is_sound.then_some(said.duration_s))
}

/// The file's name without its extension.
fn stem(file_name: &str) -> String {
    let stem = Path::new(file_name).file_stem().unwrap_or_default().to_string_lossy();
    if stem.trim().is_empty() { "scene".into() } else { stem.into_owned() }
}
