//! From the scene as written to the scene as simulated: defaults filled in, physics checked.
//!
//! Every part is resolved even after another one failed, so that all problems are reported at once.

mod contact;
mod drive;
mod engine;
mod finger;
mod object;
mod run;
mod start;

use std::path::Path;

use super::check::{Checker, POSITIVE};
use super::defaults;
use super::error::Problem;
use super::raw::RawScene;
use super::words::SceneKind;
use super::{LogRates, Scene};

/// Resolves a scene; `file_name` gives its default name.
pub fn resolve(raw: &RawScene, mut c: Checker<'_>, file_name: &str) -> Result<Scene, Vec<Problem>> {
    let SceneKind::Finger = c.or("kind", &raw.kind, SceneKind::Finger);
    let description = c.get("description", &raw.description).unwrap_or_default();
    let name = c.get("name", &raw.name).unwrap_or_else(|| stem(file_name));
    let duration = match raw.duration.is_given() {
        true => c.number("duration", &raw.duration, POSITIVE),
        false => Some(defaults::DURATION_S),
    };
    let gravity_m_s2 = c.or("gravity", &raw.gravity, defaults::GRAVITY_M_S2);
    let palm = c.or("palm", &raw.palm, true);

    let radius_m = object::radius(&mut c, raw);
    let plan = finger::plan(&mut c, raw, radius_m);
    let finger = finger::finger(&mut c, raw, &plan);
    let object = object::object(&mut c, raw, radius_m, plan.base_m);
    let actuation = drive::motor(&mut c, raw);
    let spring = drive::spring(&mut c, raw);
    let limit = contact::limit(&mut c, &raw.limit);
    let contact = contact::contacts(&mut c, &raw.contact, radius_m);
    let integrator = run::integrator(&mut c, &raw.integrator);
    let engine = engine::engine(&mut c, &raw.engine, contact);
    let bounds = engine::bounds(&mut c, &raw.validate, duration);
    let log = LogRates {
        numeric_hz: c.number_or("log.numeric_rate", &raw.log.numeric_rate, POSITIVE, defaults::NUMERIC_RATE_HZ),
    };
    // The start is judged only if what it stands on is sound.
    let sound = finger.zip(object).zip(limit);
    let initial = start::initial(&mut c, raw, &plan, sound);

    let run = duration.zip(engine).zip(initial);
    match (sound, actuation, spring, contact, run) {
        (
            Some(((finger, object), limit)),
            Some(actuation),
            Some(spring),
            Some(contact),
            Some(((duration_s, engine), initial)),
        ) if c.is_clean() => Ok(Scene {
            name,
            description,
            source: c.text.to_string(),
            finger,
            object,
            palm,
            actuation,
            spring,
            limit,
            contact,
            gravity_m_s2,
            duration_s,
            initial,
            integrator,
            engine,
            bounds,
            log,
        }),
        _ => Err(c.into_problems()),
    }
}

/// The file's name without its extension.
fn stem(file_name: &str) -> String {
    let stem = Path::new(file_name).file_stem().unwrap_or_default().to_string_lossy();
    if stem.trim().is_empty() { "scene".into() } else { stem.into_owned() }
}
