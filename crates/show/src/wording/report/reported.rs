//! What has a report, and is a document of JSON besides.

use serde::Serialize;

use super::Report;

/// What a command answers: a document by its fields, and a report for people.
pub trait Reported: Serialize {
    /// For people: text, Markdown, elements of a page.
    fn report(&self) -> Report;

    /// One JSON document with a line end.
    fn json(&self) -> String {
        document(self)
    }
}

/// Anything as one JSON document with a line end.
///
/// Floats are printed in the shortest form that reads back to the same double; what is not finite becomes null.
pub fn document<T: Serialize + ?Sized>(of: &T) -> String {
    let mut text = serde_json::to_string_pretty(of).expect("a document is plain data with string keys");
    text.push('\n');
    text
}
