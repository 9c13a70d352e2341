//! Reads the values of a scene and collects all problems.

use std::ops::Range;

use super::entry::{Entry, Section};
use super::error::Problem;
use super::value_kinds::InputKind;

/// A range of allowed numbers.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    pub allowed: fn(f64) -> bool,
    pub text: &'static str,
}

/// An endpoint of an allowed range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Endpoint {
    Unbounded,
    Inclusive(f64),
    /// All numbers up to this one, excluding it.
    Exclusive(f64),
}

impl Bound {
    /// Lower and upper endpoint of the range, which must be an interval that contains 0.1 or 1.5.
    pub fn endpoints(&self) -> [Endpoint; 2] {
        let inside = [0.1, 1.5].into_iter().find(|x| (self.allowed)(*x)).unwrap_or(0.1);
        [-1.0, 1.0].map(|direction| self.endpoint(inside, direction))
    }

    /// Endpoint in one direction from an allowed number: the last allowed number, or the first one that is not allowed
    /// if it has fewer digits.
    fn endpoint(&self, inside: f64, direction: f64) -> Endpoint {
        if (self.allowed)(direction * f64::MAX) {
            return Endpoint::Unbounded;
        }
        // Bisection over the ordinals of all doubles takes 64 steps to find two neighbours; over the values it would
        // take a thousand.
        let (mut low, mut high) = (to_ordinal(inside), to_ordinal(direction * f64::MAX));
        while low.abs_diff(high) > 1 {
            let middle = low.midpoint(high);
            if (self.allowed)(from_ordinal(middle)) { low = middle } else { high = middle }
        }
        let (within, beyond) = (from_ordinal(low), from_ordinal(high));
        let digits = |x: f64| if x.abs() < f64::MIN_POSITIVE { 0 } else { format!("{x:e}").len() };
        match digits(beyond) < digits(within) {
            true if beyond.abs() < f64::MIN_POSITIVE => Endpoint::Exclusive(0.0),
            true => Endpoint::Exclusive(beyond),
            false if within.abs() < f64::MIN_POSITIVE && !(self.allowed)(0.0) => Endpoint::Exclusive(0.0),
            false if within.abs() < f64::MIN_POSITIVE => Endpoint::Inclusive(0.0),
            false => Endpoint::Inclusive(within),
        }
    }
}

/// Ordinal of a double among all doubles; −0 and 0 are neighbours.
fn to_ordinal(x: f64) -> i64 {
    let bits = x.to_bits() as i64;
    if bits < 0 { i64::MIN - bits } else { bits }
}

/// Inverse of [`to_ordinal`].
fn from_ordinal(ordinal: i64) -> f64 {
    f64::from_bits(if ordinal < 0 { i64::MIN - ordinal } else { ordinal } as u64)
}

pub const ANY: Bound = Bound { allowed: |_| true, text: "any finite number" };
pub const POSITIVE: Bound = Bound { allowed: |x| x > 0.0, text: "above 0" };
pub const NOT_NEGATIVE: Bound = Bound { allowed: |x| x >= 0.0, text: "at least 0" };

/// Label of keys that have no effect because of other keys.
pub const NO_EFFECT: &str = "no effect";

/// Reads values and collects problems.
pub struct Checker<'a> {
    pub text: &'a str,
    problems: Vec<Problem>,
    /// Whether there are unknown keys. Missing keys are not reported then: they may be mistyped only.
    has_type_errors: bool,
}

impl<'a> Checker<'a> {
    /// Creates a checker of `text` with the problems found so far.
    pub fn new(text: &'a str, problems: Vec<Problem>) -> Self {
        let has_type_errors = !problems.is_empty();
        Checker { text, problems, has_type_errors }
    }

    /// Creates a checker of the same text, without problems, whose problems can be discarded.
    pub fn for_trial(&self) -> Self {
        Checker { text: self.text, problems: Vec::new(), has_type_errors: self.has_type_errors }
    }

    /// Number of problems.
    pub fn count(&self) -> usize {
        self.problems.len()
    }

    pub fn is_clean(&self) -> bool {
        self.problems.is_empty()
    }

