//! The JSON document of a reproduction.

use serde::Serialize;

use super::{Comparison, Verdict, comparisons};
use crate::report::select::SelectionReport;
use crate::study::reproduce::{Checks, DRIFT_S, Flip, Reproduction, Variation};

/// Everything that is judged, in SI.
#[derive(Clone, Debug, Serialize)]
pub struct ReproductionReport<'a> {
    #[serde(skip)]
    pub found: &'a Reproduction,
    pub quick: bool,
    /// Figures with an expectation, and those of them that are outside of it.
    pub judged: usize,
    pub outside: usize,
    pub figures: Vec<Comparison>,
    pub other_sizings: Vec<OtherSizingReport>,
    pub checks: &'a Checks,
    pub near_chaotic: ChaosReport<'a>,
    pub selection: SelectionReport<'a>,
}

#[derive(Clone, Debug, Serialize)]
pub struct OtherSizingReport {
    pub torques: &'static str,
    pub statically_stable_mu_0: usize,
    pub statically_stable_mu_0_8: usize,
}

#[derive(Clone, Debug, Serialize)]
pub struct ChaosReport<'a> {
    pub variations: Vec<&'static str>,
    pub conditions: Vec<SpreadReport>,
    /// Runs whose class changes.
    pub runs: &'a [Flip],
    /// Runs whose time to stability moves by more than `drift_s`.
    pub drifting_runs: &'a [i64],
    pub drift_s: f64,
}

/// Dynamically stable runs of one condition.
#[derive(Clone, Debug, Serialize)]
pub struct SpreadReport {
    pub study: usize,
    /// In the order of the variations.
    pub by_variation: Vec<usize>,
    pub in_all: usize,
    pub in_any: usize,
}

impl<'a> ReproductionReport<'a> {
    pub fn new(found: &'a Reproduction) -> Self {
        let figures = comparisons(found);
        let count = |verdict: Verdict| figures.iter().filter(|one| one.verdict == verdict).count();
        let chaos = &found.chaos;
        let spread = |condition: usize| SpreadReport {
            study: chaos.stable[condition][0],
            by_variation: chaos.stable[condition][1..].to_vec(),
            in_all: chaos.always[condition],
            in_any: chaos.ever[condition],
        };
        ReproductionReport {
            found,
            quick: found.quick,
            judged: count(Verdict::Inside) + count(Verdict::Outside),
            outside: count(Verdict::Outside),
            other_sizings: found
                .designs
                .other_sizings
                .iter()
                .map(|of| OtherSizingReport {
                    torques: of.name,
                    statically_stable_mu_0: of.stable[0],
                    statically_stable_mu_0_8: of.stable[1],
                })
                .collect(),
            checks: &found.checks,
            near_chaotic: ChaosReport {
                variations: Variation::ALL.map(Variation::name).to_vec(),
                conditions: (0..chaos.stable.len()).map(spread).collect(),
                runs: &chaos.flips,
                drifting_runs: &chaos.drifting,
                drift_s: DRIFT_S,
            },
            selection: SelectionReport::new("thesis.toml", &found.selection, usize::MAX),
            figures,
        }
    }
}
