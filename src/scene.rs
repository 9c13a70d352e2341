//! Loads scene files and the scenes that they extend. The core defines scenes and parses their text.

use std::io::{ErrorKind, Read};
use std::path::{Path as FilePath, PathBuf};

pub use phalanx_core::scene::*;

use self::error::line_column;
use crate::files::read_at_most;
use crate::limits::MAX_SCENE_BYTES;

/// Reads, checks and resolves the scene file of a finger.
///
/// # Errors
/// Returns all problems of the file, or an error if the scene is of another kind.
pub fn load(path: impl AsRef<FilePath>) -> Result<Scene, SceneError> {
    parse_layers_as(&load_layers(path.as_ref())?, &[], parse)
}

/// Reads, checks and resolves a scene file of any kind.
pub fn load_any(path: impl AsRef<FilePath>) -> Result<Scene, SceneError> {
    load_any_with(path, &[])
}

/// Like [`load_any`], with single fields overridden by `settings`: lines of `key = value` as in a scene file.
///
/// # Errors
/// Returns all problems of the file and of the settings.
pub fn load_any_with(path: impl AsRef<FilePath>, settings: &[Layer]) -> Result<Scene, SceneError> {
    parse_layers(&load_layers(path.as_ref())?, settings)
}

/// Maximum number of scenes in a chain of extensions.
const MAX_LAYERS: usize = 16;

/// Reads a scene file and the scenes that it extends. The text of the scene itself comes last.
///
/// # Errors
/// Returns an error if a file cannot be read, or if scenes extend each other.
pub fn load_layers(path: &FilePath) -> Result<Vec<Layer>, SceneError> {
    let (text, file) = read(path)?;
    load_bases(Layer { file, text }, path.to_path_buf(), None)
}

/// Reads the scenes that the text of a scene extends. The given text comes last. Paths are relative to the directory of
/// its `file`, which need not exist.
///
/// # Errors
/// See [`load_layers`].
pub fn load_extended(scene_layer: Layer) -> Result<Vec<Layer>, SceneError> {
    load_extended_in(scene_layer, None)
}

/// Like [`load_extended`], for a scene that is the table `section` of the text; `None` for the whole text.
///
/// # Errors
/// See [`load_layers`].
pub fn load_extended_in(scene_layer: Layer, section: Option<&str>) -> Result<Vec<Layer>, SceneError> {
    let path = PathBuf::from(&scene_layer.file);
    load_bases(scene_layer, path, section)
}

/// Reads the scenes that a text with this path extends; the given text comes last.
fn load_bases(scene_layer: Layer, mut path: PathBuf, mut section: Option<&str>) -> Result<Vec<Layer>, SceneError> {
    let (mut layers, mut last) = (Vec::new(), scene_layer);
    let mut visited = vec![path.canonicalize().ok()];
    while let Some((base, span)) = extended_in(&last.text, section.take()) {
        let invalid = |message: String, label: &str, help: &str| SceneError::Invalid {
            file: last.file.clone(),
            text: last.text.clone(),
            problems: vec![Problem { span: Some(span.clone()), message, label: label.into(), help: help.into() }],
        };
        path = path.parent().unwrap_or(FilePath::new("")).join(&base);
        let canonical = path.canonicalize().ok();
        if canonical.is_some() && visited.contains(&canonical) {
            let help = "remove one `extends` of the cycle: the scene without it is the base of the others";
            return Err(invalid(format!("{} extends itself", path.display()), "leads back to an earlier scene", help));
        }
        if visited.len() == MAX_LAYERS {
            let message = format!("more than {MAX_LAYERS} scenes extend one another");
            return Err(invalid(message, "one too many", "merge some of them"));
        }
        let (text, file) = read(&path).map_err(|error| match error {
            SceneError::Read { file, reason } => invalid(
                format!("cannot read the scene {file}: {reason}"),
                "this file",
                "name a scene file; its path is relative to the directory of the scene that extends it",
            ),
            error => error,
        })?;
        layers.push(std::mem::replace(&mut last, Layer { file, text }));
        visited.push(canonical);
    }
    layers.push(last);
    layers.reverse();
    Ok(layers)
}

/// Returns the text of a file and its name for messages.
pub(crate) fn read(path: &FilePath) -> Result<(String, String), SceneError> {
    let file = path.display().to_string();
    let read = |reason: &str| SceneError::Read { file: file.clone(), reason: reason.to_string() };
    if path.is_dir() {
        return Err(read("it is a directory; name a scene file (.toml) in it"));
    }
    let unreadable = |e: std::io::Error| match e.kind() {
        ErrorKind::NotFound => read("there is no such file; check the path"),
        ErrorKind::PermissionDenied => read("permission denied"),
        _ => read(&e.to_string()),
    };
    if is_log(path).map_err(unreadable)? {
        return Err(SceneError::Log { file });
    }
    let bytes = read_at_most(path, MAX_SCENE_BYTES).map_err(unreadable)?.ok_or_else(|| {
        let max = MAX_SCENE_BYTES >> 20;
        read(&format!("it is larger than {max} MiB, more than a file written by hand; check the path"))
    })?;
    let text = String::from_utf8(bytes).map_err(|e| {
        let valid = e.utf8_error().valid_up_to();
        let before = String::from_utf8_lossy(&e.as_bytes()[..valid]);
        let (line, column) = line_column(&before, before.len());
        SceneError::NotUtf8 { file: file.clone(), line, column }
    })?;
    Ok((text, file))
}

/// Whether a file begins with the magic bytes of a log. `false` for files that cannot be read twice, such as pipes.
fn is_log(path: &FilePath) -> std::io::Result<bool> {
    if !std::fs::metadata(path)?.is_file() {
        return Ok(false);
    }
    let mut head = Vec::new();
    std::fs::File::open(path)?.take(mcap::MAGIC.len() as u64).read_to_end(&mut head)?;
    Ok(head == mcap::MAGIC)
}
