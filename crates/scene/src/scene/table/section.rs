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

/// What is known of a line without a section that has it.
pub trait Said: Sync {
    fn about(&self) -> &About;

    /// JSON Schema of its kind of value.
    fn kind(&self) -> Value;
}

/// A line, whatever kind of value it holds.
pub trait Field<T>: Said {
    /// The value, if the section has it.
    fn get(&self, section: &mut T) -> Option<Written>;

    /// Sections in which a choice has each of its values; none of what is no choice.
    fn variants(&self) -> Vec<Box<dyn Section>>;

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

/// A section, whichever it is, with its lines by their numbers: what is done with it is compiled once, not for every section there is.
pub trait Section {
    fn line(&self, line: usize) -> Option<&'static dyn Said>;

    /// As [`Field::get`].
    fn get(&mut self, line: usize) -> Option<Written>;

    /// As [`Field::variants`].
    fn variants(&self, line: usize) -> Vec<Box<dyn Section>>;

    /// As [`Field::read`].
    ///
    /// # Errors
    /// Why it is no such value.
    fn read(&mut self, line: usize, key: &str, given: &Spanned<Any>) -> Result<bool, Vec<Problem>>;

    /// As [`Field::recall`].
    fn recall(&mut self, line: usize, text: &str) -> bool;
}

impl<T: Table> Section for T {
    fn line(&self, line: usize) -> Option<&'static dyn Said> {
        T::LINES.get(line).map(|line| *line as &'static dyn Said)
    }

    fn get(&mut self, line: usize) -> Option<Written> {
        T::LINES[line].get(self)
    }

    fn variants(&self, line: usize) -> Vec<Box<dyn Section>> {
        T::LINES[line].variants()
    }

    fn read(&mut self, line: usize, key: &str, given: &Spanned<Any>) -> Result<bool, Vec<Problem>> {
        T::LINES[line].read(key, given, self)
    }

    fn recall(&mut self, line: usize, text: &str) -> bool {
        T::LINES[line].recall(text, self)
    }
}

/// All lines of a section, with their numbers.
pub fn all(section: &dyn Section) -> Vec<(usize, &'static dyn Said)> {
    (0..).map_while(|line| Some((line, section.line(line)?))).collect()
}

/// Those in scenes of a kind.
pub fn lines_of(section: &dyn Section, kind: SceneKind) -> Vec<(usize, &'static dyn Said)> {
    all(section).into_iter().filter(|(_, said)| said.about().of.contains(&kind)).collect()
}

/// The first value of a line in sections where each choice is made: what has a meaning beside one only is found there.
pub fn chosen(section: &dyn Section, line: usize) -> Option<Written> {
    let mut chosen = all(section).into_iter().flat_map(|(choice, _)| section.variants(choice));
    chosen.find_map(|mut section| section.get(line))
}

/// The value of a section that says nothing, `usual` in scenes of its kind, as it would be written; `None` where it is required or follows
/// from something else.
pub fn default(usual: &mut dyn Section, (line, said): (usize, &dyn Said)) -> Option<Value> {
    let About { follows, said, .. } = *said.about();
    if follows || said.is_some() {
        return said.map(Value::from);
    }
    let value = usual.get(line).or_else(|| chosen(usual, line))?;
    value.is_given().then(|| value.json())
}

/// Sections by their keys, with the kinds of scene that have them, and their schemas.
pub type Inner = &'static [(&'static str, &'static [SceneKind], fn(SceneKind) -> Value)];
