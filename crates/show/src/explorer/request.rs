//! Requests of the explorer page, in JSON.

use serde::Deserialize;

/// A request about a scene.
#[derive(Debug, Deserialize)]
pub struct Request {
    #[serde(rename = "ask")]
    pub kind: RequestKind,
    pub scene: SceneFile,
    /// Fields and their values, as in `--set FIELD=VALUE`.
    #[serde(default)]
    pub set: Vec<(String, String)>,
    /// The fields that a map varies, and their values: one row per run.
    #[serde(default)]
    pub fields: Vec<String>,
    #[serde(default)]
    pub points: Vec<Vec<String>>,
}

/// A scene file.
#[derive(Debug, Deserialize)]
pub struct SceneFile {
    pub file: String,
    pub text: String,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RequestKind {
    Fields,
    Run,
    Check,
    Statics,
    Criteria,
    Toml,
    Csv,
}
