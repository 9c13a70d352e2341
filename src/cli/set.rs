//! `--set FIELD=VALUE`: sets single fields of a scene on the command line, with the syntax of scene files.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::scene::{self, Layer, Scene, SceneError};

/// Fields of the scene that override its file.
#[derive(Debug, Default, Args)]
pub(crate) struct SetArgs {
    /// Override a field of the scene, such as contact.friction.mu_static=0.6 or design.base="12 mm"; can be repeated
    #[arg(long = "set", value_name = "FIELD=VALUE", value_parser = |text: &str| scene::parse_setting("--set", text))]
    pub(super) set: Vec<Layer>,
}

impl SetArgs {
    /// Loads a scene of any kind and applies these fields.
    pub(super) fn load_any(&self, path: &Path) -> Result<Scene, SceneError> {
        scene::load_any_with(path, &self.set)
    }

    /// Parses the text of a shipped scene and applies these fields.
    pub(super) fn parse_any(&self, text: &str, file: &str) -> Result<Scene, SceneError> {
        let shipped = Layer { file: file.to_string(), text: text.to_string() };
        scene::parse_layers(&[shipped], &self.set)
    }
}

/// Returns the files of a scene and of all scenes that it extends, or only its own path if these cannot be determined.
pub(super) fn source_files(scene: &Path) -> Vec<PathBuf> {
    // A pipe can be read only once.
    let layers = if scene.is_file() { scene::load_layers(scene).unwrap_or_default() } else { Vec::new() };
    let source_files: Vec<PathBuf> = layers.into_iter().map(|layer| layer.file.into()).collect();
    if source_files.is_empty() { vec![scene.to_path_buf()] } else { source_files }
}
