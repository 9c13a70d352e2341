//! What gives way where one part of a scene goes over another: a scene over the one it extends, one finger over what both have.

/// Keys that say what kind of thing a section is: with another kind its other keys have no meaning.
pub const KINDS: [&str; 2] = ["type", "profile"];
/// Sections, and keys of one section, that say the same thing in two ways.
const EITHER: [[&str; 2]; 3] = [["design", "lengths"], ["l21", "l21_fraction"], ["time", "acceleration"]];

/// What gives way to a table that says the same thing in another way; `has`: whether that table has a key.
pub fn replaced(has: impl Fn(&str) -> bool) -> impl Iterator<Item = &'static str> {
    let either = EITHER.into_iter().flat_map(|[one, other]| [(one, other), (other, one)]);
    either.filter(move |(one, other)| has(one) && !has(other)).map(|(_, other)| other)
}
