//! TOML document of a study file and its base scene.

use serde::Deserialize;
use serde_json::Value as Json;
use toml::de::{DeTable, DeValue, Deserializer};
use toml::{Spanned, Table};

use super::base::{self, Base, BaseError};
use super::error::StudyError;
use crate::scene::check::Checker;
use crate::scene::entry::Entry;
use crate::scene::keywords::SceneKind;
use crate::scene::parse::syntax_problem;
use crate::scene::value_kinds::{InputKind, Text};
use crate::scene::{Problem, SceneError, keys};

/// Content of a study file without unknown keys and the scene.
pub(in crate::study) struct StudyDocument<R> {
    pub raw: R,
    /// Kind of the base scene.
    pub kind: SceneKind,
    /// Problems so far.
    pub problems: Vec<Problem>,
    pub scene: BaseSceneParts,
}

/// Parts of the base scene.
pub(in crate::study) struct BaseSceneParts {
    named: Option<Result<Base, BaseError>>,
    inline: Option<Table>,
    set: Table,
}

/// Parses the text of a study file. `scene_of` returns the entry that names a scene file.
///
/// # Errors
/// Returns an error if the text is not valid TOML, or its structure is not that of a study.
pub(in crate::study) fn parse_document<R: for<'de> Deserialize<'de>>(
    text: &str,
    file_name: &str,
    schema: &Json,
    scene_of: impl Fn(&R) -> &Entry<Text>,
) -> Result<StudyDocument<R>, StudyError> {
    let refuse = |problems| invalid_study(text, file_name, problems);
    let mut document = DeTable::parse(text).map_err(|error| refuse(vec![syntax_problem(&error)]))?;
    let inline = take_table(document.get_mut(), "scene");
    let set = take_table(document.get_mut(), "set");
    let allowed = keys::KeySchemas { kind: "study", schema, other_kinds: &Vec::new };
    let mut problems = keys::remove_unknown(document.get_mut(), &allowed);
    let raw = R::deserialize(Deserializer::from(document)).map_err(|error| refuse(vec![syntax_problem(&error)]))?;
    let entry = scene_of(&raw);
    // The valid fields of the axes and of [set] depend on the kind of scene, so its file is read first. Its problems
    // are reported last.
    let named = entry.value.as_ref().and_then(|value| Text::read("scene", value).ok());
    let named = named.map(|scene| base::load(&scene, file_name, entry.span()));
    let kind = match (&inline, &named) {
        (Some(inline), _) => base::scene_kind(inline.get_ref()),
        (None, Some(Ok(Base { kind, .. }) | Err(BaseError::Scene(_, kind)))) => *kind,
        (None, _) => SceneKind::Finger,
    };
    let mut check = |table: Spanned<DeTable<'_>>, path: &str| base::check_scene(table, path, kind, &mut problems);
    let inline = inline.map(|table| check(table, "scene"));
    let set = set.map(|table| check(table, "set")).unwrap_or_default();
    Ok(StudyDocument { raw, kind, problems, scene: BaseSceneParts { named, inline, set } })
}

/// Error for a study with these problems.
pub(in crate::study) fn invalid_study(text: &str, file_name: &str, problems: Vec<Problem>) -> StudyError {
    StudyError::Invalid(SceneError::Invalid { file: file_name.to_string(), text: text.to_string(), problems })
}

impl BaseSceneParts {
    /// Reports a missing base scene; `entry` is the key that could name one.
    pub fn check(&self, checker: &mut Checker<'_>, entry: &Entry<Text>) {
        let scene = checker.get("scene", entry);
        if scene.is_none() && self.inline.is_none() && !entry.is_present() {
            let help = "name the base scene: scene = \"experiment-95.toml\", or write it in a table [scene]";
            checker.push(None, "`scene` is missing", "", help);
        }
    }

    /// Returns the base scene with the fields of [set], and the text of its file.
    ///
    /// # Errors
    /// Returns an error if the scene file is invalid or cannot be read.
    pub fn assemble(self, text: &str, file_name: &str) -> Result<(Table, String), StudyError> {
        let (mut table, text) = match self.named {
            Some(Ok(Base { table, text, .. })) => (table, text),
            Some(Err(BaseError::Study(problem))) => return Err(invalid_study(text, file_name, vec![problem])),
            Some(Err(BaseError::Scene(error, _))) => return Err(StudyError::Invalid(error)),
            None => (self.inline.unwrap_or_default(), String::new()),
        };
        super::template::merge(&mut table, self.set);
        Ok((table, text))
    }
}

/// Removes and returns a table of the document. A value of another type stays and is reported later.
fn take_table<'a>(document: &mut DeTable<'a>, key: &str) -> Option<Spanned<DeTable<'a>>> {
    document.get(key).filter(|value| matches!(value.get_ref(), DeValue::Table(_)))?;
    let value = document.remove(key)?;
    let span = value.span();
    match value.into_inner() {
        DeValue::Table(table) => Some(Spanned::new(span, table)),
        _ => None,
    }
}
