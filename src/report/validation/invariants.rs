//! Invariants of a run, under the keys of the JSON document.

use serde::Serialize;

use crate::invariants::Finding;

/// How near one invariant came to being broken.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FindingReport {
    pub invariant: &'static str,
    pub meaning: &'static str,
    pub held: bool,
    /// Part of what is allowed; null if it is not finite.
    pub share: f64,
    /// The worst, where and when; in the SI unit of what it measures.
    pub measured: f64,
    pub allowed: f64,
    pub place: Option<String>,
    pub time_s: f64,
    /// All of that in a line.
    #[serde(skip)]
    pub line: String,
}

impl From<&Finding> for FindingReport {
    fn from(found: &Finding) -> Self {
        Self {
            invariant: found.invariant.name(),
            meaning: found.invariant.meaning(),
            held: !found.is_broken(),
            share: found.share(),
            measured: found.measured,
            allowed: found.allowed,
            place: found.place.clone(),
            time_s: found.time_s,
            line: found.to_string(),
        }
    }
}
