//! What can be asked.

use serde::Deserialize;

/// A question about a scene.
#[derive(Debug, Deserialize)]
pub struct Request {
    pub ask: Ask,
    pub scene: Text,
    /// Fields and what they are set to, as `--set FIELD=VALUE` takes them.
    #[serde(default)]
    pub set: Vec<(String, String)>,
    /// The fields that a map varies, and their values: one row a run.
    #[serde(default)]
    pub fields: Vec<String>,
    #[serde(default)]
    pub points: Vec<Vec<String>>,
}

/// A scene file.
#[derive(Debug, Deserialize)]
pub struct Text {
    pub file: String,
    pub text: String,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Ask {
    Fields,
    Run,
    Check,
    Statics,
    Criteria,
    Toml,
    Csv,
}
