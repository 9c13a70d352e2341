//! Construction of problems.

use std::ops::Range;

use crate::scene::Problem;

/// Problem at a location in the study file.
pub(super) fn problem(span: Option<Range<usize>>, message: String, label: String, help: String) -> Problem {
    Problem { span, message, label, help }
}
