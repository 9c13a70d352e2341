//! What a log says about its run beside the samples: the metadata record and the name of the scene attachment.

use std::borrow::Cow;
use std::collections::BTreeMap;

use phalanx_core::check::{Check, PUSH};
use phalanx_core::scene::table::record;
use phalanx_core::scene::{Construction, Method, Preset, Response, Scene, Stepping, Words, parse_any, show};

/// Name of the metadata record.
pub const METADATA_NAME: &str = "phalanx";

/// Media type of the scene attachment.
pub const ATTACHMENT_MEDIA_TYPE: &str = "application/toml";

/// The name of the engine model.
const ENGINE: &str = "engine";

/// The version of rapier that is pinned in the manifest.
const RAPIER_VERSION: &str = "0.36.1";

/// That of the elementary functions, whose last digits are those of every run.
const LIBM_VERSION: &str = "0.2.16";

/// The text of a scene file that says what is simulated, but for the settings that the metadata record has: the file as it was
/// written, or, of a scene that was changed since, one made of it.
pub fn scene_text(scene: &Scene) -> Cow<'_, str> {
    match parse_any(&scene.source, "scene.toml") {
        Ok(written) if recorded(&written, scene) == *scene => Cow::Borrowed(&scene.source),
        _ => Cow::Owned(show(scene)),
    }
}

/// What is simulated of a scene as it was written, with everything of another one that the metadata record has.
fn recorded(written: &Scene, of: &Scene) -> Scene {
    Scene { description: written.description.clone(), system: written.system.clone(), ..of.clone() }
}

/// Name of the metadata record that says what a check of the run found; it is there if one was made.
pub const CHECK_NAME: &str = "phalanx-check";

/// The entries of that record; errors in rad, of discs in m.
pub fn check_entries(check: &Check) -> BTreeMap<String, String> {
    let entries = [
        ("verdict", check.verdict.name().to_string()),
        ("error", format!("{:?}", check.errors.path)),
        ("bar", format!("{:?}", check.bar)),
        ("bar_of", check.bar_of.clone()),
        ("energy_error", format!("{:?}", check.errors.energy)),
        ("energy_bar", format!("{:?}", check.energy_bar)),
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
    pub scene: &'a Scene,
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
    let (scene, rates) = (run.scene, &run.scene.log);
    let about = [
        ("phalanx_version", env!("CARGO_PKG_VERSION").to_string()),
        ("mcap_version", mcap::VERSION.to_string()),
        ("libm_version", LIBM_VERSION.to_string()),
        ("model", run.model.to_string()),
        ("kind", scene.kind().word().to_string()),
        ("scene", scene.name.clone()),
        ("scene_file", run.scene_file.to_string()),
        ("duration_s", format!("{:?}", scene.duration_s)),
    ];
    let mut entries: BTreeMap<String, String> =
        about.into_iter().map(|(key, value)| (key.to_string(), value)).collect();
    entries.extend(record("log", rates));
    if run.model == ENGINE {
        entries.extend(record("engine", &scene.engine));
        entries.insert("rapier_version".to_string(), RAPIER_VERSION.to_string());
    } else {
        entries.extend(record("integrator", &scene.integrator));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_those_of_the_manifest() {
        let manifest = concat!(include_str!("../../core/Cargo.toml"), include_str!("../../mechanics/Cargo.toml"));
        for (name, version) in [("rapier2d-f64 = { version = ", RAPIER_VERSION), ("libm = ", LIBM_VERSION)] {
            assert!(manifest.contains(&format!("{name}\"={version}\"")), "{name}{version}");
        }
    }
}
