//! The figures of the thesis, with what a right implementation finds (2-design §2.6) and why the two differ.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use serde::Deserialize;

/// One figure, in SI. Its key ends in the unit of its value, or has it before the first `.base`, `.mu` or `.all`.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    pub key: String,
    pub section: String,
    /// Table, figure, section or equation of the thesis.
    pub source: String,
    pub what: String,
    /// The thesis's unit.
    pub unit: &'static str,
    /// Value in the thesis's unit per SI value.
    pub scale: f64,
    /// As printed, in its unit: also tells how many digits.
    pub printed: String,
    /// Decimals in which the value is shown: those of the thesis or of what is expected, whichever has more.
    pub decimals: usize,
    pub thesis: Option<f64>,
    pub expected: Option<f64>,
    /// How far from the expected value is right.
    pub within: f64,
    /// Key of a [`Reason`]; empty where thesis and expectation agree.
    pub reason: String,
}

/// Why a figure differs.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Reason {
    pub errata: Vec<u32>,
    pub text: String,
}

/// Units of the file with their factor to SI and the suffix of their keys.
pub const UNITS: [(&str, f64, &str); 8] = [
    ("", 1.0, ""),
    ("%", 1.0, "_percent"),
    ("N·mm", 1e3, "_n_m"),
    ("mm", 1e3, "_m"),
    ("g", 1e3, "_kg"),
    ("ms", 1e3, "_s"),
    ("N", 1.0, "_n"),
    ("°", 180.0 / std::f64::consts::PI, "_rad"),
];

const FIGURES: &str = include_str!("thesis.csv");
const REASONS: &str = include_str!("reasons.toml");

#[derive(Deserialize)]
struct Line {
    key: String,
    section: String,
    source: String,
    what: String,
    unit: String,
    thesis: String,
    expected: String,
    within: Option<f64>,
    reason: String,
}

/// All figures, in the order of the file.
pub fn figures() -> &'static [Figure] {
    static READ: OnceLock<Vec<Figure>> = OnceLock::new();
    READ.get_or_init(|| {
        let mut reader = csv::Reader::from_reader(FIGURES.as_bytes());
        let lines =
            reader.deserialize().map(|line: Result<Line, csv::Error>| line.expect("the file is part of the program"));
        lines.map(figure).collect()
    })
}

/// Reasons by key.
pub fn reasons() -> &'static BTreeMap<String, Reason> {
    static READ: OnceLock<BTreeMap<String, Reason>> = OnceLock::new();
    READ.get_or_init(|| toml::from_str(REASONS).expect("the file is part of the program"))
}

fn figure(line: Line) -> Figure {
    let (unit, scale, _) = *UNITS.iter().find(|(unit, ..)| *unit == line.unit).expect("a unit of the list");
    let number = |text: &str| (!text.is_empty()).then(|| text.parse::<f64>().expect("a number") / scale);
    let decimals = |text: &str| text.split_once('.').map_or(0, |(_, fraction)| fraction.len());
    Figure {
        thesis: number(&line.thesis),
        expected: number(&line.expected),
        decimals: decimals(&line.thesis).max(decimals(&line.expected)),
        within: line.within.unwrap_or(0.0) / scale,
        printed: line.thesis,
        key: line.key,
        section: line.section,
        source: line.source,
        what: line.what,
        unit,
        scale,
        reason: line.reason,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_differ_and_carry_their_units_and_every_difference_has_a_reason() {
        let figures = figures();
        assert!(figures.len() > 80);
        for (index, figure) in figures.iter().enumerate() {
            let key = &figure.key;
            assert!(figures[..index].iter().all(|other| other.key != *key), "{key} is there twice");
            let (.., suffix) = UNITS.iter().find(|(unit, ..)| *unit == figure.unit).expect("a unit");
            let quantity =
                [".base_", ".all", ".mu_"].iter().fold(key.as_str(), |key, end| key.split(end).next().unwrap_or(key));
            assert!(quantity.ends_with(suffix), "{key} is in {}", figure.unit);
            assert!(figure.expected.is_some() || figure.within == 0.0, "{key} has a width about nothing");
            assert!(figure.reason.is_empty() || reasons().contains_key(&figure.reason), "{key}: {}", figure.reason);
            // What is right and what is printed may only differ for a reason.
            if let (Some(thesis), Some(expected)) = (figure.thesis, figure.expected) {
                let decimals = figure.printed.split_once('.').map_or(0, |(_, fraction)| fraction.len() as i32);
                let rounding = 0.5 * 10f64.powi(-decimals) / figure.scale * (1.0 + 1e-9);
                let agree = (thesis - expected).abs() <= rounding.max(figure.within);
                assert!(agree || !figure.reason.is_empty(), "{key} has no reason");
            }
        }
        let used = |key: &String| figures.iter().any(|figure| figure.reason == *key);
        assert!(reasons().keys().all(used), "a reason that nothing needs");
    }
}
