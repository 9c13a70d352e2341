//! Weighted score r_WC (4.2) with errata 11, and the resulting ranks.

use super::{Candidate, SelectError};

/// Weights of the terms of r_WC; only their ratios matter. The thesis uses equal weights.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Weights {
    pub pfp: f64,
    pub tts: f64,
    pub f21: f64,
    pub f22: f64,
}

impl Default for Weights {
    fn default() -> Self {
        Weights { pfp: 1.0, tts: 1.0, f21: 1.0, f22: 1.0 }
    }
}

impl Weights {
    /// Name and weight of each term.
    pub fn named(&self) -> [(&'static str, f64); 4] {
        [("pfp", self.pfp), ("tts", self.tts), ("f21", self.f21), ("f22", self.f22)]
    }

    pub(super) fn check(&self) -> Result<(), SelectError> {
        if let Some(&(name, value)) = self.named().iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
            return Err(SelectError::Weight { name, value });
        }
        match self.named().iter().all(|&(_, value)| value == 0.0) {
            true => Err(SelectError::NoWeight),
            false => Ok(()),
        }
    }
}

/// Figures that determine the rank. A missing figure is NaN and must have zero weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    pub pfp_n: f64,
    pub tts_s: f64,
    pub f21_n: f64,
    pub f22_n: f64,
}

impl Figures {
    /// Figures of a run.
    pub fn from_candidate(run: &Candidate) -> Figures {
        let or_nan = |value: Option<f64>| value.unwrap_or(f64::NAN);
        Figures {
            pfp_n: or_nan(run.pfp_n),
            tts_s: or_nan(run.tts_s),
            f21_n: or_nan(run.f21_n),
            f22_n: or_nan(run.f22_n),
        }
    }
}

/// Terms of r_WC, each from 0 (worst of the selected runs) to 1 (best): r(PFP), 1 − r(tts), 1 − r(F21), r(F22).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct ScoreTerms {
    pub pfp: f64,
    pub tts: f64,
    pub f21: f64,
    pub f22: f64,
}

/// A selected run with its rank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ranked {
    /// Rank from 1. Ties share a rank, and the following ranks are skipped.
    pub rank: usize,
    /// Index of the run in the ranked set.
    pub run_index: usize,
    pub terms: ScoreTerms,
    pub r_wc: f64,
}

/// Values of r_WC closer than this differ by rounding only and are ties.
const TIE_TOLERANCE: f64 = 1e-12;

