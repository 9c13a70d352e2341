//! Scenes included in the explorer's page: shipped scenes of fingers, grippers and mechanisms.

use std::path::Path;

use serde::Serialize;

use crate::scene::{self, Scene, SceneError};
use crate::shipped::{SHIPPED_SCENES, ShippedScene};

/// Paths under `scenes` of the scenes in the page.
const PRESETS: &[&str] = &[
    "experiment-95.toml",
    "experiment-95-cad.toml",
    "experiment-95-frictionless.toml",
    "experiment-95-bristle.toml",
    "torsional-spring.toml",
    "long-fingers.toml",
    "other-assembly.toml",
    "soft-start.toml",
    "free-swing.toml",
    "gripper/design-95.toml",
    "gripper/light.toml",
    "gripper/heavy.toml",
    "gripper/offset.toml",
    "gripper/offset-left.toml",
    "gripper/different.toml",
    "gripper/seesaw.toml",
    "gripper/table.toml",
    "gripper/fixed.toml",
    "gripper/bought.toml",
    "gripper/lift.toml",
    "real/2f85-lift.toml",
    "real/2f85-pinch.toml",
    "mechanisms/two-pivot.toml",
    "mechanisms/f85-finger.toml",
    "mechanisms/tendon-finger.toml",
    "mechanisms/gripper-box.toml",
    "hard/torque-x10.toml",
    "hard/exponent-1.5.toml",
    "hard/friction-well.toml",
    "hard/limit-rattles.toml",
    "hard/chaos.toml",
    "hard/gripper-thrown.toml",
    "hard/gripper-light.toml",
    "hard/gripper-undamped.toml",
];

/// A scene that does not depend on other files.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Preset {
    /// Path relative to `scenes`.
    pub file: String,
    /// File name without its extension.
    pub name: String,
    /// `finger`, `gripper`, `mechanism` or `hard`.
    pub group: &'static str,
    /// First sentence of the description of the scene; without a description, that of the first comment in the file.
    pub title: String,
    /// Text of the scene, merged with those of the scenes that it extends.
    pub text: String,
}

/// Returns all presets.
pub fn presets() -> Vec<Preset> {
    let find = |file: &&str| SHIPPED_SCENES.iter().find(|scene| scene.file == *file);
    // Tests parse every shipped scene, and find every preset.
    PRESETS.iter().filter_map(find).map(|scene| preset(scene).expect("a shipped scene is valid")).collect()
}

fn preset(shipped: &ShippedScene) -> Result<Preset, SceneError> {
    let scene = scene::parse_layers(&shipped.layers(), &[])?;
    let title = if scene.description.is_empty() { shipped.title() } else { scene.description.clone() };
    Ok(Preset {
        file: shipped.file.to_string(),
        name: Path::new(shipped.file).file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        group: match (shipped.file.starts_with("hard/"), scene.finger_count()) {
            (true, _) => "hard",
            (_, 0) => "mechanism",
            (_, 2) => "gripper",
            _ => "finger",
        },
        title: title.split_inclusive(". ").next().unwrap_or_default().trim().to_string(),
        text: standalone_text(&scene, shipped.text),
    })
}

/// Returns `file_text` if the scene extends no other, otherwise the text merged from all layers.
pub(crate) fn standalone_text(scene: &Scene, file_text: &str) -> String {
    // `source` omits the key `extends`.
    if scene::extended(file_text).is_some() { scene.source.clone() } else { file_text.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_standalone_and_equal_their_files() {
        let presets = presets();
        assert_eq!(presets.len(), PRESETS.len());
        for preset in presets {
            assert!(!preset.title.is_empty(), "{}", preset.file);
            let standalone = scene::parse_any(&preset.text, &preset.file).unwrap_or_else(|error| panic!("{error}"));
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(&preset.file);
            let from_file = scene::load_any(&path).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(scene::show(&standalone), scene::show(&from_file), "{}", preset.file);
        }
    }
}
