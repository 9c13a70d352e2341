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

use serde_json::Value;
use toml::Spanned;

pub use document::markdown;
pub use line::Line;
pub use section::{About, Field, Inner, Table, default, lines_of};

use super::any::Any;
use super::check::{ANY, Checker};
use super::show::Out;
use held::Written;
use keys::Keys;

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
    let mut unknown: Vec<&str> = Vec::new();
    for line in lines_of::<T>(raw.kind) {
        let About { key, beside, needed, allowed, .. } = *line.about();
        // A choice that cannot be read says nothing about the keys beside it.
        if beside.is_some_and(|(choice, _)| unknown.contains(&choice)) {
            continue;
        }
        let whole = if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
        match (raw.get(key), line.get(&mut base)) {
            (None, Some(base)) if !base.is_given() => {
                needed.into_iter().for_each(|help| c.lacks(&whole, raw.span.clone(), help));
            }
            (None, _) => {}
            (Some(given), None) if beside.is_some() => {
                beside.into_iter().for_each(|(_, why)| c.unused_at(&whole, Some(given.span()), why));
            }
            (Some(given), _) => match line.read(&whole, given, &mut base) {
                Ok(true) => {}
                Ok(false) => c.beyond(&whole, Some(given.span()), allowed),
                Err(problems) => {
                    c.extend(problems);
                    unknown.push(key);
                }
            },
        }
    }
    base
}

/// Puts the text of one value into a section, together with the choice beside which alone it has a meaning. Texts are read as in
/// a scene, but need no quotes. Whether it is within bounds; if not, nothing is put there.
///
/// # Errors
/// Why it is no such value.
pub fn set<T: Table>(section: &mut T, path: &str, key: &str, text: &str) -> Result<bool, String> {
    let find = |key: &str| T::LINES.iter().find(|line| line.about().key == key).copied();
    let line = find(key).ok_or_else(|| format!("[{path}] has no `{key}`"))?;
    let About { beside, .. } = *line.about();
    if let (None, Some(choice)) = (line.get(section), beside.and_then(|(choice, _)| find(choice))) {
        let chosen = choice.variants().into_iter().find(|other| line.get(&mut other.clone()).is_some());
        let word = chosen.and_then(|mut other| choice.get(&mut other));
        word.into_iter().for_each(|word| _ = choice.recall(&word.record(), section));
    }
    let value = match (line.kind()["type"].as_str(), text.parse(), text.parse()) {
        (Some("integer" | "number"), Ok(whole), _) => Any::Integer(whole),
        (Some("number"), _, Ok(number)) => Any::Float(number),
        (Some("boolean"), ..) => text.parse().map_or_else(|_| Any::Text(text.to_string()), Any::Flag),
        _ => Any::Text(text.to_string()),
    };
    let found = line.read(&format!("{path}.{key}"), &Spanned::new(0..text.len(), value), section);
    found.map_err(|problems| problems.into_iter().map(|problem| problem.message).collect::<Vec<_>>().join("; "))
}

/// Writes a section with everything it has.
pub fn show<T: Table>(out: &mut Out, path: &str, section: &T) {
    out.section(path);
    show_keys(out, section, |_| true);
}

/// Writes the keys that are wanted of a section, as far as they have a value.
pub fn show_keys<T: Table>(out: &mut Out, section: &T, wanted: impl Fn(&str) -> bool) {
    let of = |about: &About| about.of.contains(&out.kind) && wanted(about.key);
    let shown: Vec<_> = values(section).filter(|(about, value)| of(about) && value.is_given()).collect();
    shown.into_iter().for_each(|(about, value)| value.show(out, about.key));
}

/// What a log keeps of a section: keys with their units, and values that read back to the same bits.
pub fn record<T: Table>(path: &str, section: &T) -> Vec<(String, String)> {
    values(section).map(|(about, value)| (column(path, about, &value), value.record())).collect()
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
    for line in T::LINES {
        let Some(usual) = line.get(&mut section) else { continue };
        let name = column(path, line.about(), &usual);
        let value = entry(&name)?;
        if !line.recall(&value, &mut section) {
            return Err(refuse(name, value, range(*line)));
        }
    }
    Ok(section)
}

/// All values that a section has.
fn values<T: Table>(section: &T) -> impl Iterator<Item = (&'static About, Written)> {
    let mut section = section.clone();
    T::LINES.iter().filter_map(move |line| Some((line.about(), line.get(&mut section)?)))
}

/// Every key of a section under its name in records, and its value as far as it has one.
pub fn columns<T: Table>(section: &T) -> Vec<(String, Option<Written>)> {
    let mut section = section.clone();
    let mut chosen: Vec<T> = T::LINES.iter().flat_map(|choice| choice.variants()).collect();
    let column = |line: &&'static dyn Field<T>| {
        let value = line.get(&mut section);
        // The unit of what has a meaning beside a choice only is that which it has there.
        let unit = value.clone().or_else(|| chosen.iter_mut().find_map(|section| line.get(section)))?;
        Some((name(line.about(), &unit), value))
    };
    T::LINES.iter().filter_map(column).collect()
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
pub fn range<T>(line: &dyn Field<T>) -> String {
    let kind = line.kind();
    match (kind["enum"].as_array(), kind["type"].as_str(), &kind["maximum"]) {
        (Some(words), ..) => words.iter().map(Value::to_string).collect::<Vec<_>>().join(" or "),
        (_, Some("integer"), Value::Null) => "a whole number from 1".to_string(),
        (_, Some("integer"), most) => format!("a whole number from 1 to {most}"),
        (_, Some("boolean"), _) => "true or false".to_string(),
        _ if kind.get("minLength").is_some() => "a text".to_string(),
        _ if line.about().allowed.text == ANY.text => ANY.text.to_string(),
        _ => format!("a number {}", line.about().allowed.text),
    }
}
