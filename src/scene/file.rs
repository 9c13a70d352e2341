//! From a file to a scene.

use std::io::{ErrorKind, Read};
use std::path::Path;

use serde::Deserialize;
use toml::de::{DeTable, Deserializer};

use super::check::Checker;
use super::error::{Problem, SceneError, line_column};
use super::kinds::Words;
use super::raw::RawScene;
use super::raw_bodies::RawBodiesScene;
use super::schema::schema_of;
use super::suggest::nearest;
use super::words::SceneKind;
use super::{AnyScene, Scene, Template, keys, resolve};
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

/// Checks and resolves the text of a finger's scene; `file_name` appears in messages and gives the default name.
///
/// # Errors
/// What is wrong with the text, or that it is a scene of another kind.
pub fn parse(text: &str, file_name: &str) -> Result<Scene, SceneError> {
    let refuse = |problems| SceneError::Invalid { file: file_name.to_string(), text: text.to_string(), problems };
    match any(text, file_name).map_err(refuse)? {
        AnyScene::Finger(scene) => Ok(*scene),
        AnyScene::Bodies(_) => Err(refuse(vec![not_a_finger(text)])),
    }
}

/// Checks and resolves the text of a scene of either kind.
pub fn parse_any(text: &str, file_name: &str) -> Result<AnyScene, SceneError> {
    any(text, file_name).map_err(|problems| SceneError::Invalid {
        file: file_name.to_string(),
        text: text.to_string(),
        problems,
    })
}

/// Reads the scene of a finger as what many designs have in common.
///
/// # Errors
/// What is wrong with the file, or what ties the scene to one design.
pub fn load_template(path: impl AsRef<Path>) -> Result<Template, SceneError> {
    let (text, file) = read(path.as_ref())?;
    parse_template(&text, &file)
}

/// [`load_template`] of a text; `file_name` appears in messages and gives the default name.
///
/// # Errors
/// What is wrong with the text, or what ties the scene to one design.
pub fn parse_template(text: &str, file_name: &str) -> Result<Template, SceneError> {
    // Whatever is wrong with the scene by itself is said first.
    let scene = parse(text, file_name)?;
    let refuse = |problems| SceneError::Invalid { file: file_name.to_string(), text: text.to_string(), problems };
    let read = Deserializer::parse(text).and_then(RawScene::deserialize);
    let raw = read.map_err(|e| refuse(vec![syntax(&e)]))?;
    resolve::template(&raw, Checker::new(text, Vec::new()), &scene).map_err(refuse)
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

fn any(text: &str, file_name: &str) -> Result<AnyScene, Vec<Problem>> {
    let mut document = DeTable::parse(text).map_err(|e| vec![syntax(&e)])?;
    let kind = kind(document.get_ref());
    let other = match kind {
        SceneKind::Finger => SceneKind::Bodies,
        SceneKind::Bodies => SceneKind::Finger,
    };
    let (schema, other_schema) = (schema_of(kind), schema_of(other));
    let allowed = keys::Allowed { kind: kind.word(), schema, other_kind: other.word(), other_schema };
    let weeds = keys::weed(document.get_mut(), &allowed);
    let checker = Checker::new(text, weeds);
    let from = Deserializer::from(document);
    match kind {
        SceneKind::Finger => {
            let raw = RawScene::deserialize(from).map_err(|e| vec![syntax(&e)])?;
            resolve::finger(&raw, checker, file_name).map(|scene| AnyScene::Finger(Box::new(scene)))
        }
        SceneKind::Bodies => {
            let raw = RawBodiesScene::deserialize(from).map_err(|e| vec![syntax(&e)])?;
            resolve::bodies(&raw, checker, file_name).map(|scene| AnyScene::Bodies(Box::new(scene)))
        }
    }
}

/// The kind of a scene, or the one it was probably meant to be: all else is judged by it.
fn kind(document: &DeTable<'_>) -> SceneKind {
    let Some(word) = document.get("kind").and_then(|value| value.get_ref().as_str()) else {
        return SceneKind::Finger;
    };
    let words: Vec<&str> = SceneKind::WORDS.iter().map(|(word, _)| *word).collect();
    let meant = nearest(word, &words);
    let found = SceneKind::WORDS.iter().find(|(candidate, _)| *candidate == word || Some(*candidate) == meant);
    match found {
        Some((_, kind)) => *kind,
        None if document.contains_key("discs") => SceneKind::Bodies,
        None => SceneKind::Finger,
    }
}

/// A sound scene of discs where a finger is wanted.
fn not_a_finger(text: &str) -> Problem {
    let document = DeTable::parse(text).ok();
    Problem {
        span: document.and_then(|document| document.get_ref().get("kind").map(|value| value.span())),
        message: "this is a scene of kind \"bodies\", but only one of kind \"finger\" will do here".into(),
        label: "another kind".into(),
        help: "give the scene of a finger; scenes of discs are for `phalanx run`, `validate` and `scene`".into(),
    }
}

/// An error of the TOML parser.
pub(crate) fn syntax(error: &toml::de::Error) -> Problem {
    Problem {
        span: error.span(),
        message: format!("not valid TOML: {}", error.message().trim()),
        label: String::new(),
        help:
            "a line is a [section], or key = value; texts, quantities among them, stand in quotes: radius = \"20 mm\""
                .into(),
    }
}
