//! Atomic writing of result files.

use std::fmt::Display;
use std::path::Path;

use super::Failure;
use super::output::escape_unsafe_chars;
use crate::files::replace_file;

/// Page with two overlaid runs.
pub(super) const PAGE_FILE: &str = "page.html";

/// Writes a text file. Text and JSON files are escaped like printed output, because terminals may show them; pages and
/// pictures already escape untrusted names.
pub(super) fn save(path: &Path, text: &str) -> Result<(), Failure> {
    let is_text = path.extension().is_some_and(|extension| ["txt", "md", "json"].iter().any(|text| extension == *text));
    let text = if is_text { escape_unsafe_chars(text) } else { text.into() };
    replace_file(path, |out| out.write_all(text.as_bytes())).map_err(|error| write_failure(path, error))
}

/// Returns the failure of a file that cannot be written.
pub(super) fn write_failure(path: &Path, error: impl Display) -> Failure {
    Failure::incomplete(format!("cannot write {}: {error}", path.display()))
}