/// Ranks by r_WC = Σ w term / Σ w, best first; ties keep their input order.
///
/// Each figure is scaled by its range over the set: r = (x − min)/(max − min). If all values are equal, for example in
/// a set of one, the term is ½ for every run.
pub fn rank(set: &[Figures], weights: &Weights) -> Vec<Ranked> {
    let ratio = |figure: fn(&Figures) -> f64| {
        let (low, high) = set.iter().map(figure).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (f64::min(low, value), f64::max(high, value))
        });
        move |figures: &Figures| match figure(figures) {
            value if value.is_nan() => f64::NAN,
            value if high > low => (value - low) / (high - low),
            _ => 0.5,
        }
    };
    let (pfp, tts) = (ratio(|figures| figures.pfp_n), ratio(|figures| figures.tts_s));
    let (f21, f22) = (ratio(|figures| figures.f21_n), ratio(|figures| figures.f22_n));
    let score = |(run_index, figures): (usize, &Figures)| {
        let terms =
            ScoreTerms { pfp: pfp(figures), tts: 1.0 - tts(figures), f21: 1.0 - f21(figures), f22: f22(figures) };
        let weighted_terms =
            [(weights.pfp, terms.pfp), (weights.tts, terms.tts), (weights.f21, terms.f21), (weights.f22, terms.f22)];
        let nonzero = weighted_terms.iter().filter(|(weight, _)| *weight > 0.0);
        let (sum, total) =
            nonzero.fold((0.0, 0.0), |(sum, total), (weight, term)| (sum + weight * term, total + weight));
        Ranked { rank: 0, run_index, terms, r_wc: sum / total }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(rows: &[[f64; 4]]) -> Vec<Figures> {
        rows.iter().map(|&[pfp_n, tts_s, f21_n, f22_n]| Figures { pfp_n, tts_s, f21_n, f22_n }).collect()
    }

    /// Calculated by hand. Ranges: PFP 0…10, tts 5…9 ms, F21 10…30, F22 2…6.
    /// A: PFP 1, tts ½, F21 0, F22 ½ → 2/4. B: 0, 1, ½, 0 → 1.5/4. C: ½, 0, 1, 1 → 2.5/4.
    #[test]
    fn errata_11_prefers_large_f22_and_small_f21() {
        let set = figures(&[[10.0, 7e-3, 30.0, 4.0], [0.0, 5e-3, 20.0, 2.0], [5.0, 9e-3, 10.0, 6.0]]);
        let ranking = rank(&set, &Weights::default());
        let order: Vec<_> = ranking.iter().map(|ranked| (ranked.rank, ranked.run_index)).collect();
        assert_eq!(order, [(1, 2), (2, 0), (3, 1)]);
        for (ranked, expected) in ranking.iter().zip([0.625, 0.5, 0.375]) {
            assert!((ranked.r_wc - expected).abs() < 1e-14, "{ranked:?}");
        }
        let best = ranking[0].terms;
        assert_eq!((best.pfp, best.tts, best.f21, best.f22), (0.5, 0.0, 1.0, 1.0));
    }

    #[test]
    fn only_ratios_of_weights_affect_the_ranking() {
        let set = figures(&[[10.0, 7e-3, 30.0, 4.0], [0.0, 5e-3, 20.0, 2.0], [5.0, 9e-3, 10.0, 6.0]]);
        let rank_with = |pfp, tts, f21, f22| rank(&set, &Weights { pfp, tts, f21, f22 });
        // Calculated by hand. tts alone: B 1, A ½, C 0; weights PFP 3 and tts 1: A 3.5/4, B 1/4, C 1.5/4.
        assert_eq!(rank_with(0.0, 2.0, 0.0, 0.0).iter().map(|r| r.run_index).collect::<Vec<_>>(), [1, 0, 2]);
        let scores: Vec<_> = rank_with(3.0, 1.0, 0.0, 0.0).iter().map(|r| (r.run_index, r.r_wc)).collect();
        assert_eq!(scores, [(0, 0.875), (2, 0.375), (1, 0.25)]);
        assert_eq!(rank_with(3.0, 1.0, 0.0, 0.0), rank_with(6.0, 2.0, 0.0, 0.0));
    }

    #[test]
    fn ties_share_a_rank_in_input_order() {
        let set =
            figures(&[[1.0, 5e-3, 1.0, 1.0], [2.0, 5e-3, 1.0, 1.0], [2.0, 5e-3, 1.0, 1.0], [0.0, 5e-3, 1.0, 1.0]]);
        let ranking = rank(&set, &Weights::default());
        let order: Vec<_> = ranking.iter().map(|ranked| (ranked.rank, ranked.run_index)).collect();
        assert_eq!(order, [(1, 1), (1, 2), (3, 0), (4, 3)]);
        assert!(ranking.iter().all(|ranked| ranked.terms.tts == 0.5), "equal tts");
    }

    #[test]
    fn a_single_run_scores_one_half_and_an_empty_set_has_no_ranking() {
        let alone = rank(&figures(&[[3.0, 7e-3, 20.0, 8.0]]), &Weights::default());
        assert_eq!((alone.len(), alone[0].rank, alone[0].r_wc), (1, 1, 0.5));
        assert!(rank(&[], &Weights::default()).is_empty());
    }

    #[test]
    fn a_missing_figure_with_zero_weight_has_no_effect() {
        let set = figures(&[[1.0, f64::NAN, 1.0, 1.0], [2.0, 5e-3, 1.0, 1.0]]);
        let ranking = rank(&set, &Weights { tts: 0.0, ..Weights::default() });
        assert_eq!(ranking.iter().map(|r| r.run_index).collect::<Vec<_>>(), [1, 0]);
        assert!((ranking[0].r_wc - 2.0 / 3.0).abs() < 1e-14);
    }
}
