//! Parses the text of a scene.

use toml::de::DeTable;

use super::check::Checker;
use super::error::{Problem, SceneError};
use super::keywords::SceneKind;
use super::quantity::Keyword;
use super::schema::{other_schemas, schema_for};
use super::section_input::SceneInput;
use super::suggest::closest_match;
use super::{Scene, Template, keys, resolve};

/// Parses, checks and resolves the scene of a finger; `file_name` appears in messages and gives the default name.
///
/// # Errors
/// Returns all problems of the text, or an error if the scene is of another kind.
pub fn parse(text: &str, file_name: &str) -> Result<Scene, SceneError> {
    let refuse = |problems| SceneError::Invalid { file: file_name.to_string(), text: text.to_string(), problems };
    let scene = parse_kind(text, file_name).map_err(refuse)?;
    match scene.kind() {
        SceneKind::Finger => Ok(scene),
        kind => Err(refuse(vec![not_a_finger(text, kind)])),
    }
}

/// Parses, checks and resolves a scene of any kind.
pub fn parse_any(text: &str, file_name: &str) -> Result<Scene, SceneError> {
    parse_kind(text, file_name).map_err(|problems| SceneError::Invalid {
        file: file_name.to_string(),
        text: text.to_string(),
        problems,
    })
}

/// Parses the scene of a finger as a template for many designs; `file_name` appears in messages and gives the default
/// name.
///
/// # Errors
/// Returns all problems of the text, including keys that tie the scene to one design.
pub fn parse_template(text: &str, file_name: &str) -> Result<Template, SceneError> {
    // Problems of the scene itself are reported first.
    let scene = parse(text, file_name)?;
    let refuse = |problems| SceneError::Invalid { file: file_name.to_string(), text: text.to_string(), problems };
    let read = DeTable::parse(text).and_then(|document| SceneInput::parse(SceneKind::Finger, document));
    let input = read.map_err(|e| refuse(vec![syntax_problem(&e)]))?;
    resolve::template(&input, Checker::new(text, Vec::new()), &scene).map_err(refuse)
}

fn parse_kind(text: &str, file_name: &str) -> Result<Scene, Vec<Problem>> {
    let mut document = DeTable::parse(text).map_err(|e| vec![syntax_problem(&e)])?;
    let kind = kind(document.get_ref());
    let allowed =
        keys::KeySchemas { kind: kind.keyword(), schema: schema_for(kind), other_kinds: &|| other_schemas(kind) };
    let unknown_keys = keys::remove_unknown(document.get_mut(), &allowed);
    let checker = Checker::new(text, unknown_keys);
    let input = SceneInput::parse(kind, document).map_err(|e| vec![syntax_problem(&e)])?;
    resolve::scene(&input, checker, file_name)
}

/// Returns the kind of a scene, or the most likely one if it is mistyped: all other keys are checked for this kind.
fn kind(document: &DeTable<'_>) -> SceneKind {
    let Some(text) = document.get("kind").and_then(|value| value.get_ref().as_str()) else {
        return SceneKind::Finger;
    };
    let keywords: Vec<&str> = SceneKind::KEYWORDS.iter().map(|(keyword, _)| *keyword).collect();
    let similar = closest_match(text, &keywords);
    let found = SceneKind::KEYWORDS.iter().find(|(candidate, _)| *candidate == text || Some(*candidate) == similar);
    match found {
        Some((_, kind)) => *kind,
        None if document.contains_key("discs") => SceneKind::Bodies,
        None if ["right", "left", "palm_width"].iter().any(|key| document.contains_key(*key)) => SceneKind::Gripper,
        None => SceneKind::Finger,
    }
}

/// Problem for a valid scene of another kind where the scene of a finger is required.
fn not_a_finger(text: &str, kind: SceneKind) -> Problem {
    let document = DeTable::parse(text).ok();
    Problem {
        span: document.and_then(|document| document.get_ref().get("kind").map(|value| value.span())),
        message: format!("this is a scene of kind \"{}\", but a scene of kind \"finger\" is required", kind.keyword()),
        label: "another kind".into(),
        help: "give the scene of a finger; `phalanx run`, `validate` and `scene` accept the other kinds".into(),
    }
}

/// Problem for an error of the TOML parser.
pub fn syntax_problem(error: &toml::de::Error) -> Problem {
    Problem {
        span: error.span(),
        message: format!("not valid TOML: {}", error.message().trim()),
        label: String::new(),
        help: "a line is a [section] or key = value; strings and quantities are in quotes: radius = \"20 mm\"".into(),
    }
}
