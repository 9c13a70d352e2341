//! One line of the table.

use serde_json::Value;
use toml::Spanned;

use super::Table;
use super::held::{Held, Written};
use crate::scene::check::{ANY, Bound};
use crate::scene::entry::Any;
use crate::scene::error::Problem;

/// Puts a text that few keys have into what is said of this one.
macro_rules! said {
    ($($what:ident)*) => {$(
        pub const fn $what(mut self, text: &'static str) -> Self {
            self.about.$what = Some(text);
            self
        }
    )*};
}

/// A key of the section `T`, which holds a value of kind `K`.
pub struct Line<T, K: Held> {
    about: About,
    /// Where the value stands; nowhere where the section is of another kind.
    place: fn(&mut T) -> Option<&mut K::Value>,
    /// How the value is put there, if more follows from it.
    put: Option<fn(&mut T, K::Value)>,
}

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

impl<T, K: Held> Line<T, K> {
    /// A key that may be left out, what it is for, and where it stands.
    pub const fn new(key: &'static str, doc: &'static str, place: fn(&mut T) -> Option<&mut K::Value>) -> Self {
        let (beside, needed, said, column) = (None, None, None, None);
        let about = About { key, doc, allowed: ANY, beside, needed, follows: false, said, column };
        Line { about, place, put: None }
    }

    pub const fn put(mut self, put: fn(&mut T, K::Value)) -> Self {
        self.put = Some(put);
        self
    }

    pub const fn allowed(mut self, bound: Bound) -> Self {
        self.about.allowed = bound;
        self
    }

    pub const fn follows(mut self) -> Self {
        self.about.follows = true;
        self
    }

    pub const fn beside(mut self, choice: &'static str, why: &'static str) -> Self {
        self.about.beside = Some((choice, why));
        self
    }

    said!(needed said column);

    fn set(&self, section: &mut T, value: K::Value) {
        match (self.put, (self.place)(section)) {
            (Some(put), _) => put(section, value),
            (None, Some(place)) => *place = value,
            (None, None) => {}
        }
    }

    fn fits(&self, value: &K::Value) -> bool {
        K::written(value).number().is_none_or(self.about.allowed.allowed)
    }
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

impl<T: Table, K: Held> Field<T> for Line<T, K> {
    fn about(&self) -> &About {
        &self.about
    }

    fn kind(&self) -> Value {
        K::schema().to_value()
    }

    fn get(&self, section: &mut T) -> Option<Written> {
        (self.place)(section).map(|value| K::written(value))
    }

    fn variants(&self) -> Vec<T> {
        let with = |value| {
            let mut section = T::usual();
            self.set(&mut section, value);
            section
        };
        K::all().into_iter().map(with).collect()
    }

    fn read(&self, key: &str, given: &Spanned<Any>, into: &mut T) -> Result<bool, Vec<Problem>> {
        let value = K::read(key, given)?;
        let fits = self.fits(&value);
        if fits {
            self.set(into, value);
        }
        Ok(fits)
    }

    fn recall(&self, text: &str, into: &mut T) -> bool {
        let value = K::recall(text).filter(|value| self.fits(value));
        let known = value.is_some();
        value.into_iter().for_each(|value| self.set(into, value));
        known
    }
}
