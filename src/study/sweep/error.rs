//! Errors in study files.

use std::fmt;

use crate::scene::{Problem, SceneError};

/// Error in a study file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StudyError {
    /// The file cannot be read.
    Read { file: String, reason: String },
    /// The study or its base scene is invalid.
    Invalid(SceneError),
}

impl StudyError {
    /// Problems in the text; empty if the file could not be read.
    pub fn problems(&self) -> &[Problem] {
        match self {
            StudyError::Read { .. } => &[],
            StudyError::Invalid(error) => error.problems(),
        }
    }
}

impl std::error::Error for StudyError {}

/// Formatted like an error of a scene: `error:`, location, source line and help.
impl fmt::Display for StudyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StudyError::Read { file, reason } => write!(f, "error: cannot read study `{file}`: {reason}"),
            StudyError::Invalid(error) => error.fmt(f),
        }
    }
}
