//! A section of a scene as a table of lines, and what is said of each.

use serde_json::Value;
use toml::Spanned;

use super::held::Written;
use crate::scene::any::Any;
use crate::scene::check::Bound;
use crate::scene::error::Problem;
use crate::scene::words::SceneKind;

/// What is said of a key.
#[derive(Clone, Copy, Debug)]
pub struct About {
    pub key: &'static str,
    pub doc: &'static str,
    /// Which numbers are allowed.
    pub allowed: Bound,
    /// The key that decides whether the section has a place for this one, and why there is none.
    pub beside: Option<(&'static str, &'static str)>,
    /// What to do where it is lacking and has no default, if it must be given.
    pub needed: Option<&'static str>,
    /// Its default follows from something else.
    pub follows: bool,
    /// The default as people say it, where that is not the shortest text.
    pub said: Option<&'static str>,
    /// Its name in records, where that is not the key and its unit.
    pub column: Option<&'static str>,
    /// The kinds of scene that have it.
    pub of: &'static [SceneKind],
}

/// A line, whatever kind of value it holds.
pub trait Field<T>: Sync {
    fn about(&self) -> &About;

    /// JSON Schema of its kind of value.
    fn kind(&self) -> Value;

    /// The value, if the section has it.
    fn get(&self, section: &mut T) -> Option<Written>;

    /// Sections in which a choice has each of its values; none of what is no choice.
    fn variants(&self) -> Vec<T>;

    /// Puts a value of a scene into a section; whether it is within bounds.
    ///
    /// # Errors
    /// Why it is no such value; `key` is for messages.
    fn read(&self, key: &str, given: &Spanned<Any>, into: &mut T) -> Result<bool, Vec<Problem>>;

    /// Puts a recorded value into a section; whether there is such a value.
    fn recall(&self, text: &str, into: &mut T) -> bool;
}

/// A section whose keys are fields of a struct.
pub trait Table: Clone + 'static {
    /// What the section is for.
    const DOC: &'static str;
    /// The same in scenes of kinds in which it is for something else.
    const DOCS: &'static [(SceneKind, &'static str)] = &[];
    /// Its keys in the order in which they are read and shown: a choice before what has a meaning beside it only.
    const LINES: &'static [&'static dyn Field<Self>];
    /// Sections in it, with their schemas.
    const INNER: Inner = &[];

    /// The section of a scene that does not have it; not a number where no number is usual.
    fn usual() -> Self;

    /// The same of a scene of some kind.
    fn usual_in(_: SceneKind) -> Self {
        Self::usual()
    }

    /// What the section is for in scenes of a kind.
    fn doc(kind: SceneKind) -> &'static str {
        let own = Self::DOCS.iter().find(|(of, _)| *of == kind);
        own.map_or(Self::DOC, |(_, doc)| doc).trim_start()
    }
}

/// The lines of a section in scenes of a kind.
pub fn lines_of<T: Table>(kind: SceneKind) -> impl Iterator<Item = &'static dyn Field<T>> {
    T::LINES.iter().copied().filter(move |line| line.about().of.contains(&kind))
}

/// The value of a section that says nothing, as it would be written; `None` where it is required or follows from something else.
pub fn default<T: Table>(line: &dyn Field<T>, kind: SceneKind) -> Option<Value> {
    let About { follows, said, .. } = *line.about();
    if follows || said.is_some() {
        return said.map(Value::from);
    }
    // What has a meaning beside a choice only is looked for where that is made.
    let chosen = T::LINES.iter().flat_map(|choice| choice.variants());
    let value = std::iter::once(T::usual_in(kind)).chain(chosen).find_map(|mut section| line.get(&mut section))?;
    value.is_given().then(|| value.json())
}

/// Sections by their keys, with the kinds of scene that have them, and their schemas.
pub type Inner = &'static [(&'static str, &'static [SceneKind], fn(SceneKind) -> Value)];
