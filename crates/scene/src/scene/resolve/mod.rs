//! From the scene as written to the scene as simulated: defaults filled in, physics checked.
//!
//! Every part is resolved even after another one failed, so that all problems are reported at once.

mod bodies;
mod contact;
mod disc;
mod drive;
mod finger;
mod gripper;
mod motion;
mod object;
mod run;
mod sizing;
mod start;
mod template;

pub use bodies::bodies;
pub use gripper::gripper;
pub use template::template;

use std::path::Path;

use super::check::{Checker, POSITIVE};
use super::error::Problem;
use super::kinds::Time;
use super::raw::RawScene;
use super::table::finger::Object;
use super::table::keys::Keys;
use super::table::top::{FingerKeys, Heading};
use super::table::{Table, read};
use super::{Disc, DrivenFinger, HalfPlane, Integrator, Motor, Scene, System};

/// Resolves the scene of a finger; `file_name` gives its default name.
pub fn finger(raw: &RawScene, mut c: Checker<'_>, file_name: &str) -> Result<Scene, Vec<Problem>> {
    let keys = read(&mut c, "", &raw.keys, FingerKeys::usual());
    let (name, duration) = heading(&mut c, &raw.keys, &keys.heading, file_name);
    let gravity_m_s2 = keys.heading.gravity_m_s2;

    let said = read(&mut c, "object", &raw.object, Object::usual());
    let radius_m = said.radius_m;
    let plan = finger::plan(&mut c, raw, &keys, radius_m);
    let finger = finger::finger(&mut c, raw, &plan);
    let object = object::object(&mut c, raw, said, plan.base_m);
    let sized = sizing::sizing(&mut c, raw, &keys, finger.as_ref().zip(object.as_ref()), gravity_m_s2);
    let actuation = drive::motor(&mut c, &raw.motor, sized);
    let spring = drive::spring(&mut c, &raw.spring, sized);
    let limit = contact::limit(&mut c, &raw.limit);
    let contact = contact::contacts(&mut c, &raw.contact, radius_m);
    let integrator = read(&mut c, "integrator", &raw.integrator, Integrator::usual());
    let mu_static = contact.map(|contacts| contacts.proximal.friction.map_or(0.0, |law| law.mu_static));
    let engine = run::engine(&mut c, &raw.engine, mu_static);
    let bounds = run::bounds(&mut c, &raw.validate, duration);
    let log = run::log(&mut c, &raw.log, duration);
    // The start is judged only if what it stands on is sound.
    let sound = finger.zip(object).map(|sound| (sound, limit));
    let initial = start::initial(&mut c, raw, &plan, sound, &[]);

    let run = duration.zip(initial);
    match (sound, actuation, spring, contact, run) {
        (
            Some(((finger, object), limit)),
            Some(actuation),
            Some(spring),
            Some(contact),
            Some((duration_s, initial)),
        ) if c.is_clean() => Ok(Scene {
            name,
            description: keys.heading.description,
            source: c.text.to_string(),
            system: System {
                fingers: vec![DrivenFinger {
                    linkage: finger,
                    motor: Motor::of(actuation),
                    spring,
                    limit,
                    contact,
                    initial,
                }],
                palm_width_m: 0.0,
                differential: None,
                discs: object.map(Disc::object).into_iter().collect(),
                between_discs: None,
                // Nothing that moves can reach it.
                palm: keys.palm.then_some(HalfPlane { level_m: 0.0, contact: None }),
                table: None,
                palm_motion: None,
                gravity_m_s2,
            },
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
fn heading<T>(c: &mut Checker<'_>, raw: &Keys<T>, said: &Heading, file_name: &str) -> (String, Option<f64>) {
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
