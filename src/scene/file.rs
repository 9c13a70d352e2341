//! From a file to a scene.

use std::io::{ErrorKind, Read};
use std::path::Path;

use super::error::line_column;
use super::{AnyScene, Scene, SceneError, Template, parse, parse_any, parse_template};
use crate::files::read_at_most;
use crate::limits::LARGEST_SCENE_BYTES;

/// Reads, checks and resolves the scene file of a finger.
///
/// # Errors
/// What is wrong with the file, or that it is a scene of another kind.
pub fn load(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
    let (text, file) = read(path.as_ref())?;
    parse(&text, &file)
}

/// Reads, checks and resolves a scene file of either kind.
pub fn load_any(path: impl AsRef<Path>) -> Result<AnyScene, SceneError> {
    let (text, file) = read(path.as_ref())?;
    parse_any(&text, &file)
}

/// Reads the scene of a finger as what many designs have in common.
///
/// # Errors
/// What is wrong with the file, or what ties the scene to one design.
pub fn load_template(path: impl AsRef<Path>) -> Result<Template, SceneError> {
    let (text, file) = read(path.as_ref())?;
    parse_template(&text, &file)
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
