//! From a text to a scene.

use toml::de::DeTable;

use super::check::Checker;
use super::error::{Problem, SceneError};
use super::kinds::Words;
use super::raw::Raw;
use super::schema::{schema_of, schemas_but};
use super::suggest::nearest;
use super::words::SceneKind;
use super::{Scene, Template, keys, resolve};

/// Checks and resolves the text of a finger's scene; `file_name` appears in messages and gives the default name.
///
/// # Errors
/// What is wrong with the text, or that it is a scene of another kind.
pub fn parse(text: &str, file_name: &str) -> Result<Scene, SceneError> {
    let refuse = |problems| SceneError::Invalid { file: file_name.to_string(), text: text.to_string(), problems };
    let scene = any(text, file_name).map_err(refuse)?;
    match scene.kind() {
        SceneKind::Finger => Ok(scene),
        kind => Err(refuse(vec![not_a_finger(text, kind)])),
    }
}

/// Checks and resolves the text of a scene of any kind.
pub fn parse_any(text: &str, file_name: &str) -> Result<Scene, SceneError> {
    any(text, file_name).map_err(|problems| SceneError::Invalid {
        file: file_name.to_string(),
        text: text.to_string(),
        problems,
    })
}

/// Reads the text of a finger's scene as what many designs have in common; `file_name` appears in messages and gives the default name.
///
/// # Errors
/// What is wrong with the text, or what ties the scene to one design.
pub fn parse_template(text: &str, file_name: &str) -> Result<Template, SceneError> {
    // Whatever is wrong with the scene by itself is said first.
    let scene = parse(text, file_name)?;
    let refuse = |problems| SceneError::Invalid { file: file_name.to_string(), text: text.to_string(), problems };
    let read = DeTable::parse(text).and_then(|document| Raw::of(SceneKind::Finger, document));
    let raw = read.map_err(|e| refuse(vec![syntax(&e)]))?;
    resolve::template(&raw, Checker::new(text, Vec::new()), &scene).map_err(refuse)
}

fn any(text: &str, file_name: &str) -> Result<Scene, Vec<Problem>> {
    let mut document = DeTable::parse(text).map_err(|e| vec![syntax(&e)])?;
    let kind = kind(document.get_ref());
    let allowed = keys::Allowed { kind: kind.word(), schema: schema_of(kind), others: &|| schemas_but(kind) };
    let weeds = keys::weed(document.get_mut(), &allowed);
    let checker = Checker::new(text, weeds);
    let raw = Raw::of(kind, document).map_err(|e| vec![syntax(&e)])?;
    resolve::scene(&raw, checker, file_name)
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
        None if ["right", "left", "palm_width"].iter().any(|key| document.contains_key(*key)) => SceneKind::Gripper,
        None => SceneKind::Finger,
    }
}

/// A sound scene of another kind where a finger is wanted.
fn not_a_finger(text: &str, kind: SceneKind) -> Problem {
    let document = DeTable::parse(text).ok();
    Problem {
        span: document.and_then(|document| document.get_ref().get("kind").map(|value| value.span())),
        message: format!("this is a scene of kind \"{}\", but only one of kind \"finger\" will do here", kind.word()),
        label: "another kind".into(),
        help: "give the scene of a finger; scenes of other kinds are for `phalanx run`, `validate` and `scene`".into(),
    }
}

/// An error of the TOML parser.
pub fn syntax(error: &toml::de::Error) -> Problem {
    Problem {
        span: error.span(),
        message: format!("not valid TOML: {}", error.message().trim()),
        label: String::new(),
        help:
            "a line is a [section], or key = value; texts, quantities among them, stand in quotes: radius = \"20 mm\""
                .into(),
    }
}
