//! Files of results: whole or not at all.

use std::fmt::Display;
use std::path::Path;

use super::Failure;
use super::output::visible;
use crate::files::replace;

/// Both models in motion, laid over each other.
pub(super) const PAGE: &str = "page.html";

/// Writes a text. Those for people are shown in terminals, and are as they would be printed; pages and pictures escape by themselves.
pub(super) fn save(path: &Path, text: &str) -> Result<(), Failure> {
    let plain = path.extension().is_some_and(|ending| ["txt", "md", "json"].iter().any(|plain| ending == *plain));
    let text = if plain { visible(text) } else { text.into() };
    replace(path, |out| out.write_all(text.as_bytes())).map_err(|error| broken(path, error))
}

pub(super) fn broken(path: &Path, error: impl Display) -> Failure {
    Failure::incomplete(format!("cannot write {}: {error}", path.display()))
}
