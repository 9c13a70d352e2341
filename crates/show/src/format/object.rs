//! JSON objects whose keys keep their order.

use serde::{Serialize, Serializer};

/// Ordered list of named values, serialised as an object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Named<T>(pub Vec<(String, T)>);

impl<T> Named<T> {
    pub fn get(&self, name: &str) -> Option<&T> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, value)| value)
    }

    pub fn first(&self) -> Option<&T> {
        self.0.first().map(|(_, value)| value)
    }

    pub fn iter(&self) -> impl Iterator<Item = &(String, T)> {
        self.0.iter()
    }
}

impl<T> FromIterator<(String, T)> for Named<T> {
    fn from_iter<I: IntoIterator<Item = (String, T)>>(parts: I) -> Self {
        Named(parts.into_iter().collect())
    }
}

impl<T: Serialize> Serialize for Named<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

/// A JSON object that is built key by key, from values of any type.
#[derive(Default)]
pub struct Object<'a>(Vec<(&'static str, Box<dyn erased_serde::Serialize + 'a>)>);

impl<'a> Object<'a> {
    /// Appends a key.
    pub fn with(mut self, key: &'static str, value: impl Serialize + 'a) -> Self {
        self.0.push((key, Box::new(value)));
        self
    }

    /// Appends a key if it has a value.
    pub(crate) fn with_some(self, key: &'static str, value: Option<impl Serialize + 'a>) -> Self {
        match value {
            Some(value) => self.with(key, value),
            None => self,
        }
    }
}

impl Serialize for Object<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(key, value)| (key, value)))
    }
}
