//! What a log says about its run beside the samples: the metadata record and the name of the scene attachment.

use std::borrow::Cow;
use std::collections::BTreeMap;

use crate::check::{Check, PUSH};
use crate::scene::table::record;
use crate::scene::{
    AnyScene, BodiesScene, Construction, Method, Preset, Response, Scene, Stepping, Words, parse, parse_any, show,
    show_bodies,
};
use crate::trace::Simulated;

/// Name of the metadata record.
pub const METADATA_NAME: &str = "phalanx";

/// Media type of the scene attachment.
pub const ATTACHMENT_MEDIA_TYPE: &str = "application/toml";

/// The name of the engine model.
const ENGINE: &str = "engine";

/// The version of rapier that is pinned in the manifest.
const RAPIER_VERSION: &str = "0.36.1";

/// The kind of a scene in the words of scene files.
fn kind(scene: Simulated<'_>) -> &'static str {
    match scene {
        Simulated::Finger(_) => "finger",
        Simulated::Discs(_) => "bodies",
    }
}

/// The text of a scene file that says what is simulated, but for the settings that the metadata record has: the file as it was
/// written, or, of a scene that was changed since, one made of it.
pub fn scene_text<'a>(scene: impl Into<Simulated<'a>>) -> Cow<'a, str> {
    match scene.into() {
        Simulated::Finger(scene) => text_of_finger(scene),
        Simulated::Discs(scene) => text_of_discs(scene),
    }
}

fn text_of_finger(scene: &Scene) -> Cow<'_, str> {
    let recorded = |read: Scene| Scene {
        name: scene.name.clone(),
        source: scene.source.clone(),
        duration_s: scene.duration_s,
        integrator: scene.integrator,
        engine: scene.engine,
        bounds: scene.bounds,
        log: scene.log,
        ..read
    };
    match parse(&scene.source, "scene.toml").map(recorded) {
        Ok(written) if written == *scene => Cow::Borrowed(&scene.source),
        _ => Cow::Owned(show(scene)),
    }
}

fn text_of_discs(scene: &BodiesScene) -> Cow<'_, str> {
    let recorded = |read: BodiesScene| BodiesScene {
        name: scene.name.clone(),
        source: scene.source.clone(),
        duration_s: scene.duration_s,
        integrator: scene.integrator,
        engine: scene.engine,
        bounds: scene.bounds,
        log: scene.log,
        ..read
    };
    match parse_any(&scene.source, "scene.toml") {
        Ok(AnyScene::Bodies(written)) if recorded((*written).clone()) == *scene => Cow::Borrowed(&scene.source),
        _ => Cow::Owned(show_bodies(scene)),
    }
}

/// Name of the metadata record that says what a check of the run found; it is there if one was made.
pub const CHECK_NAME: &str = "phalanx-check";

/// The entries of that record; errors in rad, of discs in m.
pub fn check_entries(check: &Check) -> BTreeMap<String, String> {
    let entries = [
        ("verdict", check.verdict.name().to_string()),
        ("error", format!("{:?}", check.errors.path)),
        ("bar", format!("{:?}", check.bar)),
        ("push", format!("{PUSH:?}")),
        ("sensitivity", format!("{:?}", check.sensitivity)),
        ("against", check.against.clone()),
        ("reason", check.reason.clone().unwrap_or_default()),
    ];
    entries.into_iter().map(|(key, value)| (key.to_string(), value)).collect()
}

/// Which run a log is of.
#[derive(Clone, Copy, Debug)]
pub struct RunInfo<'a> {
    pub scene: Simulated<'a>,
    /// File name of the scene, without directories: the name of the attachment.
    pub scene_file: &'a str,
    /// `analytic` or `engine`.
    pub model: &'a str,
}

/// The entries of the metadata record: versions, model, and the settings in force for it.
///
/// The attached scene is the file as written; where the command line overrode it, these settings are the ones that
/// held. Numbers are printed in the shortest form that reads back to the same double.
pub fn metadata(run: &RunInfo<'_>) -> BTreeMap<String, String> {
    let (scene, rates) = (run.scene, run.scene.log());
    let about = [
        ("phalanx_version", env!("CARGO_PKG_VERSION").to_string()),
        ("mcap_version", mcap::VERSION.to_string()),
        ("model", run.model.to_string()),
        ("kind", kind(scene).to_string()),
        ("scene", scene.name().to_string()),
        ("scene_file", run.scene_file.to_string()),
        ("duration_s", format!("{:?}", scene.duration_s())),
    ];
    let mut entries: BTreeMap<String, String> =
        about.into_iter().map(|(key, value)| (key.to_string(), value)).collect();
    entries.extend(record("log", rates));
    if run.model == ENGINE {
        entries.extend(record("engine", scene.engine()));
        entries.insert("rapier_version".to_string(), RAPIER_VERSION.to_string());
    } else {
        entries.extend(record("integrator", scene.integrator()));
    }
    entries
}

/// The construction in the words of scene files.
pub fn construction_name(construction: Construction) -> &'static str {
    construction.word()
}

/// What answers to contact, in the words of scene files.
pub fn law_name(response: Response) -> &'static str {
    response.word()
}

/// The stepping in the words of scene files.
pub fn stepping_name(stepping: Stepping) -> &'static str {
    stepping.word()
}

/// The preset in the words of scene files.
pub fn preset_name(preset: Preset) -> &'static str {
    preset.word()
}

/// The method in the words of scene files.
pub fn method_name(method: Method) -> &'static str {
    method.word()
}

/// Name of the metadata record that says what a recovered log is made from.
pub const RECOVERED_NAME: &str = "phalanx_recovered";
