//! Figures of the thesis, with the values expected from a correct implementation (2-design §2.6), the reasons for
//! differences, and their comparison with computed values.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use crate::format::report::{Cell, CellStyle};
use crate::text::UNITS;

/// One figure of the thesis: a row of `thesis.csv`, with numbers in the unit of the thesis. The key contains the SI unit
/// of the value, at its end or before the first `.base`, `.mu` or `.all`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Figure {
    pub key: String,
    pub section: String,
    /// Table, figure, section or equation of the thesis.
    pub source: String,
    #[serde(rename = "what")]
    pub quantity: String,
    pub unit: String,
    /// Printed text, which also defines the number of digits; may be empty.
    #[serde(rename = "thesis")]
    pub printed: String,
    /// Value that a correct implementation gives, as text; may be empty.
    pub expected: String,
    /// Allowed deviation from the expected value.
    #[serde(rename = "within")]
    pub tolerance: Option<f64>,
    /// Key of a [`Reason`]; empty if the printed and the expected value agree.
    pub reason: String,
}

/// Reason for a difference between the printed and the expected value.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub struct Reason {
    /// Numbers of errata.
    pub errata: Vec<u32>,
    pub text: String,
}

/// Returns all figures, in the order of `thesis.csv`.
pub fn figures() -> &'static [Figure] {
    static PARSED: OnceLock<Vec<Figure>> = OnceLock::new();
    PARSED.get_or_init(|| {
        let mut reader = csv::Reader::from_reader(&include_bytes!("thesis.csv")[..]);
        reader.deserialize().map(|figure| figure.expect("the embedded file is valid")).collect()
    })
}

/// Returns the reasons by key.
pub fn reasons() -> &'static BTreeMap<String, Reason> {
    static PARSED: OnceLock<BTreeMap<String, Reason>> = OnceLock::new();
    PARSED.get_or_init(|| toml::from_str(include_str!("reasons.toml")).expect("the embedded file is valid"))
}

impl Figure {
    /// Returns the factor from SI to the unit of the thesis.
    pub fn scale(&self) -> f64 {
        UNITS.iter().find(|(unit, ..)| *unit == self.unit).expect("a unit of the list").1
    }

    /// Returns a printed or expected value in SI units.
    fn si(&self, text: &str) -> Option<f64> {
        (!text.is_empty()).then(|| text.parse::<f64>().expect("a number") / self.scale())
    }
}

/// Returns the number of decimals of a printed number.
fn decimals(text: &str) -> usize {
    text.split_once('.').map_or(0, |(_, fraction)| fraction.len())
}

/// Whether a computed value is as expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    Inside,
    Outside,
    /// There is no expected value, or the computation has a reduced resolution.
    #[serde(rename = "not judged")]
    NotJudged,
}

/// One compared value, in SI units.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    #[serde(rename = "figure")]
    pub key: &'static str,
    pub section: &'static str,
    pub source: &'static str,
    #[serde(rename = "what")]
    pub quantity: &'static str,
    pub thesis: Option<f64>,
    /// Computed value; NaN (null) where there is none.
    #[serde(rename = "ours")]
    pub computed: f64,
    pub expected: Option<f64>,
    pub expected_within: Option<f64>,
    pub verdict: Verdict,
    pub errata: &'static [u32],
    pub reason: &'static str,
    #[serde(skip)]
    pub figure: &'static Figure,
}

/// Compares computed values with all figures, in the order of `thesis.csv`. `quick` volumes are not judged, because the
/// expected values refer to the full resolution.
pub fn compare(values: &BTreeMap<String, f64>, quick: bool) -> Vec<Comparison> {
    let compare = |figure: &'static Figure| {
        let computed = values.get(&figure.key).copied().unwrap_or(f64::NAN);
        let (errata, reason) =
            reasons().get(&figure.reason).map_or((&[][..], ""), |reason| (&reason.errata, &reason.text));
        let (expected, tolerance) = (figure.si(&figure.expected), figure.tolerance.unwrap_or(0.0) / figure.scale());
        let verdict = match expected.filter(|_| !(quick && figure.section == "volumes")) {
            None => Verdict::NotJudged,
            // The margin accepts values at the edge of the rounding interval.
            Some(expected) if (computed - expected).abs() <= tolerance + 1e-9 * expected.abs() => Verdict::Inside,
            Some(_) => Verdict::Outside,
        };
        Comparison {
            key: &figure.key,
            section: &figure.section,
            source: &figure.source,
            quantity: &figure.quantity,
            thesis: figure.si(&figure.printed),
            computed,
            expected,
            expected_within: expected.map(|_| tolerance),
            verdict,
            errata,
            reason,
            figure,
        }
    };
    figures().iter().map(compare).collect()
}

