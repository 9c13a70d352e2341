//! The JSON document of a reproduction.

use serde::Serialize;

use super::{Comparison, Verdict, comparisons};
use crate::report::select::SelectionReport;
use crate::study::reproduce::{Checks, ClassChange, MAX_TTS_DIFFERENCE_S, Reproduction, Variation};

/// Report of a reproduction, in SI units.
#[derive(Clone, Debug, Serialize)]
pub struct ReproductionReport<'a> {
    #[serde(skip)]
    pub reproduction: &'a Reproduction,
    pub quick: bool,
    /// Number of computed values that are compared with an expected value.
    pub judged: usize,
    /// Number of these values outside their tolerance.
    pub outside: usize,
    #[serde(rename = "figures")]
    pub comparisons: Vec<Comparison>,
    pub other_sizings: Vec<OtherSizingReport>,
    pub checks: &'a Checks,
    pub near_chaotic: ChaosReport<'a>,
    pub selection: SelectionReport<'a>,
}

/// Statically stable designs with other torques.
#[derive(Clone, Debug, Serialize)]
pub struct OtherSizingReport {
    pub torques: &'static str,
    pub statically_stable_mu_0: usize,
    pub statically_stable_mu_0_8: usize,
}

/// Near-chaotic runs, which depend on the integration method or on small perturbations.
#[derive(Clone, Debug, Serialize)]
pub struct ChaosReport<'a> {
    pub variations: Vec<&'static str>,
    pub conditions: Vec<SpreadReport>,
    /// Runs whose class changes.
    #[serde(rename = "runs")]
    pub class_changes: &'a [ClassChange],
    /// Runs whose time to stability changes by more than `drift_s`.
    pub drifting_runs: &'a [i64],
    pub drift_s: f64,
}

/// Number of dynamically stable runs of one condition.
#[derive(Clone, Debug, Serialize)]
pub struct SpreadReport {
    pub study: usize,
    /// Numbers in the order of the variations.
    pub by_variation: Vec<usize>,
    pub in_all: usize,
    pub in_any: usize,
}

impl<'a> ReproductionReport<'a> {
    pub fn new(reproduction: &'a Reproduction) -> Self {
        let comparisons = comparisons(reproduction);
        let count = |verdict: Verdict| comparisons.iter().filter(|comparison| comparison.verdict == verdict).count();
        let chaos = &reproduction.chaos;
        let spread = |condition: usize| SpreadReport {
            study: chaos.stable[condition][0],
            by_variation: chaos.stable[condition][1..].to_vec(),
            in_all: chaos.stable_in_all[condition],
            in_any: chaos.stable_in_any[condition],
        };
        ReproductionReport {
            reproduction,
            quick: reproduction.quick,
            judged: count(Verdict::Inside) + count(Verdict::Outside),
            outside: count(Verdict::Outside),
            other_sizings: reproduction
                .designs
                .other_sizings
                .iter()
                .map(|sizing| OtherSizingReport {
                    torques: sizing.name,
                    statically_stable_mu_0: sizing.stable[0],
                    statically_stable_mu_0_8: sizing.stable[1],
                })
                .collect(),
            checks: &reproduction.checks,
            near_chaotic: ChaosReport {
                variations: Variation::ALL.map(Variation::name).to_vec(),
                conditions: (0..chaos.stable.len()).map(spread).collect(),
                class_changes: &chaos.class_changes,
                drifting_runs: &chaos.drifting,
                drift_s: MAX_TTS_DIFFERENCE_S,
            },
            selection: SelectionReport::new("thesis.toml", &reproduction.selection, usize::MAX),
            comparisons,
        }
    }
}
