//! The table of settings: every key of these sections with its kind, its default, what is allowed, and what it is for.
//!
//! A section of a scene is a struct, and each of its keys a [`Line`] that says where in the struct its value stands. From the
//! lines come the JSON Schema, the defaults, the checks with their messages, `scene show`, the log's record of a run, the flags
//! of the command line and the tables of the documentation. To add a setting is to add a field, its default and a line, in one
//! file.
//!
//! | file | job |
//! |---|---|
//! | `section` | a section as a table of lines, and what is said of each |
//! | `line` | a line, and what is done with one |
//! | `held` | kinds of values: as they are shown, recorded, and read back |
//! | `keys` | a section as it is written, and its JSON Schema |
//! | `document` | the whole table as Markdown |
//! | all others | a part of a scene each: its sections |
//!
//! A section may have other keys in scenes of one kind than in those of another: a line is `of` the kinds that have it.

pub mod bounds;
pub mod criteria;
pub mod differential;
pub mod disc;
mod document;
pub mod drive;
pub mod engine;
pub mod finger;
pub mod held;
pub mod integrator;
pub mod keys;
pub mod law;
mod line;
pub mod log;
pub mod motion;
pub mod object;
pub mod plane;
mod section;
pub mod shape;
pub mod top;

use std::borrow::Cow;

use serde_json::Value;
use toml::Spanned;

pub use document::markdown;
pub use line::Line;
pub use section::{About, Field, Inner, Said, Section, Table};

use super::any::Any;
use super::check::{ANY, Checker};
use super::error::Problem;
use super::kinds::at;
use super::show::Out;
use held::Written;
use keys::Keys;
use section::{all, chosen, lines_of};

/// Makes a struct a [`Table`]: what its section is for and is usually, then its lines: what a key is for, its name, the kind of its
/// value, where that stands in the struct, and what else is to be said of it. Behind `where` stands what is other in some kinds of
/// scene.
macro_rules! lines {
    (
        $(#[doc = $doc:literal])+
        $section:ident = $usual:expr, $s:ident $(, $inner:literal in $of:ident: $table:ty)* $(, where { $($other:tt)* })?;
        $($(#[doc = $about:literal])* $key:literal: $kind:ty = $place:expr $(, $and:ident($($with:expr),*))*;)*
    ) => {
        impl $crate::scene::table::Table for $section {
            const DOC: &'static str = concat!($($doc),+);
            const INNER: $crate::scene::table::Inner = &[$(($inner, $of, $crate::scene::table::keys::schema::<$table>)),*];
            const LINES: &'static [&'static dyn $crate::scene::table::Field<Self>] = &[$(
                &$crate::scene::table::Line::<Self, $kind>::new($key, concat!("" $(, $about)*), |$s| $place)
                    $(.$and($($with),*))*
            ),*];

            fn usual() -> Self {
                $usual
            }

            $($($other)*)?
        }
    };
}

/// The place of a field of one variant of an enum.
macro_rules! of {
    ($value:expr, $kind:ident::$variant:ident, $field:ident) => {
        match &mut $value {
            $kind::$variant { $field, .. } => Some($field),
            _ => None,
        }
    };
}

use {lines, of};

/// A section with what the scene says put in place of `base`; `path` is its own, such as `engine`, or empty for what stands before all
/// sections. What is wrong is noted.
pub fn read<T: Table>(c: &mut Checker<'_>, path: &str, raw: &Keys<'_>, mut base: T) -> T {
    fill(c, path, raw, &mut base);
    base
}

fn fill(c: &mut Checker<'_>, path: &str, raw: &Keys<'_>, base: &mut dyn Section) {
    let mut unknown: Vec<&str> = Vec::new();
    for (line, said) in lines_of(base, raw.kind) {
        let About { key, beside, needed, allowed, follows, .. } = *said.about();
        // A choice that cannot be read says nothing about the keys beside it.
        if beside.is_some_and(|(choice, _)| unknown.contains(&choice)) {
            continue;
        }
        let whole = if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
        let usual = base.get(line);
        match (raw.get(key), &usual) {
            (None, Some(base)) if !base.is_given() => {
                needed.into_iter().for_each(|help| c.lacks(&whole, raw.span.clone(), help));
            }
            (None, _) => {}
            (Some(given), None) if beside.is_some() => {
                beside.into_iter().for_each(|(_, why)| c.unused_at(&whole, Some(given.span()), why));
            }
            (Some(given), _) => match completed(&whole, given, usual.as_ref(), follows)
                .and_then(|given| base.read(line, &whole, &given))
            {
                Ok(true) => {}
                Ok(false) => c.beyond(&whole, Some(given.span()), allowed),
                Err(problems) => {
                    c.extend(problems);
                    unknown.push(key);
                }
            },
        }
    }
}

/// A value as it is given; the other element of a pair with one element set is the usual one, or one that `follows` from something else.
fn completed<'a>(
    key: &str,
    given: &'a Spanned<Any>,
    usual: Option<&Written>,
    follows: bool,
) -> Result<Cow<'a, Spanned<Any>>, Vec<Problem>> {
    let Any::List(items) = given.get_ref() else { return Ok(Cow::Borrowed(given)) };
    let mut items = items.clone();
    for (index, item) in items.iter_mut().enumerate().filter(|(_, item)| matches!(item.get_ref(), Any::Si(_))) {
        match usual {
            Some(Written::Quantities(usual, _)) if follows || usual[index].is_finite() => {
                *item.get_mut() = Any::Si(usual[index]);
            }
            _ => {
                let message = format!("one element of `{key}` is set, but nothing says the other one");
                return Err(vec![at(given, message, "one of two", format!("give the whole pair: {key} = [.., ..]"))]);
            }
        }
    }
    Ok(Cow::Owned(Spanned::new(given.span(), Any::List(items))))
}

