//! From a file to a scene.

use std::io::ErrorKind;
use std::path::Path;

use serde::Deserialize;
use toml::de::{DeTable, Deserializer};

use super::check::Checker;
use super::error::{Problem, SceneError, line_column};
use super::raw::RawScene;
use super::schema::schema_value;
use super::{Scene, keys, resolve};

/// Reads, checks and resolves a scene file.
pub fn load(path: impl AsRef<Path>) -> Result<Scene, SceneError> {
    let path = path.as_ref();
    let file = path.display().to_string();
    let read = |reason: &str| SceneError::Read { file: file.clone(), reason: reason.to_string() };
    if path.is_dir() {
        return Err(read("it is a directory; name a scene file (.toml) in it"));
    }
    let bytes = std::fs::read(path).map_err(|e| match e.kind() {
        ErrorKind::NotFound => read("there is no such file; check the path"),
        ErrorKind::PermissionDenied => read("permission denied"),
        _ => read(&e.to_string()),
    })?;
    let text = String::from_utf8(bytes).map_err(|e| {
        let valid = e.utf8_error().valid_up_to();
        let before = String::from_utf8_lossy(&e.as_bytes()[..valid]);
        let (line, column) = line_column(&before, before.len());
        SceneError::NotUtf8 { file: file.clone(), line, column }
    })?;
    parse(&text, &file)
}

/// Checks and resolves the text of a scene; `file_name` appears in messages and gives the default name.
pub fn parse(text: &str, file_name: &str) -> Result<Scene, SceneError> {
    scene(text, file_name).map_err(|problems| SceneError::Invalid {
        file: file_name.to_string(),
        text: text.to_string(),
        problems,
    })
}

fn scene(text: &str, file_name: &str) -> Result<Scene, Vec<Problem>> {
    let mut document = DeTable::parse(text).map_err(|e| vec![syntax(&e)])?;
    let weeds = keys::weed(document.get_mut(), &schema_value());
    let raw = RawScene::deserialize(Deserializer::from(document)).map_err(|e| vec![syntax(&e)])?;
    resolve::resolve(&raw, Checker::new(text, weeds), file_name)
}

/// An error of the TOML parser.
fn syntax(error: &toml::de::Error) -> Problem {
    Problem {
        span: error.span(),
        message: format!("not valid TOML: {}", error.message().trim()),
        label: String::new(),
        help:
            "a line is a [section], or key = value; texts, quantities among them, stand in quotes: radius = \"20 mm\""
                .into(),
    }
}
