//! Numbers of the thesis, with the values expected from a correct implementation (2-design §2.6) and the reasons for
//! differences.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use serde::Deserialize;

/// One number of the thesis, in SI units. The key contains the unit of the value, at its end or before the first
/// `.base`, `.mu` or `.all`.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    pub key: String,
    pub section: String,
    /// Table, figure, section or equation of the thesis.
    pub source: String,
    pub quantity: String,
    /// Unit in the thesis.
    pub unit: &'static str,
    /// Factor from SI to the unit in the thesis.
    pub scale: f64,
    /// Printed text, which also defines the number of digits.
    pub printed: String,
    /// Number of decimals shown: the larger one of the printed and the expected value.
    pub decimals: usize,
    pub thesis: Option<f64>,
    pub expected: Option<f64>,
    /// Allowed deviation from the expected value.
    pub tolerance: f64,
    /// Key of a [`Reason`]; empty if the printed and the expected value agree.
    pub reason: String,
}

/// Reason for a difference between the printed and the expected value.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct Reason {
    pub errata: Vec<u32>,
    pub text: String,
}

/// Units in `thesis.csv`: name, factor from SI to the unit, and suffix of the keys.
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
struct FigureRow {
    key: String,
    section: String,
    source: String,
    #[serde(rename = "what")]
    quantity: String,
    unit: String,
    thesis: String,
    expected: String,
    #[serde(rename = "within")]
    tolerance: Option<f64>,
    reason: String,
}

/// Returns all numbers, in the order of the file.
pub fn figures() -> &'static [Figure] {
    static PARSED: OnceLock<Vec<Figure>> = OnceLock::new();
    PARSED.get_or_init(|| {
        let mut reader = csv::Reader::from_reader(FIGURES.as_bytes());
        let lines =
            reader.deserialize().map(|line: Result<FigureRow, csv::Error>| line.expect("the embedded file is valid"));
        lines.map(figure).collect()
    })
}

/// Returns the reasons by key.
pub fn reasons() -> &'static BTreeMap<String, Reason> {
    static PARSED: OnceLock<BTreeMap<String, Reason>> = OnceLock::new();
    PARSED.get_or_init(|| toml::from_str(REASONS).expect("the embedded file is valid"))
}

fn figure(line: FigureRow) -> Figure {
    let (unit, scale, _) = *UNITS.iter().find(|(unit, ..)| *unit == line.unit).expect("a unit of the list");
    let number = |text: &str| (!text.is_empty()).then(|| text.parse::<f64>().expect("a number") / scale);
    let decimals = |text: &str| text.split_once('.').map_or(0, |(_, fraction)| fraction.len());
    Figure {
        thesis: number(&line.thesis),
        expected: number(&line.expected),
        decimals: decimals(&line.thesis).max(decimals(&line.expected)),
        tolerance: line.tolerance.unwrap_or(0.0) / scale,
        printed: line.thesis,
        key: line.key,
        section: line.section,
        source: line.source,
        quantity: line.quantity,
        unit,
        scale,
        reason: line.reason,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_unique_and_every_difference_has_a_reason() {
        let figures = figures();
        assert!(figures.len() > 80);
        for (index, figure) in figures.iter().enumerate() {
            let key = &figure.key;
            assert!(figures[..index].iter().all(|other| other.key != *key), "{key} is not unique");
            let (.., suffix) = UNITS.iter().find(|(unit, ..)| *unit == figure.unit).expect("a unit");
            let quantity =
                [".base_", ".all", ".mu_"].iter().fold(key.as_str(), |key, end| key.split(end).next().unwrap_or(key));
            assert!(quantity.ends_with(suffix), "{key} does not end in the unit {}", figure.unit);
            assert!(
                figure.expected.is_some() || figure.tolerance == 0.0,
                "{key} has a tolerance without an expected value"
            );
            assert!(figure.reason.is_empty() || reasons().contains_key(&figure.reason), "{key}: {}", figure.reason);
            // The printed and the expected value may differ only for a reason.
            if let (Some(thesis), Some(expected)) = (figure.thesis, figure.expected) {
                let decimals = figure.printed.split_once('.').map_or(0, |(_, fraction)| fraction.len() as i32);
                let rounding = 0.5 * 10f64.powi(-decimals) / figure.scale * (1.0 + 1e-9);
                let agree = (thesis - expected).abs() <= rounding.max(figure.tolerance);
                assert!(agree || !figure.reason.is_empty(), "{key} has no reason");
            }
        }
        let used = |key: &String| figures.iter().any(|figure| figure.reason == *key);
        assert!(reasons().keys().all(used), "an unused reason");
    }
}