    /// Returns all problems in the order of the file, without duplicates.
    pub fn into_problems(mut self) -> Vec<Problem> {
        self.problems.sort_by_key(|p| p.span.as_ref().map_or((usize::MAX, 0), |s| (s.start, s.end)));
        // Duplicates without a position need not be adjacent.
        let mut all: Vec<Problem> = Vec::with_capacity(self.problems.len());
        for problem in self.problems {
            if !all.contains(&problem) {
                all.push(problem);
            }
        }
        all
    }

    /// Appends a text to the messages of all problems with this label.
    pub fn append_to_messages(&mut self, label: &str, more: &str) {
        let matching = self.problems.iter_mut().filter(|problem| problem.label == label);
        matching.for_each(|problem| problem.message.push_str(more));
    }

    pub fn push(
        &mut self,
        span: Option<Range<usize>>,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.problems.push(Problem { span, message: message.into(), label: label.into(), help: help.into() });
    }

    pub fn extend(&mut self, problems: Vec<Problem>) {
        self.problems.extend(problems);
    }

    /// Returns the value of a key; `None` if it is omitted or invalid. Reports an invalid value.
    pub fn get<K: InputKind>(&mut self, key: &str, entry: &Entry<K>) -> Option<K::Value> {
        let value = entry.value.as_ref()?;
        K::read(key, value).map_err(|more| self.problems.extend(more)).ok()
    }

    /// Returns the value of a key, or its default.
    pub fn get_or<K: InputKind>(&mut self, key: &str, entry: &Entry<K>, default: K::Value) -> K::Value {
        self.get(key, entry).unwrap_or(default)
    }

    /// Reports a number out of range.
    pub fn report_out_of_range(&mut self, key: &str, span: Option<Range<usize>>, bound: Bound) {
        let message = format!("`{key}` is {}, but must be {}", self.quoted(span.clone()), bound.text);
        self.push(span, message, "not allowed", format!("allowed values: {}", bound.text));
    }

    /// Reports a missing key of a section.
    pub fn report_missing<T>(&mut self, key: &str, section: &Section<T>, help: &str) {
        self.report_missing_at(key, section.span.clone(), help);
    }

    /// Reports a missing key of the section at a position; without position if the section is missing.
    pub fn report_missing_at(&mut self, key: &str, section: Option<Range<usize>>, help: &str) {
        if self.has_type_errors {
            return;
        }
        let key = if key.starts_with('[') { key.to_string() } else { format!("`{key}`") };
        let label = if section.is_some() { "in this section" } else { "" };
        self.push(section, format!("{key} is missing"), label, help);
    }

    /// Reports that a key has no effect, for the given reason.
    pub fn report_unused<K>(&mut self, key: &str, entry: &Entry<K>, reason: &str) {
        self.report_unused_at(key, entry.span(), reason);
    }

    /// Reports that the key at a position has no effect, for the given reason.
    pub fn report_unused_at(&mut self, key: &str, span: Option<Range<usize>>, reason: &str) {
        if span.is_some() {
            let message = format!("`{key}` has no effect {reason}");
            self.push(span, message, NO_EFFECT, "remove it, or change what it depends on");
        }
    }

    /// Text at a position of the file, without quotes.
    fn quoted(&self, span: Option<Range<usize>>) -> &'a str {
        span.and_then(|s| self.text.get(s)).unwrap_or("this").trim_matches(['"', '\''])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endpoints_are_found_from_the_predicate() {
        use std::f64::consts::PI;
        let bound = |allowed| Bound { allowed, text: "" };
        for (found, endpoints) in [
            (ANY, [Endpoint::Unbounded, Endpoint::Unbounded]),
            (POSITIVE, [Endpoint::Exclusive(0.0), Endpoint::Unbounded]),
            (NOT_NEGATIVE, [Endpoint::Inclusive(0.0), Endpoint::Unbounded]),
            (bound(|x| (0.0..=1.0).contains(&x)), [Endpoint::Inclusive(0.0), Endpoint::Inclusive(1.0)]),
            (bound(|x| x > 0.0 && x < PI), [Endpoint::Exclusive(0.0), Endpoint::Exclusive(PI)]),
            (bound(|x| x > -1.0 && x <= 0.5), [Endpoint::Exclusive(-1.0), Endpoint::Inclusive(0.5)]),
            (bound(|x| x >= 1.0), [Endpoint::Inclusive(1.0), Endpoint::Unbounded]),
        ] {
            assert_eq!(found.endpoints(), endpoints);
        }
    }
}
