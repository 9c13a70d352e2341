//! Scenes that the explorer's page brings along: the shipped ones of fingers and grippers.

use std::path::{Component, Path, PathBuf};

use crate::scene::words::SceneKind;
use crate::scene::{self, Layer, Scene, SceneError};

macro_rules! shipped {
    ($($file:literal),* $(,)?) => {
        /// Files under `scenes` and what is in them.
        const SHIPPED: &[(&str, &str)] = &[$(($file, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/", $file)))),*];
    };
}

shipped![
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
    "hard/torque-x10.toml",
    "hard/exponent-1.5.toml",
    "hard/friction-well.toml",
    "hard/limit-rattles.toml",
    "hard/chaos.toml",
    "hard/gripper-thrown.toml",
    "hard/gripper-light.toml",
    "hard/gripper-undamped.toml",
];

/// A scene of its own, whatever it was made from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Preset {
    /// Its place under `scenes`.
    pub file: String,
    /// Its file's name without what it ends with.
    pub name: String,
    /// `finger`, `gripper` or `hard`.
    pub group: &'static str,
    /// What it is for: the first sentence of its description, else of what its file begins with.
    pub title: String,
    /// Its text, with all that it extends.
    pub text: String,
}

/// All of them.
pub fn presets() -> Vec<Preset> {
    // The files are part of the program, and its tests read every one.
    SHIPPED.iter().map(|(file, text)| preset(file, text).expect("a shipped scene is one")).collect()
}

fn preset(file: &str, text: &str) -> Result<Preset, SceneError> {
    let scene = scene::parse_layers(&layers(file, text), &[], scene::parse_any)?;
    let comment = text.lines().next().unwrap_or_default().trim_start_matches('#').trim();
    let about = if scene.description.is_empty() { comment } else { &scene.description };
    Ok(Preset {
        file: file.to_string(),
        name: Path::new(file).file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        group: match (file.starts_with("hard/"), scene.kind()) {
            (true, _) => "hard",
            (_, SceneKind::Gripper) => "gripper",
            _ => "finger",
        },
        title: about.split_inclusive(". ").next().unwrap_or_default().trim().to_string(),
        text: whole(&scene, text),
    })
}

/// The text of a scene: as it was written, or put together of those it extends.
pub fn whole(scene: &Scene, own: &str) -> String {
    // A scene is read from a text without the key that it extends by.
    if scene::extended(own).is_some() { scene.source.clone() } else { own.to_string() }
}

/// A shipped scene after those that it extends.
fn layers(file: &str, text: &str) -> Vec<Layer> {
    let mut found = vec![Layer { file: file.to_string(), text: text.to_string() }];
    while let Some((under, _)) = scene::extended(&found[0].text) {
        let under = beside(&found[0].file, &under);
        let Some((file, text)) = SHIPPED.iter().find(|(file, _)| *file == under) else { break };
        found.insert(0, Layer { file: (*file).to_string(), text: (*text).to_string() });
    }
    found
}

/// The place of a file that is named from another's.
fn beside(file: &str, named: &str) -> String {
    let mut place = PathBuf::from(file);
    place.pop();
    for part in Path::new(named).components() {
        match part {
            Component::ParentDir => {
                place.pop();
            }
            other => place.push(other),
        }
    }
    place.to_string_lossy().replace('\\', "/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_reads_by_itself_as_its_file_does() {
        let all = presets();
        assert_eq!(all.len(), SHIPPED.len());
        for preset in all {
            assert!(!preset.title.is_empty(), "{}", preset.file);
            let alone = scene::parse_any(&preset.text, &preset.file).unwrap_or_else(|error| panic!("{error}"));
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(&preset.file);
            let read = scene::load_any(&path).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(scene::show(&alone), scene::show(&read), "{}", preset.file);
        }
    }

    #[test]
    fn names_are_read_from_the_file_they_stand_in() {
        assert_eq!(beside("hard/a.toml", "../gripper/b.toml"), "gripper/b.toml");
        assert_eq!(beside("gripper/a.toml", "b.toml"), "gripper/b.toml");
        assert_eq!(beside("a.toml", "gripper/b.toml"), "gripper/b.toml");
    }
}
