//! Comparison of computed values with the values printed in the thesis and with expected values.

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};

use crate::study::reproduce::{Figure, Reproduction, computed_values, figures, reasons};

/// One compared value, in SI units. Its key ends in the unit (before `.base_…`, `.all` and `.mu_…`).
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    pub figure: &'static str,
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
    pub errata: Vec<u32>,
    pub reason: &'static str,
    #[serde(skip)]
    pub entry: &'static Figure,
}

/// Whether a computed value is as expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    Inside,
    Outside,
    /// There is no expected value, or the computation has a reduced resolution.
    NotJudged,
}

impl Verdict {
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Inside => "inside",
            Verdict::Outside => "outside",
            Verdict::NotJudged => "not judged",
        }
    }
}

impl Serialize for Verdict {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        out.serialize_str(self.name())
    }
}

/// Returns all comparisons, in the order of `thesis.csv`.
pub fn comparisons(reproduction: &Reproduction) -> Vec<Comparison> {
    let values: BTreeMap<String, f64> = computed_values(reproduction);
    let compare = |entry: &'static Figure| {
        let computed = values.get(&entry.key).copied().unwrap_or(f64::NAN);
        let reason = reasons().get(&entry.reason);
        // Expected values of volumes refer to the full resolution.
        let is_compared = !(reproduction.quick && entry.section == "volumes");
        Comparison {
            figure: &entry.key,
            section: &entry.section,
            source: &entry.source,
            quantity: &entry.quantity,
            thesis: entry.thesis,
            computed,
            expected: entry.expected,
            expected_within: entry.expected.map(|_| entry.tolerance),
            verdict: match entry.expected {
                // The margin accepts values at the edge of the rounding interval.
                Some(expected) if is_compared => {
                    match (computed - expected).abs() <= entry.tolerance + 1e-9 * expected.abs() {
                        true => Verdict::Inside,
                        false => Verdict::Outside,
                    }
                }
                _ => Verdict::NotJudged,
            },
            errata: reason.map_or(Vec::new(), |reason| reason.errata.clone()),
            reason: reason.map_or("", |reason| &reason.text),
            entry,
        }
    };
    figures().iter().map(compare).collect()
}

impl Comparison {
    /// Returns the value printed in the thesis, with its unit.
    pub fn thesis_text(&self) -> String {
        if self.entry.printed.is_empty() { "–".to_string() } else { with_unit(&self.entry.printed, self.entry.unit) }
    }

    /// Whether the computed value rounds to the printed value.
    pub fn matches_printed(&self) -> bool {
        let decimals = self.entry.printed.split_once('.').map_or(0, |(_, fraction)| fraction.len());
        format!("{:.decimals$}", self.computed * self.entry.scale) == self.entry.printed
    }

    /// Returns the computed value with the digits of the thesis or of the expected value.
    pub fn ours_text(&self) -> String {
        match self.computed.is_finite() {
            true => with_unit(&self.rounded(self.computed), self.entry.unit),
            false => "none".to_string(),
        }
    }

    /// Returns the expected value with its tolerance.
    pub fn expected_text(&self) -> String {
        match self.expected {
            None => "–".to_string(),
            Some(value) if self.entry.tolerance == 0.0 => with_unit(&self.rounded(value), self.entry.unit),
            Some(value) => {
                let rounded = self.rounded(value);
                with_unit(
                    &format!("{rounded} ± {}", without_rounding_error(self.entry.tolerance * self.entry.scale)),
                    self.entry.unit,
                )
            }
        }
    }

    fn rounded(&self, value: f64) -> String {
        let decimals = self.entry.decimals;
        let text = format!("{:.decimals$}", value * self.entry.scale);
        // Negative zero is shown as zero.
        if text.trim_start_matches(['-', '0', '.']).is_empty() {
            text.replace('-', "")
        } else {
            text.replace('-', "−")
        }
    }
}

fn with_unit(text: &str, unit: &str) -> String {
    match unit {
        "" => text.to_string(),
        "°" => format!("{text}°"),
        unit => format!("{text} {unit}"),
    }
}

/// Formats a value without the rounding error of a unit conversion.
fn without_rounding_error(value: f64) -> String {
    format!("{}", (value * 1e9).round() / 1e9)
}
