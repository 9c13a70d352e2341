//! The shipped scenes, as parts of the program: `phalanx new` writes them, the explorer's page contains some.

use std::path::Path;

use crate::scene::{self, Layer, SceneError, closest_match};

/// A shipped scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShippedScene {
    /// Path relative to `scenes`, such as `real/2f85-lift.toml`.
    pub file: &'static str,
    /// Contents of the file.
    pub text: &'static str,
}

macro_rules! shipped_scenes {
    ($($file:literal),* $(,)?) => {
        /// All shipped scenes, ordered by their directories.
        pub const SHIPPED_SCENES: &[ShippedScene] = &[$(ShippedScene {
            file: $file,
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/", $file)),
        }),*];
    };
}

shipped_scenes! {
    "experiment-95-bristle.toml", "experiment-95-cad.toml", "experiment-95-frictionless.toml", "experiment-95.toml",
    "free-swing.toml", "long-fingers.toml", "other-assembly.toml", "soft-start.toml", "torsional-spring.toml",
    "gripper/bought.toml", "gripper/carried.toml", "gripper/cycle-dropped.toml", "gripper/cycle-fast.toml",
    "gripper/cycle-heavy.toml", "gripper/cycle-light.toml", "gripper/cycle-shaken.toml", "gripper/cycle.toml",
    "gripper/design-95.toml", "gripper/different.toml", "gripper/fixed.toml", "gripper/heavy.toml",
    "gripper/hold.toml", "gripper/lift.toml", "gripper/light.toml", "gripper/offset-left.toml", "gripper/offset.toml",
    "gripper/seesaw.toml", "gripper/table.toml", "hard/a-turn-apart.toml", "hard/both-at-once.toml",
    "hard/chaos.toml", "hard/damper-none.toml", "hard/damper-nowhere.toml", "hard/damper-stiff.toml",
    "hard/end-cap.toml", "hard/exponent-1.5.toml", "hard/exponent-1.toml", "hard/exponent-3.toml",
    "hard/friction-2.toml", "hard/friction-none.toml", "hard/friction-well.toml", "hard/gravity-100g.toml",
    "hard/gravity-none.toml", "hard/grazing-held.toml", "hard/grazing.toml", "hard/gripper-both-tips.toml",
    "hard/gripper-heavy.toml", "hard/gripper-light.toml", "hard/gripper-no-friction.toml",
    "hard/gripper-one-finger-first.toml", "hard/gripper-out-of-reach.toml", "hard/gripper-squeezed.toml",
    "hard/gripper-thrown.toml", "hard/gripper-undamped.toml", "hard/hold-10s.toml", "hard/large.toml",
    "hard/limit-hammered.toml", "hard/limit-lets-go.toml", "hard/limit-pulls.toml", "hard/limit-rattles.toml",
    "hard/limit-rings-on.toml", "hard/limit-rings.toml", "hard/limit-touches.toml", "hard/limit-trembles.toml",
    "hard/mass-crank-heavy.toml", "hard/mass-links-light.toml", "hard/mass-tip-heavy.toml",
    "hard/mass-tip-light.toml", "hard/missed-reload.toml", "hard/misses.toml", "hard/near-singular-start.toml",
    "hard/near-singular.toml", "hard/other-assembly.toml", "hard/slip-reversal.toml", "hard/spring-off.toml",
    "hard/start-in-contact.toml", "hard/start-in-penetration.toml", "hard/step-1ms.toml", "hard/sticks-at-once.toml",
    "hard/stiffness-1e12.toml", "hard/stiffness-1e6.toml", "hard/through-the-fold.toml", "hard/tiny.toml",
    "hard/torque-reversal.toml", "hard/torque-steps.toml", "hard/torque-x0.1.toml", "hard/torque-x10.toml",
    "hard/v-static-1e-2.toml", "hard/v-static-1e-3.toml", "hard/v-static-1e-4.toml", "laws/bristle-holds.toml",
    "laws/bristle-jams.toml", "laws/bristle-rolls.toml", "laws/bristle-slides.toml", "laws/bristle-stick-slip.toml",
    "laws/damper.toml", "laws/friction.toml", "laws/impact-damper.toml", "laws/impact-elastic.toml",
    "laws/impact.toml", "laws/radii.toml", "laws/rolling.toml", "laws/spring.toml", "laws/step-size.toml",
    "laws/two-free.toml", "mechanisms/andrews.toml", "mechanisms/bought-drive.toml", "mechanisms/f85-finger.toml", "mechanisms/four-bar.toml",
    "mechanisms/gripper-box.toml", "mechanisms/jaws.toml", "mechanisms/slider-crank.toml",
    "mechanisms/tendon-finger.toml", "mechanisms/tendon-hand.toml", "mechanisms/two-pivot.toml", "real/2f85-encompass.toml", "real/2f85-hold.toml",
    "real/2f85-lift.toml", "real/2f85-pinch.toml", "real/barrett-grasp.toml", "real/dp-flex-finger.toml",
    "real/franka-lift.toml", "real/robotiq-3f-finger.toml", "real/t42-friction.toml", "real/t42-grasp.toml",
}

