//! Reads the values of a scene and collects all problems.

use std::cell::RefCell;
use std::ops::Range;

use toml::de::DeTable;

use super::error::Problem;
use super::parameters::Parameters;

/// Label of keys that have no effect because of other keys.
pub(crate) const NO_EFFECT: &str = "no effect";

/// Reads values and collects problems.
pub struct Checker<'a> {
    pub text: &'a str,
    /// Values of the parameters, for use in expressions.
    pub parameters: Parameters,
    problems: RefCell<Vec<Problem>>,
    /// Whether there are unknown keys. Missing keys are not reported then: they may be mistyped only.
    has_type_errors: bool,
}

impl<'a> Checker<'a> {
    /// Creates a checker of `text` with the problems found so far.
    pub fn new(text: &'a str, problems: Vec<Problem>) -> Self {
        let has_type_errors = !problems.is_empty();
        Checker { text, parameters: Parameters::default(), problems: RefCell::new(problems), has_type_errors }
    }

    /// Evaluates the parameters of a scene, and reports the problems found.
    pub fn with_parameters(self, scene: &DeTable<'_>) -> Self {
        let (parameters, problems) = Parameters::read(scene);
        self.extend(problems);
        Checker { parameters, ..self }
    }

    /// Takes back the problems after the first `count`.
    pub(crate) fn take_after(&self, count: usize) -> Vec<Problem> {
        self.problems.borrow_mut().split_off(count)
    }

    /// Number of problems.
    pub fn count(&self) -> usize {
        self.problems.borrow().len()
    }

    pub fn is_clean(&self) -> bool {
        self.problems.borrow().is_empty()
    }

    /// Returns all problems in the order of the file, without duplicates.
    pub fn into_problems(self) -> Vec<Problem> {
        let mut problems = self.problems.into_inner();
        problems.sort_by_key(|p| p.span.as_ref().map_or((usize::MAX, 0), |s| (s.start, s.end)));
        // Duplicates without a position need not be adjacent.
        let mut all: Vec<Problem> = Vec::with_capacity(problems.len());
        for problem in problems {
            if !all.contains(&problem) {
                all.push(problem);
            }
        }
        all
    }

    pub fn push(&self, problem: Problem) {
        self.problems.borrow_mut().push(problem);
    }

    pub fn extend(&self, problems: Vec<Problem>) {
        self.problems.borrow_mut().extend(problems);
    }

    /// Reports a missing key at the position of its section; without a position if the section is missing.
    pub fn report_missing_at(&self, key: &str, section: Option<Range<usize>>, help: &str) {
        if self.has_type_errors {
            return;
        }
        let key = if key.starts_with('[') { key.to_string() } else { format!("`{key}`") };
        let label = if section.is_some() { "in this section" } else { "" };
        self.push(Problem::new(section, format!("{key} is missing"), label, help));
    }

    /// Reports that the key at a position has no effect, for the given reason.
    pub fn report_unused_at(&self, key: &str, span: Option<Range<usize>>, reason: &str) {
        if span.is_some() {
            self.report_no_effect(key, span, reason, "remove it, or change what it depends on");
        }
    }

    /// Reports that the key at a position has no effect, with a remedy.
    pub(crate) fn report_no_effect(&self, key: &str, span: Option<Range<usize>>, reason: &str, help: &str) {
        self.push(Problem::new(span, format!("`{key}` has no effect {reason}"), NO_EFFECT, help));
    }

    /// Text at a position of the file, without the quotes around it.
    pub fn quoted(&self, span: Option<Range<usize>>) -> &'a str {
        span.and_then(|s| self.text.get(s)).unwrap_or("this").trim_matches(['"', '\''])
    }
}
