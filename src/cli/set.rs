//! `--set FIELD=VALUE`: single fields of a scene, given on the command line and read as in a file.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::scene::{self, Layer, Scene, SceneError, Template};

/// Fields of the scene, set besides.
#[derive(Clone, Debug, Default, Args)]
pub struct SetArgs {
    /// Set a field of the scene, such as contact.friction.mu_static=0.6 or design.base="12 mm", in place of what its file says;
    /// may be given several times
    #[arg(long = "set", value_name = "FIELD=VALUE", value_parser = line)]
    set: Vec<Layer>,
}

impl SetArgs {
    /// The scene in a file, of either kind, with these fields.
    pub fn load_any(&self, path: &Path) -> Result<Scene, SceneError> {
        scene::load_any_with(path, &self.set)
    }

    /// The scene of a finger in a file, with these fields.
    pub fn load(&self, path: &Path) -> Result<Scene, SceneError> {
        scene::load_with(path, &self.set)
    }

    /// A shipped scene, given as text, with these fields.
    pub fn parse_any(&self, text: &str, file: &str) -> Result<Scene, SceneError> {
        let own = Layer { file: file.to_string(), text: text.to_string() };
        scene::parse_layers(&[own], &self.set, scene::parse_any)
    }

    /// These fields, as lines of a scene.
    pub fn settings(&self) -> &[Layer] {
        &self.set
    }

    pub fn is_empty(&self) -> bool {
        self.set.is_empty()
    }

    /// What the designs of a study have in common, with these fields.
    pub fn load_template(&self, path: &Path) -> Result<Template, SceneError> {
        scene::load_template_with(path, &self.set)
    }
}

/// The files that a scene is made of; only itself where they cannot be told.
pub fn files(scene: &Path) -> Vec<PathBuf> {
    // A pipe is read once.
    let layers = if scene.is_file() { scene::layers(scene).unwrap_or_default() } else { Vec::new() };
    let files: Vec<PathBuf> = layers.into_iter().map(|layer| layer.file.into()).collect();
    if files.is_empty() { vec![scene.to_path_buf()] } else { files }
}

/// One field as a line of a scene.
fn line(text: &str) -> Result<Layer, String> {
    scene::setting("--set", text)
}