impl ShippedScene {
    /// Name of the scene: its path without the extension.
    pub fn name(&self) -> &'static str {
        self.file.trim_end_matches(".toml")
    }

    /// First sentence of the comment at the top of the file. If the comment begins with the answer of the run, it is
    /// the sentence after that.
    pub fn title(&self) -> String {
        let comment = self.text.lines().take_while(|line| line.starts_with('#'));
        let lines: Vec<&str> = comment.map(|line| line.trim_start_matches('#').trim()).collect();
        let paragraphs = lines.split(|line| line.is_empty()).map(|lines| lines.join(" "));
        // An answer has no full stop.
        let text = paragraphs.into_iter().find(|text| text.ends_with('.') || text.contains(". ")).unwrap_or_default();
        text.split_inclusive(". ").next().unwrap_or_default().trim().to_string()
    }

    /// Returns the scene as a single file that contains the values of the scenes it extends.
    ///
    /// # Errors
    /// Returns an error if the scene is invalid. A test ensures that it is not.
    pub fn standalone_text(&self) -> Result<String, SceneError> {
        if scene::extended(self.text).is_none() {
            return Ok(self.text.to_string());
        }
        let merged = scene::parse_layers(&self.layers(), &[])?.source;
        let comment: String =
            self.text.lines().take_while(|line| line.starts_with('#')).map(|line| format!("{line}\n")).collect();
        Ok(if merged.starts_with('#') { merged } else { format!("{comment}\n{merged}") })
    }

    /// Returns the scenes that this scene extends, then this scene.
    pub fn layers(&self) -> Vec<Layer> {
        let layer = |of: &ShippedScene| Layer { file: of.file.to_string(), text: of.text.to_string() };
        let (mut of, mut layers) = (*self, vec![layer(self)]);
        while let Some((base, _)) = scene::extended(of.text) {
            let path = Path::new(of.file).parent().unwrap_or(Path::new("")).join(base);
            let Some(found) = SHIPPED_SCENES.iter().find(|other| is_path(&path, other.file)) else { break };
            of = *found;
            layers.insert(0, layer(found));
        }
        layers
    }
}

/// Whether a path with parts such as `..` is that of a shipped scene.
fn is_path(path: &Path, file: &str) -> bool {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.iter().filter_map(|part| part.to_str()) {
        match part {
            ".." => _ = parts.pop(),
            "." => {}
            part => parts.push(part),
        }
    }
    parts.join("/") == file
}

/// Returns the shipped scene with a name. The name is the path with or without its extension, or the file name if only
/// one scene has it.
///
/// # Errors
/// Returns a sentence with a similar name, or with all scenes to which an ambiguous name applies.
pub fn shipped_scene(name: &str) -> Result<&'static ShippedScene, String> {
    let name = name.trim_start_matches("scenes/").trim_end_matches(".toml");
    let is_file = |scene: &&ShippedScene| scene.name().rsplit('/').next() == Some(name);
    if let Some(found) = SHIPPED_SCENES.iter().find(|scene| scene.name() == name) {
        return Ok(found);
    }
    match SHIPPED_SCENES.iter().filter(is_file).collect::<Vec<_>>()[..] {
        [found] => Ok(found),
        [] => {
            let file = |name: &'static str| name.rsplit('/').next().unwrap_or(name);
            let files: Vec<&str> = SHIPPED_SCENES.iter().map(|scene| file(scene.name())).collect();
            let near = closest_match(name.rsplit('/').next().unwrap_or(name), &files);
            let near = near.and_then(|near| SHIPPED_SCENES.iter().find(|scene| file(scene.name()) == near));
            let suggestion = near.map_or_else(String::new, |near| format!("; did you mean {}?", near.name()));
            Err(format!("no shipped scene is called `{name}`{suggestion}"))
        }
        ref several => {
            let names: Vec<&str> = several.iter().map(|scene| scene.name()).collect();
            Err(format!("several shipped scenes are called `{name}`; give one of {}", names.join(", ")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_file_is_shipped_and_stands_alone() {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let mut directories = vec![scenes.clone()];
        let mut count = 0;
        while let Some(directory) = directories.pop() {
            for entry in
                std::fs::read_dir(&directory).expect("a directory").map(|entry| entry.expect("an entry").path())
            {
                if entry.is_dir() {
                    if !entry.ends_with("studies") {
                        directories.push(entry);
                    }
                    continue;
                }
                let file =
                    entry.strip_prefix(&scenes).expect("below scenes").to_str().expect("a name").replace('\\', "/");
                let found = SHIPPED_SCENES.iter().find(|scene| scene.file == file);
                let found = found.unwrap_or_else(|| panic!("add {file} to the list"));
                assert!(found.title().len() > 10, "{file}");
                let text = found.standalone_text().unwrap_or_else(|error| panic!("{error}"));
                let alone = scene::parse_any(&text, &file).unwrap_or_else(|error| panic!("{error}"));
                let from_file = scene::load_any(&entry).unwrap_or_else(|error| panic!("{error}"));
                assert_eq!(scene::show(&alone), scene::show(&from_file), "{file}");
                count += 1;
            }
        }
        assert_eq!(count, SHIPPED_SCENES.len());
    }

    #[test]
    fn names_are_found_by_path_and_by_file() {
        assert_eq!(shipped_scene("real/2f85-lift").map(ShippedScene::name), Ok("real/2f85-lift"));
        assert_eq!(shipped_scene("scenes/real/2f85-lift.toml").map(ShippedScene::name), Ok("real/2f85-lift"));
        assert_eq!(shipped_scene("2f85-lift").map(ShippedScene::name), Ok("real/2f85-lift"));
        assert_eq!(shipped_scene("other-assembly").map(ShippedScene::name), Ok("other-assembly"));
        let error = shipped_scene("2f85-lft").expect_err("no such scene");
        assert!(error.ends_with("did you mean real/2f85-lift?"), "{error}");
    }
}
