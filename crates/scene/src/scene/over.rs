//! What gives way where one part of a scene goes over another: a scene over the one it extends, one finger over what both have.

/// Keys that say what kind of thing a section is: with another kind its other keys have no meaning.
pub const KINDS: [&str; 2] = ["type", "profile"];
/// Sections that say the same thing in two ways.
pub const EITHER: [(&str, &str); 2] = [("design", "lengths"), ("lengths", "design")];
