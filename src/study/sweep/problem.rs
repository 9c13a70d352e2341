//! A problem at a place of the study.

use std::ops::Range;

use crate::scene::Problem;

/// A problem at a place of the study, for other readers of its parts.
pub(super) fn problem(span: Option<Range<usize>>, message: String, label: String, help: String) -> Problem {
    Problem { span, message, label, help }
}
