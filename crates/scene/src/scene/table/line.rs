//! One line of the table.

use serde_json::Value;
use toml::Spanned;

use super::held::{Held, Written};
use super::section::{About, Field, Said, Section, Table};
use crate::scene::any::Any;
use crate::scene::check::{ANY, Bound};
use crate::scene::error::Problem;
use crate::scene::words::{self as kinds, SceneKind};

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

impl<T, K: Held> Line<T, K> {
    /// A key that may be left out, what it is for, and where it stands.
    pub const fn new(key: &'static str, doc: &'static str, place: fn(&mut T) -> Option<&mut K::Value>) -> Self {
        let (beside, needed, said, column) = (None, None, None, None);
        let about = About { key, doc, allowed: ANY, beside, needed, follows: false, said, column, of: kinds::ANY };
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

    /// The kinds of scene that have it, where that is not all.
    pub const fn of(mut self, kinds: &'static [SceneKind]) -> Self {
        self.about.of = kinds;
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
        is_within(&K::written(value), self.about.allowed)
    }
}

fn is_within(value: &Written, bound: Bound) -> bool {
    value.number().is_none_or(bound.allowed)
}

impl<T: Table, K: Held> Said for Line<T, K> {
    fn about(&self) -> &About {
        &self.about
    }

    fn kind(&self) -> Value {
        K::schema().to_value()
    }
}

impl<T: Table, K: Held> Field<T> for Line<T, K> {
    fn get(&self, section: &mut T) -> Option<Written> {
        (self.place)(section).map(|value| K::written(value))
    }

    fn variants(&self) -> Vec<Box<dyn Section>> {
        let mut found: Vec<Box<dyn Section>> = Vec::new();
        for value in K::all() {
            let mut section = T::usual();
            self.set(&mut section, value);
            found.push(Box::new(section));
        }
        found
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
