//! Reading the values of a scene one by one while every problem is collected.

use std::ops::Range;

use super::entry::{Entry, Section};
use super::error::Problem;
use super::kinds::Kind;

/// Which numbers are allowed.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    pub allowed: fn(f64) -> bool,
    pub text: &'static str,
}

/// An end of what is allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    Open,
    At(f64),
    /// All numbers up to it, and not itself.
    Before(f64),
}

impl Bound {
    /// Where what is allowed begins and ends; it is one interval, in which 0.1 is or which begins above.
    pub fn ends(&self) -> [End; 2] {
        let inside = [0.1, 1.5].into_iter().find(|x| (self.allowed)(*x)).unwrap_or(0.1);
        [-1.0, 1.0].map(|way| self.end(inside, way))
    }

    /// The end on one side of a number that is allowed: of neighbouring numbers the last, or the first that is not if it is a rounder one.
    fn end(&self, inside: f64, way: f64) -> End {
        if (self.allowed)(way * f64::MAX) {
            return End::Open;
        }
        // By the place in the order of all numbers: 64 halvings find two neighbours, and those of the values themselves would be a thousand.
        let (mut low, mut high) = (rank(inside), rank(way * f64::MAX));
        while low.abs_diff(high) > 1 {
            let middle = low.midpoint(high);
            if (self.allowed)(ranked(middle)) { low = middle } else { high = middle }
        }
        let (within, beyond) = (ranked(low), ranked(high));
        let digits = |x: f64| if x.abs() < f64::MIN_POSITIVE { 0 } else { format!("{x:e}").len() };
        match digits(beyond) < digits(within) {
            true if beyond.abs() < f64::MIN_POSITIVE => End::Before(0.0),
            true => End::Before(beyond),
            false if within.abs() < f64::MIN_POSITIVE && !(self.allowed)(0.0) => End::Before(0.0),
            false if within.abs() < f64::MIN_POSITIVE => End::At(0.0),
            false => End::At(within),
        }
    }
}

/// The place of a number among all, −0 next to 0.
fn rank(x: f64) -> i64 {
    let bits = x.to_bits() as i64;
    if bits < 0 { i64::MIN - bits } else { bits }
}

/// The number at a place.
fn ranked(place: i64) -> f64 {
    f64::from_bits(if place < 0 { i64::MIN - place } else { place } as u64)
}

pub const ANY: Bound = Bound { allowed: |_| true, text: "any finite number" };
pub const POSITIVE: Bound = Bound { allowed: |x| x > 0.0, text: "above 0" };
pub const NOT_NEGATIVE: Bound = Bound { allowed: |x| x >= 0.0, text: "at least 0" };

/// The label of keys that have no effect beside others.
pub const NO_EFFECT: &str = "no effect";

/// Collects what is wrong.
pub struct Checker<'a> {
    pub text: &'a str,
    problems: Vec<Problem>,
    /// Keys that are missing are left unsaid where unknown ones were found: they may only be mistyped.
    mistyped: bool,
}

impl<'a> Checker<'a> {
    /// A checker of `text`, of which some problems may be known already.
    pub fn new(text: &'a str, problems: Vec<Problem>) -> Self {
        let mistyped = !problems.is_empty();
        Checker { text, problems, mistyped }
    }

    /// One for the same text, for what is only tried.
    pub fn aside(&self) -> Self {
        Checker { text: self.text, problems: Vec::new(), mistyped: self.mistyped }
    }

    /// How many problems there are.
    pub fn count(&self) -> usize {
        self.problems.len()
    }

    pub fn is_clean(&self) -> bool {
        self.problems.is_empty()
    }

    /// All problems in the order of the file, each once.
    pub fn into_problems(mut self) -> Vec<Problem> {
        self.problems.sort_by_key(|p| p.span.as_ref().map_or((usize::MAX, 0), |s| (s.start, s.end)));
        // Those without a place need not stand beside each other.
        let mut all: Vec<Problem> = Vec::with_capacity(self.problems.len());
        for problem in self.problems {
            if !all.contains(&problem) {
                all.push(problem);
            }
        }
        all
    }

    /// Says more of all problems of this label.
    pub fn add_to(&mut self, label: &str, more: &str) {
        let of = self.problems.iter_mut().filter(|problem| problem.label == label);
        of.for_each(|problem| problem.message.push_str(more));
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

    /// The value of a key; `None` if it is left out or (then that is noted) wrong.
    pub fn get<K: Kind>(&mut self, key: &str, entry: &Entry<K>) -> Option<K::Value> {
        let given = entry.given.as_ref()?;
        K::read(key, given).map_err(|more| self.problems.extend(more)).ok()
    }

    /// The value of a key, or its default.
    pub fn or<K: Kind>(&mut self, key: &str, entry: &Entry<K>, default: K::Value) -> K::Value {
        self.get(key, entry).unwrap_or(default)
    }

    /// Notes that a number is not within bounds.
    pub fn beyond(&mut self, key: &str, span: Option<Range<usize>>, bound: Bound) {
        let message = format!("`{key}` is {}, but must be {}", self.quoted(span.clone()), bound.text);
        self.push(span, message, "not allowed", format!("give a value {}", bound.text));
    }

    /// Notes that a section lacks a key.
    pub fn missing<T>(&mut self, key: &str, section: &Section<T>, help: &str) {
        self.lacks(key, section.span.clone(), help);
    }

    /// The same of the section at a place; of one that is not there without.
    pub fn lacks(&mut self, key: &str, section: Option<Range<usize>>, help: &str) {
        if self.mistyped {
            return;
        }
        let key = if key.starts_with('[') { key.to_string() } else { format!("`{key}`") };
        let label = if section.is_some() { "in this section" } else { "" };
        self.push(section, format!("{key} is missing"), label, help);
    }

    /// Refuses a key that would have no effect.
    pub fn unused<K>(&mut self, key: &str, entry: &Entry<K>, why: &str) {
        self.unused_at(key, entry.span(), why);
    }

    /// Refuses a key that is given at a place, and would have no effect.
    pub fn unused_at(&mut self, key: &str, span: Option<Range<usize>>, why: &str) {
        if span.is_some() {
            let message = format!("`{key}` has no effect {why}");
            self.push(span, message, NO_EFFECT, "remove it, or change what it depends on");
        }
    }

    /// The text at a place of the file, without quotes.
    fn quoted(&self, span: Option<Range<usize>>) -> &'a str {
        span.and_then(|s| self.text.get(s)).unwrap_or("this").trim_matches(['"', '\''])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_found_from_what_is_allowed() {
        use std::f64::consts::PI;
        let bound = |allowed| Bound { allowed, text: "" };
        for (found, ends) in [
            (ANY, [End::Open, End::Open]),
            (POSITIVE, [End::Before(0.0), End::Open]),
            (NOT_NEGATIVE, [End::At(0.0), End::Open]),
            (bound(|x| (0.0..=1.0).contains(&x)), [End::At(0.0), End::At(1.0)]),
            (bound(|x| x > 0.0 && x < PI), [End::Before(0.0), End::Before(PI)]),
            (bound(|x| x > -1.0 && x <= 0.5), [End::Before(-1.0), End::At(0.5)]),
            (bound(|x| x >= 1.0), [End::At(1.0), End::Open]),
        ] {
            assert_eq!(found.ends(), ends);
        }
    }
}