impl Comparison {
    /// Returns the value printed in the thesis, with its unit.
    pub(crate) fn thesis_text(&self) -> String {
        if self.figure.printed.is_empty() { "–".to_string() } else { self.with_unit(&self.figure.printed) }
    }

    /// Returns the computed value with the digits of the thesis or of the expected value.
    pub fn ours_text(&self) -> String {
        if self.computed.is_finite() { self.with_unit(&self.rounded(self.computed)) } else { "none".to_string() }
    }

    /// Returns the expected value with its tolerance.
    pub fn expected_text(&self) -> String {
        let Some(expected) = self.expected else { return "–".to_string() };
        let value = self.rounded(expected);
        match self.figure.tolerance {
            None | Some(0.0) => self.with_unit(&value),
            Some(tolerance) => self.with_unit(&format!("{value} ± {tolerance}")),
        }
    }

    /// Returns the reason for the difference with its errata; empty if the computed value rounds to the printed one.
    pub(crate) fn reason_text(&self) -> String {
        let printed = &self.figure.printed;
        let matches_printed = format!("{:.*}", decimals(printed), self.computed * self.figure.scale()) == *printed;
        if self.reason.is_empty() || matches_printed && self.verdict != Verdict::Outside {
            return String::new();
        }
        let errata: Vec<String> = self.errata.iter().map(u32::to_string).collect();
        match errata.is_empty() {
            true => self.reason.to_string(),
            false => format!("{} (errata {})", self.reason, errata.join(", ")),
        }
    }

    /// Returns a cell with the computed value, styled by its verdict.
    pub fn cell(&self) -> Cell {
        let style = match self.verdict {
            Verdict::Inside => CellStyle::Good,
            Verdict::Outside => CellStyle::Bad,
            Verdict::NotJudged => CellStyle::Plain,
        };
        let figure = Some((self.key.to_string(), self.computed));
        Cell { text: self.ours_text(), figure, style }
    }

    fn rounded(&self, value: f64) -> String {
        // The digits of the printed or of the expected value, whichever has more.
        let decimals = decimals(&self.figure.printed).max(decimals(&self.figure.expected));
        let text = format!("{:.decimals$}", value * self.figure.scale());
        // Negative zero is shown as zero.
        let is_zero = text.trim_start_matches(['-', '0', '.']).is_empty();
        text.replace('-', if is_zero { "" } else { "−" })
    }

    fn with_unit(&self, text: &str) -> String {
        match self.figure.unit.as_str() {
            "" => text.to_string(),
            "°" => format!("{text}°"),
            unit => format!("{text} {unit}"),
        }
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
            let Figure { key, printed, expected, tolerance, reason, .. } = figure;
            assert!(figures[..index].iter().all(|other| other.key != *key), "{key} is not unique");
            let (.., suffix) = UNITS.iter().find(|(unit, ..)| *unit == figure.unit).expect("a unit");
            let quantity =
                [".base_", ".all", ".mu_"].iter().fold(key.as_str(), |key, end| key.split(end).next().unwrap_or(key));
            assert!(quantity.ends_with(suffix), "{key} does not end in the unit {}", figure.unit);
            assert!(!expected.is_empty() || tolerance.is_none(), "{key} has a tolerance without an expected value");
            assert!(reason.is_empty() || reasons().contains_key(reason), "{key}: {reason}");
            // The printed and the expected value may differ only for a reason.
            if let (Some(thesis), Some(expected)) = (figure.si(printed), figure.si(expected)) {
                let rounding = 0.5 * 10f64.powi(-(decimals(printed) as i32)) * (1.0 + 1e-9);
                let agree = (thesis - expected).abs() * figure.scale() <= rounding.max(tolerance.unwrap_or(0.0));
                assert!(agree || !reason.is_empty(), "{key} has no reason");
            }
        }
        let used = |key: &String| figures.iter().any(|figure| figure.reason == *key);
        assert!(reasons().keys().all(used), "an unused reason");
    }
}