/// Puts the text of one value into a section, together with the choice beside which alone it has a meaning. Texts are read as in
/// a scene, but need no quotes. Whether it is within bounds; if not, nothing is put there.
///
/// # Errors
/// Why it is no such value.
pub fn set<T: Table>(section: &mut T, path: &str, key: &str, text: &str) -> Result<bool, String> {
    put(section, path, key, text)
}

fn put(section: &mut dyn Section, path: &str, key: &str, text: &str) -> Result<bool, String> {
    let lines = all(section);
    let find = |key: &str| lines.iter().find(|(_, said)| said.about().key == key).copied();
    let (line, said) = find(key).ok_or_else(|| format!("[{path}] has no `{key}`"))?;
    let About { beside, .. } = *said.about();
    if let (None, Some((choice, _))) = (section.get(line), beside.and_then(|(choice, _)| find(choice))) {
        let chosen = section.variants(choice).into_iter().find_map(|mut other| {
            other.get(line)?;
            other.get(choice)
        });
        chosen.into_iter().for_each(|word| _ = section.recall(choice, &word.record()));
    }
    let value = match (said.kind()["type"].as_str(), text.parse(), text.parse()) {
        (Some("integer" | "number"), Ok(whole), _) => Any::Integer(whole),
        (Some("number"), _, Ok(number)) => Any::Float(number),
        (Some("boolean"), ..) => text.parse().map_or_else(|_| Any::Text(text.to_string()), Any::Flag),
        _ => Any::Text(text.to_string()),
    };
    let found = section.read(line, &format!("{path}.{key}"), &Spanned::new(0..text.len(), value));
    found.map_err(|problems| problems.into_iter().map(|problem| problem.message).collect::<Vec<_>>().join("; "))
}

/// Writes a section with everything it has.
pub fn show<T: Table>(out: &mut Out, path: &str, section: &T) {
    out.section(path);
    show_keys(out, section, |_| true);
}

/// Writes the keys that are wanted of a section, as far as they have a value.
pub fn show_keys<T: Table>(out: &mut Out, section: &T, wanted: impl Fn(&str) -> bool) {
    for (about, value) in values(&mut section.clone()) {
        if about.of.contains(&out.kind) && wanted(about.key) && value.is_given() {
            value.show(out, about.key);
        }
    }
}

/// What a log keeps of a section: keys with their units, and values that read back to the same bits.
pub fn record<T: Table>(path: &str, section: &T) -> Vec<(String, String)> {
    let values = values(&mut section.clone()).into_iter();
    values.map(|(about, value)| (column(path, about, &value), value.record())).collect()
}

/// The section that a log has kept; `entry` gives what is recorded under a name.
///
/// # Errors
/// That of `entry`; what `refuse` makes of a name, a value that the section cannot have, and what is allowed.
pub fn recall<T: Table, E>(
    path: &str,
    mut entry: impl FnMut(&str) -> Result<String, E>,
    refuse: impl Fn(String, String, String) -> E,
) -> Result<T, E> {
    let mut section = T::usual();
    for (line, said) in all(&section) {
        let Some(usual) = Section::get(&mut section, line) else { continue };
        let name = column(path, said.about(), &usual);
        let value = entry(&name)?;
        if !Section::recall(&mut section, line, &value) {
            return Err(refuse(name, value, range(said)));
        }
    }
    Ok(section)
}

/// All values that a section has.
fn values(section: &mut dyn Section) -> Vec<(&'static About, Written)> {
    all(section).into_iter().filter_map(|(line, said)| Some((said.about(), section.get(line)?))).collect()
}

/// Every key of a section under its name in records, and its value as far as it has one.
pub fn columns<T: Table>(section: &T) -> Vec<(String, Option<Written>)> {
    named(&mut section.clone())
}

fn named(section: &mut dyn Section) -> Vec<(String, Option<Written>)> {
    let lines = all(section);
    let column = |(line, said): (usize, &'static dyn Said)| {
        let value = section.get(line);
        // The unit of what has a meaning beside a choice only is that which it has there.
        let unit = value.clone().or_else(|| chosen(section, line))?;
        Some((name(said.about(), &unit), value))
    };
    lines.into_iter().filter_map(column).collect()
}

/// The name of a value in records of several sections.
fn column(path: &str, about: &About, value: &Written) -> String {
    format!("{path}_{}", name(about, value))
}

/// The name of a value: with its unit in SI.
fn name(about: &About, value: &Written) -> String {
    match (about.column, value.suffix()) {
        (Some(name), _) => name.to_string(),
        (None, Some(unit)) => format!("{}_{unit}", about.key),
        (None, None) => about.key.to_string(),
    }
}

/// Which values are allowed, in words.
fn range(said: &dyn Said) -> String {
    let kind = said.kind();
    match (kind["enum"].as_array(), kind["type"].as_str(), &kind["maximum"]) {
        (Some(words), ..) => words.iter().map(Value::to_string).collect::<Vec<_>>().join(" or "),
        (_, Some("integer"), Value::Null) => "a whole number from 1".to_string(),
        (_, Some("integer"), most) => format!("a whole number from 1 to {most}"),
        (_, Some("boolean"), _) => "true or false".to_string(),
        _ if kind.get("minLength").is_some() => "a text".to_string(),
        _ if said.about().allowed.text == ANY.text => ANY.text.to_string(),
        _ => format!("a number {}", said.about().allowed.text),
    }
}
