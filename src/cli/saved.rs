//! Files of results: whole or not at all.

use std::fmt::Display;
use std::path::Path;

use super::Failure;
use crate::files::replace;

/// Both models in motion, laid over each other.
pub(super) const PAGE: &str = "page.html";

pub(super) fn save(path: &Path, text: &str) -> Result<(), Failure> {
    replace(path, |out| out.write_all(text.as_bytes())).map_err(|error| broken(path, error))
}

pub(super) fn broken(path: &Path, error: impl Display) -> Failure {
    Failure::incomplete(format!("cannot write {}: {error}", path.display()))
}
