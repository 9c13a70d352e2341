//! Weighted score r_WC (4.2) with errata 11, and the resulting ranks.

use serde::{Serialize, Serializer};

use super::{Candidate, SelectError};

/// One term of r_WC: a figure of a run, scaled to its range over the selected runs.
pub struct Term {
    /// Key in JSON documents, in columns and in `--weights`.
    pub key: &'static str,
    pub symbol: &'static str,
    /// Displayed unit of the figure, and the factor from SI units to this unit.
    pub unit: (&'static str, f64),
    pub figure: fn(&Candidate) -> Option<f64>,
    /// Whether the largest value is the best. The term is then r, otherwise 1 − r.
    pub is_larger_better: bool,
}

pub const TERMS: [Term; 4] = [
    Term { key: "pfp", symbol: "PFP", unit: ("N", 1.0), figure: |run| run.pfp_n, is_larger_better: true },
    Term { key: "tts", symbol: "tts", unit: ("ms", 1e3), figure: |run| run.tts_s, is_larger_better: false },
    Term { key: "f21", symbol: "F21", unit: ("N", 1.0), figure: |run| run.f21_n, is_larger_better: false },
    Term { key: "f22", symbol: "F22", unit: ("N", 1.0), figure: |run| run.f22_n, is_larger_better: true },
];

/// One value for each term, in the order of [`TERMS`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerTerm(pub [f64; 4]);

impl PerTerm {
    pub fn named(&self) -> [(&'static str, f64); 4] {
        [0, 1, 2, 3].map(|index| (TERMS[index].key, self.0[index]))
    }
}

impl Serialize for PerTerm {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.named())
    }
}

/// Weights of the terms of r_WC; only their ratios matter.
pub type Weights = PerTerm;

impl Default for Weights {
    /// The equal weights of the thesis.
    fn default() -> Self {
        PerTerm([1.0; 4])
    }
}

impl Weights {
    pub(super) fn check(&self) -> Result<(), SelectError> {
        match self.named().iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
            Some(&(name, value)) => Err(SelectError::Weight { name, value }),
            None if self.0 == [0.0; 4] => Err(SelectError::NoWeight),
            None => Ok(()),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ranked {
    /// Rank, counted from 1. Equal scores have the same rank, and the following ranks are skipped.
    pub rank: usize,
    /// Index of the run in the set that is ranked.
    pub run_index: usize,
    /// Terms of r_WC, each from 0 (worst of the selected runs) to 1 (best).
    pub terms: PerTerm,
    pub r_wc: f64,
}

/// Values of r_WC closer than this differ by rounding only and are ties.
const TIE_TOLERANCE: f64 = 1e-12;

/// Ranks by r_WC = Σ w term / Σ w, best first; ties keep their input order. The set contains the figures of each run; a
/// missing figure is NaN and must have zero weight.
///
/// Each figure is scaled by its range over the set: r = (x − min)/(max − min). If all values are equal, for example in
/// a set of one, the term is ½ for every run.
pub(super) fn rank(set: &[[f64; 4]], weights: &Weights) -> Vec<Ranked> {
    let ranges = [0, 1, 2, 3].map(|term| {
        let values = || set.iter().map(|figures| figures[term]);
        (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max))
    });
    let score = |(run_index, figures): (usize, &[f64; 4])| {
        let terms = [0, 1, 2, 3].map(|term| {
            let (low, high) = ranges[term];
            let ratio = match figures[term] {
                value if value.is_nan() => f64::NAN,
                value if high > low => (value - low) / (high - low),
                _ => 0.5,
            };
            if TERMS[term].is_larger_better { ratio } else { 1.0 - ratio }
        });
        let nonzero = weights.0.iter().zip(terms).filter(|(weight, _)| **weight > 0.0);
        let (sum, total) =
            nonzero.fold((0.0, 0.0), |(sum, total), (weight, term)| (sum + weight * term, total + weight));
        Ranked { rank: 0, run_index, terms: PerTerm(terms), r_wc: sum / total }
    };
    let mut ranking: Vec<Ranked> = set.iter().enumerate().map(score).collect();
    ranking.sort_by(|a, b| b.r_wc.total_cmp(&a.r_wc));
    for index in 0..ranking.len() {
        let tied =
            index.checked_sub(1).filter(|&previous| ranking[previous].r_wc - ranking[index].r_wc <= TIE_TOLERANCE);
        ranking[index].rank = tied.map_or(index + 1, |previous| ranking[previous].rank);
    }
    ranking
}
