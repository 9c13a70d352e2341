//! Metadata records of a log and its scene attachment.

use std::borrow::Cow;
use std::collections::BTreeMap;

use phalanx_core::check::{Check, PERTURBATION};
use phalanx_core::scene::schema::record;
use phalanx_core::scene::{Keyword, Scene, parse_any, show};

/// Name of the metadata record.
pub(crate) const METADATA_NAME: &str = "phalanx";

/// Name of the metadata record with the kinds and names of all subjects, in the order of the samples, and its only key. With
/// it a reader knows which topics the log must contain, without the scene.
pub(crate) const SUBJECTS_RECORD: (&str, &str) = ("phalanx-subjects", "subjects");

/// Version of topics and messages. Logs of phalanx 0.1 do not have it.
pub(crate) const LOG_VERSION: (&str, &str) = ("log_version", "3");

/// Media type of the scene attachment.
pub(crate) const ATTACHMENT_MEDIA_TYPE: &str = "application/toml";

/// Name of the engine model.
const ENGINE_MODEL: &str = "engine";

/// Version of rapier pinned in the manifest.
const RAPIER_VERSION: &str = "0.36.1";

/// Pinned version of the elementary functions, which determine the last digits of every run.
const LIBM_VERSION: &str = "0.2.16";

/// Returns the scene text to attach: the scene file as written. A text is generated instead if the scene was changed in
/// more than the settings that the metadata record contains.
pub fn scene_text(scene: &Scene) -> Cow<'_, str> {
    match parse_any(&scene.source, "scene.toml") {
        Ok(as_written) if with_settings_of(&as_written, scene) == *scene => Cow::Borrowed(&scene.source),
        _ => Cow::Owned(show(scene)),
    }
}

/// Returns the description and system of `as_written` with all settings of `settings_source`.
fn with_settings_of(as_written: &Scene, settings_source: &Scene) -> Scene {
    let Scene { description, hand, mechanism, .. } = as_written.clone();
    Scene { description, hand, mechanism, ..settings_source.clone() }
}

/// Name of the metadata record with the result of an accuracy check; absent if the run was not checked.
pub(crate) const CHECK_NAME: &str = "phalanx-check";

/// Returns the entries of the check record. Errors are in rad, for discs in m.
pub(crate) fn check_entries(check: &Check) -> BTreeMap<String, String> {
    let entries = [
        ("verdict", check.verdict.name().to_string()),
        ("error", format!("{:?}", check.errors.path)),
        ("bar", format!("{:?}", check.max_path_error)),
        ("bar_of", check.max_path_error_basis.clone()),
        ("energy_error", format!("{:?}", check.errors.energy)),
        ("energy_bar", format!("{:?}", check.max_energy_error)),
        ("push", format!("{PERTURBATION:?}")),
        ("sensitivity", format!("{:?}", check.sensitivity)),
        ("against", check.reference.clone()),
        ("reason", check.reason.clone().unwrap_or_default()),
    ];
    entries.into_iter().map(|(key, value)| (key.to_string(), value)).collect()
}

/// Description of a logged run.
#[derive(Clone, Copy, Debug)]
pub struct RunInfo<'a> {
    pub scene: &'a Scene,
    /// File name of the scene, without directories: the name of the attachment.
    pub scene_file: &'a str,
    /// `analytic` or `engine`.
    pub model: &'a str,
}

/// Returns the entries of the metadata record: versions, model and its settings.
///
/// The attached scene is the file as written; these settings include overrides from the command line. Numbers are
/// printed in the shortest form that reads back to the same double.
pub fn metadata(run: &RunInfo<'_>) -> BTreeMap<String, String> {
    let (scene, rates) = (run.scene, &run.scene.log);
    let general = [
        ("phalanx_version", env!("CARGO_PKG_VERSION").to_string()),
        (LOG_VERSION.0, LOG_VERSION.1.to_string()),
        ("mcap_version", mcap::VERSION.to_string()),
        ("libm_version", LIBM_VERSION.to_string()),
        ("model", run.model.to_string()),
        ("kind", scene.kind.keyword().to_string()),
        ("fingers", scene.finger_count().to_string()),
        ("scene", scene.name.clone()),
        ("scene_file", run.scene_file.to_string()),
        ("duration_s", format!("{:?}", scene.duration_s)),
    ];
    let mut entries: BTreeMap<String, String> =
        general.into_iter().map(|(key, value)| (key.to_string(), value)).collect();
    entries.extend(record(rates));
    if run.model == ENGINE_MODEL {
        entries.extend(record(&scene.engine));
        entries.insert("rapier_version".to_string(), RAPIER_VERSION.to_string());
    } else {
        entries.extend(record(&scene.integrator));
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_match_the_manifest() {
        let manifest = concat!(include_str!("../../core/Cargo.toml"), include_str!("../../mechanics/Cargo.toml"));
        for (name, version) in [("rapier2d-f64 = { version = ", RAPIER_VERSION), ("libm = ", LIBM_VERSION)] {
            assert!(manifest.contains(&format!("{name}\"={version}\"")), "{name}{version}");
        }
    }
}
