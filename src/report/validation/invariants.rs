//! Invariants of a run, under the keys of the JSON document.

use serde::Serialize;

use crate::invariants::Finding;

/// Margin of one invariant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FindingReport {
    pub invariant: &'static str,
    pub meaning: &'static str,
    #[serde(rename = "held")]
    pub is_satisfied: bool,
    /// Measured value as a fraction of the limit; null if it is not finite.
    pub share: f64,
    /// Worst value, in the SI unit of the quantity.
    pub measured: f64,
    /// Limit, in the same unit.
    pub allowed: f64,
    /// Location of the worst value.
    #[serde(rename = "place")]
    pub location: Option<String>,
    /// Time of the worst value.
    pub time_s: f64,
    /// The finding as one line of text.
    #[serde(skip)]
    pub line: String,
}

impl From<&Finding> for FindingReport {
    fn from(found: &Finding) -> Self {
        Self {
            invariant: found.invariant.name(),
            meaning: found.invariant.meaning(),
            is_satisfied: !found.is_violated(),
            share: found.ratio_to_limit(),
            measured: found.measured,
            allowed: found.allowed,
            location: found.contact.clone(),
            time_s: found.time_s,
            line: found.to_string(),
        }
    }
}
