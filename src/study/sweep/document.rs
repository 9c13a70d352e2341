//! A study's document and the base scene it names or has in it, whatever else the study says.

use serde::Deserialize;
use serde_json::Value as Json;
use toml::de::{DeTable, DeValue, Deserializer};
use toml::{Spanned, Table};

use super::base::{self, Base, Refusal};
use super::error::StudyError;
use crate::scene::check::Checker;
use crate::scene::entry::Entry;
use crate::scene::kinds::{Kind, Text};
use crate::scene::text::syntax;
use crate::scene::words::SceneKind;
use crate::scene::{Problem, SceneError, keys};

/// What stands in a study file, unknown keys and the scene taken out.
pub(in crate::study) struct Document<R> {
    pub raw: R,
    /// Of the base scene.
    pub kind: SceneKind,
    /// What is wrong so far.
    pub problems: Vec<Problem>,
    pub scene: SceneParts,
}

/// The base scene before it is put together.
pub(in crate::study) struct SceneParts {
    named: Option<Result<Base, Refusal>>,
    inline: Option<Table>,
    set: Table,
}

/// Reads the text of a study file; `scene_of`: where its document names a scene file.
///
/// # Errors
/// What is no document of this kind at all.
pub(in crate::study) fn document<R: for<'de> Deserialize<'de>>(
    text: &str,
    file_name: &str,
    schema: &Json,
    scene_of: impl Fn(&R) -> &Entry<Text>,
) -> Result<Document<R>, StudyError> {
    let refuse = |problems| refused(text, file_name, problems);
    let mut document = DeTable::parse(text).map_err(|error| refuse(vec![syntax(&error)]))?;
    let inline = take(document.get_mut(), "scene");
    let set = take(document.get_mut(), "set");
    let allowed = keys::Allowed { kind: "study", schema, others: &Vec::new };
    let mut problems = keys::weed(document.get_mut(), &allowed);
    let raw = R::deserialize(Deserializer::from(document)).map_err(|error| refuse(vec![syntax(&error)]))?;
    let entry = scene_of(&raw);
    // What the axes and [set] may say depends on the kind of scene, so its file is looked at first; what is wrong there is said last.
    let named = entry.given.as_ref().and_then(|given| Text::read("scene", given).ok());
    let named = named.map(|scene| base::load(&scene, file_name, entry.span()));
    let kind = match (&inline, &named) {
        (Some(inline), _) => base::kind_of(inline.get_ref()),
        (None, Some(Ok(Base { kind, .. }) | Err(Refusal::Scene(_, kind)))) => *kind,
        (None, _) => SceneKind::Finger,
    };
    let mut part = |table: Spanned<DeTable<'_>>, path: &str| base::check(table, path, kind, &mut problems);
    let inline = inline.map(|table| part(table, "scene"));
    let set = set.map(|table| part(table, "set")).unwrap_or_default();
    Ok(Document { raw, kind, problems, scene: SceneParts { named, inline, set } })
}

/// That a study is refused.
pub(in crate::study) fn refused(text: &str, file_name: &str, problems: Vec<Problem>) -> StudyError {
    StudyError::Invalid(SceneError::Invalid { file: file_name.to_string(), text: text.to_string(), problems })
}

impl SceneParts {
    /// Notes that there is no scene; `entry`: where one could be named.
    pub fn check(&self, c: &mut Checker<'_>, entry: &Entry<Text>) {
        let scene = c.get("scene", entry);
        if scene.is_none() && self.inline.is_none() && !entry.is_given() {
            let help =
                "say which scene is the base: scene = \"experiment-95.toml\", or give it here as a table [scene]";
            c.push(None, "`scene` is missing", "", help);
        }
    }

    /// The base scene with what [set] puts into it, and the text of its file.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn put_together(self, text: &str, file_name: &str) -> Result<(Table, String), StudyError> {
        let (mut table, text) = match self.named {
            Some(Ok(Base { table, text, .. })) => (table, text),
            Some(Err(Refusal::Study(problem))) => return Err(refused(text, file_name, vec![problem])),
            Some(Err(Refusal::Scene(error, _))) => return Err(StudyError::Invalid(error)),
            None => (self.inline.unwrap_or_default(), String::new()),
        };
        super::template::merge(&mut table, self.set);
        Ok((table, text))
    }
}

/// Takes a table out of the document; anything else of that name stays, to be complained about.
fn take<'a>(document: &mut DeTable<'a>, key: &str) -> Option<Spanned<DeTable<'a>>> {
    document.get(key).filter(|value| matches!(value.get_ref(), DeValue::Table(_)))?;
    let value = document.remove(key)?;
    let span = value.span();
    match value.into_inner() {
        DeValue::Table(table) => Some(Spanned::new(span, table)),
        _ => None,
    }
}
