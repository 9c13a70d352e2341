//! Why there is no study.

use std::fmt;

use crate::scene::{Problem, SceneError};

/// Why a study file gives no study.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StudyError {
    /// The study cannot be read.
    Read { file: String, reason: String },
    /// The study, or the base scene it names, was read, but something in it is wrong.
    Invalid(SceneError),
}

impl StudyError {
    /// The problems found in the text; empty when it could not be read.
    pub fn problems(&self) -> &[Problem] {
        match self {
            StudyError::Read { .. } => &[],
            StudyError::Invalid(error) => error.problems(),
        }
    }
}

impl std::error::Error for StudyError {}

/// As a scene's error: with place, source line and help, and `error:` in front.
impl fmt::Display for StudyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StudyError::Read { file, reason } => write!(f, "error: cannot read study `{file}`: {reason}"),
            StudyError::Invalid(error) => error.fmt(f),
        }
    }
}
