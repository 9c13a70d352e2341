//! The trait of results with a report and a JSON document.

use serde::Serialize;

use super::Report;

/// Result of a command: serialises to a JSON document and formats as a report for people.
pub trait ToReport: Serialize {
    /// Returns the report, which can be rendered as text, Markdown or HTML.
    fn report(&self) -> Report;

    /// Returns the JSON document with a final line end.
    fn json(&self) -> String {
        to_json_document(self)
    }
}

/// Serialises a value as a JSON document with a final line end.
///
/// Floats are printed in the shortest form that reads back to the same double; numbers that are not finite become null.
pub fn to_json_document<T: Serialize + ?Sized>(value: &T) -> String {
    let mut text = serde_json::to_string_pretty(value).expect("a document is plain data with string keys");
    text.push('\n');
    text
}
