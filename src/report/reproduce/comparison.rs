//! The thesis's figures beside ours, and whether ours are as expected.

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};

use crate::study::reproduce::{Figure, Reproduction, figures, measured, reasons};

/// One figure, in SI; the unit stands at the end of its name (before `.base_…`, `.all` and `.mu_…`).
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    pub figure: &'static str,
    pub section: &'static str,
    pub source: &'static str,
    pub what: &'static str,
    pub thesis: Option<f64>,
    /// Not a number (null) where there is none.
    pub ours: f64,
    pub expected: Option<f64>,
    pub expected_within: Option<f64>,
    pub verdict: Verdict,
    pub errata: Vec<u32>,
    pub reason: &'static str,
    #[serde(skip)]
    pub of: &'static Figure,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    Inside,
    Outside,
    /// Nothing is expected, or it was not computed to the end.
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

/// Every figure, in the order of the file.
pub fn comparisons(found: &Reproduction) -> Vec<Comparison> {
    let values: BTreeMap<String, f64> = measured(found);
    let one = |of: &'static Figure| {
        let ours = values.get(&of.key).copied().unwrap_or(f64::NAN);
        let reason = reasons().get(&of.reason);
        // Expectations of volumes are of the full resolution.
        let judged = !(found.quick && of.section == "volumes");
        Comparison {
            figure: &of.key,
            section: &of.section,
            source: &of.source,
            what: &of.what,
            thesis: of.thesis,
            ours,
            expected: of.expected,
            expected_within: of.expected.map(|_| of.within),
            verdict: match of.expected {
                // A value at the very edge of a rounded one is in it.
                Some(expected) if judged => match (ours - expected).abs() <= of.within + 1e-9 * expected.abs() {
                    true => Verdict::Inside,
                    false => Verdict::Outside,
                },
                _ => Verdict::NotJudged,
            },
            errata: reason.map_or(Vec::new(), |reason| reason.errata.clone()),
            reason: reason.map_or("", |reason| &reason.text),
            of,
        }
    };
    figures().iter().map(one).collect()
}

impl Comparison {
    /// The thesis's value as it is printed, with its unit.
    pub fn thesis_text(&self) -> String {
        if self.of.printed.is_empty() { "–".to_string() } else { with_unit(&self.of.printed, self.of.unit) }
    }

    /// Whether ours rounds to what is printed.
    pub fn as_printed(&self) -> bool {
        let decimals = self.of.printed.split_once('.').map_or(0, |(_, fraction)| fraction.len());
        format!("{:.decimals$}", self.ours * self.of.scale) == self.of.printed
    }

    /// Ours with as many digits as the thesis or the expectation has.
    pub fn ours_text(&self) -> String {
        match self.ours.is_finite() {
            true => with_unit(&self.rounded(self.ours), self.of.unit),
            false => "none".to_string(),
        }
    }

    /// What is expected, with its width.
    pub fn expected_text(&self) -> String {
        match self.expected {
            None => "–".to_string(),
            Some(value) if self.of.within == 0.0 => with_unit(&self.rounded(value), self.of.unit),
            Some(value) => {
                let shown = self.rounded(value);
                with_unit(&format!("{shown} ± {}", plain(self.of.within * self.of.scale)), self.of.unit)
            }
        }
    }

    fn rounded(&self, value: f64) -> String {
        let decimals = self.of.decimals;
        let text = format!("{:.decimals$}", value * self.of.scale);
        // A negative zero is none.
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

/// Without the noise of a conversion.
fn plain(value: f64) -> String {
    format!("{}", (value * 1e9).round() / 1e9)
}
