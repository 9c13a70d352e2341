//! A section of a scene as a table of lines, and what is said of each.

use schemars::Schema;
use serde_json::Value;
use toml::Spanned;

use super::held::Written;
use crate::scene::any::Any;
use crate::scene::check::Bound;
use crate::scene::error::Problem;

/// What is said of a key.
#[derive(Clone, Copy, Debug)]
pub struct About {
    pub key: &'static str,
    pub doc: &'static str,
    /// Which numbers are allowed.
    pub allowed: Bound,
    /// The key that decides whether the section has a place for this one, and why there is none.
    pub beside: Option<(&'static str, &'static str)>,
    /// What to do where it is lacking, if it must be given.
    pub needed: Option<&'static str>,
    /// Its default follows from something else.
    pub follows: bool,
    /// The default as people say it, where that is not the shortest text.
    pub said: Option<&'static str>,
    /// Its name in records, where that is not the key and its unit.
    pub column: Option<&'static str>,
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
    /// Its keys in the order in which they are read and shown: a choice before what has a meaning beside it only.
    const LINES: &'static [&'static dyn Field<Self>];
    /// Sections in it, with their schemas.
    const INNER: Inner = &[];

    /// The section of a scene that does not have it; not a number where no number is usual.
    fn usual() -> Self;
}

/// The value of a section that says nothing, as it would be written; `None` where it is required or follows from something else.
pub fn default<T: Table>(line: &dyn Field<T>) -> Option<Value> {
    let About { follows, said, .. } = *line.about();
    if follows || said.is_some() {
        return said.map(Value::from);
    }
    // What has a meaning beside a choice only is looked for where that is made.
    let chosen = T::LINES.iter().flat_map(|choice| choice.variants());
    let value = std::iter::once(T::usual()).chain(chosen).find_map(|mut section| line.get(&mut section))?;
    value.is_given().then(|| value.json())
}

/// Sections by their keys, with their schemas.
pub type Inner = &'static [(&'static str, fn() -> Schema)];
