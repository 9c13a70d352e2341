//! A scene file as it is written, whatever sections it has, to be read part by part.
//!
//! Of two fingers the sections of a finger are those of both; `[right]` and `[left]` have the same ones for that finger alone, over the
//! common ones.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer};

use super::Side;
use super::any::Any;
use super::keys::element;
use super::over::{KINDS, replaced};
use super::sections::OF_FINGER;
use super::table::keys::{Given, Keys};
use super::words::SceneKind;

/// A scene without unknown keys.
#[derive(Debug)]
pub struct Raw {
    pub kind: SceneKind,
    given: Given,
    /// What is said of each of two fingers.
    fingers: Vec<Given>,
    /// Where the names of discs stand.
    names: BTreeMap<String, Range<usize>>,
}

impl Raw {
    /// # Errors
    /// That of the deserialisation.
    pub fn of(kind: SceneKind, document: Spanned<DeTable<'_>>) -> Result<Self, toml::de::Error> {
        let names = match document.get_ref().get("discs").map(Spanned::get_ref) {
            Some(DeValue::Table(discs)) => discs.keys().map(|name| (name.get_ref().to_string(), name.span())).collect(),
            _ => BTreeMap::new(),
        };
        let mut given = Given::deserialize(Deserializer::from(document))?;
        put_elements(&mut given);
        let mut raw = Self { kind, given, fingers: Vec::new(), names };
        if raw.sides().len() > 1 {
            raw.fingers = Side::BOTH.map(|side| finger(&raw.given, side)).into();
        }
        Ok(raw)
    }

    /// The sides of its fingers; one that is alone is a right one.
    pub fn sides(&self) -> &'static [Side] {
        &Side::BOTH[..self.kind.fingers()]
    }

    /// Everything but what is said of single fingers.
    pub fn whole(&self) -> Keys<'_> {
        Keys::whole(self.kind, &self.given)
    }

    /// What is said of a finger: as the scene of it alone would say it.
    pub fn finger(&self, side: Side) -> Keys<'_> {
        Keys::whole(self.kind, self.fingers.get(side as usize).unwrap_or(&self.given))
    }

    /// Where the name of a disc stands.
    pub fn name_span(&self, name: &str) -> Option<Range<usize>> {
        self.names.get(name).cloned()
    }
}

/// Puts elements that are set by themselves, such as `centre[0]`, into their pairs; the other element is not a number where no pair is given.
fn put_elements(given: &mut Given) {
    let is_element =
        |(key, value): &(&String, &Spanned<Any>)| element(key).is_some() && !matches!(value.get_ref(), Any::Table(_));
    let elements: Vec<String> = given.iter().filter(is_element).map(|(key, _)| key.clone()).collect();
    for key in elements {
        let (Some((pair, index)), Some(value)) = (element(&key), given.remove(&key)) else { continue };
        let other = Spanned::new(value.span(), Any::Si(f64::NAN));
        let none = || Spanned::new(value.span(), Any::List(vec![other; 2]));
        if let Any::List(items) = given.entry(pair.to_string()).or_insert_with(none).get_mut() {
            items.get_mut(index as usize).into_iter().for_each(|item| item.clone_from(&value));
        }
    }
    for value in given.values_mut() {
        if let Any::Table(inner) = value.get_mut() {
            put_elements(inner);
        }
    }
}

fn finger(given: &Given, side: Side) -> Given {
    let common = OF_FINGER.into_iter().filter_map(|key| given.get_key_value(key));
    let mut whole: Given = common.map(|(key, value)| (key.clone(), value.clone())).collect();
    if let Some(Any::Table(own)) = given.get(side.word()).map(Spanned::get_ref) {
        merge(&mut whole, own);
    }
    whole
}

/// Puts one table over another as a scene that extends one does, and takes out what only one of both can say.
fn merge(whole: &mut Given, over: &Given) {
    replaced(|key| over.contains_key(key)).for_each(|key| _ = whole.remove(key));
    for (key, value) in over {
        let (mut value, before) = (value.clone(), whole.remove(key).map(Spanned::into_inner));
        if let (Any::Table(more), Some(Any::Table(mut inner))) = (value.get_mut(), before)
            && !KINDS.iter().any(|kind| more.contains_key(*kind))
        {
            merge(&mut inner, more);
            *more = inner;
        }
        whole.insert(key.clone(), value);
    }
}
