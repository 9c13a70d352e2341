//! From a file to a scene.

use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use super::error::line_column;
use super::{Layer, Problem, Scene, SceneError, Template, extended, parse, parse_any, parse_layers, parse_template};
use crate::files::read_at_most;
use crate::limits::LARGEST_SCENE_BYTES;

/// Reads, checks and resolves the scene file of a finger.
///
/// # Errors
/// What is wrong with the file, or that it is a scene of another kind.
pub fn load(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
    load_with(path, &[])
}

/// The same with single fields set besides: lines of `key = value`, as a scene file would have them.
///
/// # Errors
/// What is wrong with the file or with what is set, or that it is a scene of another kind.
pub fn load_with(path: impl AsRef<Path>, settings: &[Layer]) -> Result<Scene, SceneError> {
    parse_layers(&layers(path.as_ref())?, settings, parse)
}

/// Reads, checks and resolves a scene file of either kind.
pub fn load_any(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
    load_any_with(path, &[])
}

/// The same with single fields set besides; see [`load_with`].
///
/// # Errors
/// As for [`load_with`].
pub fn load_any_with(path: impl AsRef<Path>, settings: &[Layer]) -> Result<Scene, SceneError> {
    parse_layers(&layers(path.as_ref())?, settings, parse_any)
}

/// Reads the scene of a finger as what many designs have in common.
///
/// # Errors
/// What is wrong with the file, or what ties the scene to one design.
pub fn load_template(path: impl AsRef<Path>) -> Result<Template, SceneError> {
    load_template_with(path, &[])
}

/// The same with single fields set besides; see [`load_with`].
///
/// # Errors
/// As for [`load_template`].
pub fn load_template_with(path: impl AsRef<Path>, settings: &[Layer]) -> Result<Template, SceneError> {
    parse_layers(&layers(path.as_ref())?, settings, parse_template)
}

/// Scenes that may extend one another in a row.
const MOST_LAYERS: usize = 16;

/// The text of a scene file, behind those of the scenes it extends.
///
/// # Errors
/// A file that cannot be read, or scenes that extend each other.
pub fn layers(path: &Path) -> Result<Vec<Layer>, SceneError> {
    let (text, file) = read(path)?;
    behind(Layer { file, text }, path.to_path_buf())
}

/// The text of a scene, behind those of the scenes it extends: files, whose paths are seen from where its own file is, or would be.
///
/// # Errors
/// As [`layers`].
pub fn layers_of(own: Layer) -> Result<Vec<Layer>, SceneError> {
    let here = PathBuf::from(&own.file);
    behind(own, here)
}

/// A text that stands `here`, behind those it extends.
fn behind(own: Layer, mut here: PathBuf) -> Result<Vec<Layer>, SceneError> {
    let (mut layers, mut last) = (Vec::new(), own);
    let mut seen = vec![here.canonicalize().ok()];
    while let Some((base, span)) = extended(&last.text) {
        let refuse = |message: String, label: &str, help: &str| SceneError::Invalid {
            file: last.file.clone(),
            text: last.text.clone(),
            problems: vec![Problem { span: Some(span.clone()), message, label: label.into(), help: help.into() }],
        };
        here = here.parent().unwrap_or(Path::new("")).join(&base);
        let found = here.canonicalize().ok();
        if found.is_some() && seen.contains(&found) {
            let help = "leave one of them out: what is extended last says all that the others do not";
            return Err(refuse(format!("{} extends itself", here.display()), "comes back to a scene before it", help));
        }
        if seen.len() == MOST_LAYERS {
            let message = format!("more than {MOST_LAYERS} scenes extend one another");
            return Err(refuse(message, "one too many", "put some of them together"));
        }
        let (text, file) = read(&here).map_err(|error| match error {
            SceneError::Read { file, reason } => refuse(
                format!("cannot read the scene {file}: {reason}"),
                "this file",
                "name a scene file; its path is seen from the directory of the scene that extends it",
            ),
            error => error,
        })?;
        layers.push(std::mem::replace(&mut last, Layer { file, text }));
        seen.push(found);
    }
    layers.push(last);
    layers.reverse();
    Ok(layers)
}

/// The text of a file, and what messages call it.
pub(crate) fn read(path: &Path) -> Result<(String, String), SceneError> {
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
    let bytes = read_at_most(path, LARGEST_SCENE_BYTES).map_err(unreadable)?.ok_or_else(|| read(&too_large()))?;
    let text = String::from_utf8(bytes).map_err(|e| {
        let valid = e.utf8_error().valid_up_to();
        let before = String::from_utf8_lossy(&e.as_bytes()[..valid]);
        let (line, column) = line_column(&before, before.len());
        SceneError::NotUtf8 { file: file.clone(), line, column }
    })?;
    Ok((text, file))
}

/// Whether a file begins as logs do. What cannot be read twice, such as a pipe, is none.
fn is_log(path: &Path) -> std::io::Result<bool> {
    if !std::fs::metadata(path)?.is_file() {
        return Ok(false);
    }
    let mut head = Vec::new();
    std::fs::File::open(path)?.take(mcap::MAGIC.len() as u64).read_to_end(&mut head)?;
    Ok(head == mcap::MAGIC)
}

/// Why a file is not read to its end.
pub(crate) fn too_large() -> String {
    let most = LARGEST_SCENE_BYTES >> 20;
    format!("it is larger than {most} MiB, and no file that somebody wrote by hand is; check the path")
}
