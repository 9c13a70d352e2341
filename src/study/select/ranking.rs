//! The weighted criterion r_WC (4.2), with errata 11, and the places that follow from it.

use super::{Candidate, SelectError};

/// What each part of r_WC counts; only their proportions matter. The thesis weighs all the same.
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
    /// Name and weight of each part.
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

/// What a run is ranked by. NaN where there is no such figure; such a part must have no weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    pub pfp_n: f64,
    pub tts_s: f64,
    pub f21_n: f64,
    pub f22_n: f64,
}

impl Figures {
    pub fn of(run: &Candidate) -> Figures {
        let or_nan = |value: Option<f64>| value.unwrap_or(f64::NAN);
        Figures {
            pfp_n: or_nan(run.pfp_n),
            tts_s: or_nan(run.tts_s),
            f21_n: or_nan(run.f21_n),
            f22_n: or_nan(run.f22_n),
        }
    }
}

/// The parts of r_WC, each from 0 (worst of the selected) to 1 (best): r(PFP), 1 − r(tts), 1 − r(F21), r(F22).
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Parts {
    pub pfp: f64,
    pub tts: f64,
    pub f21: f64,
    pub f22: f64,
}

/// A selected run with its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ranked {
    /// From 1. Equals share a place, and the places after it stay free.
    pub place: usize,
    /// Index into what was ranked.
    pub run_index: usize,
    pub parts: Parts,
    pub r_wc: f64,
}

/// Values of r_WC within this of one another are equal: they differ by rounding alone.
const SAME: f64 = 1e-12;

/// Ranks by r_WC = Σ w part / Σ w, best first; equals stay in the order they came in.
///
/// Each figure is scaled from its smallest to its largest value over the set: r = (x − min)/(max − min). Where all are
/// equal (a set of one, for one), the part says nothing of which is better, and is ½ for every one.
pub fn rank(set: &[Figures], weights: &Weights) -> Vec<Ranked> {
    let ratio = |figure: fn(&Figures) -> f64| {
        let (low, high) = set.iter().map(figure).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (f64::min(low, value), f64::max(high, value))
        });
        move |of: &Figures| match figure(of) {
            value if value.is_nan() => f64::NAN,
            value if high > low => (value - low) / (high - low),
            _ => 0.5,
        }
    };
    let (pfp, tts) = (ratio(|of| of.pfp_n), ratio(|of| of.tts_s));
    let (f21, f22) = (ratio(|of| of.f21_n), ratio(|of| of.f22_n));
    let score = |(run_index, of): (usize, &Figures)| {
        let parts = Parts { pfp: pfp(of), tts: 1.0 - tts(of), f21: 1.0 - f21(of), f22: f22(of) };
        let shares =
            [(weights.pfp, parts.pfp), (weights.tts, parts.tts), (weights.f21, parts.f21), (weights.f22, parts.f22)];
        let counted = shares.iter().filter(|(weight, _)| *weight > 0.0);
        let (sum, all) = counted.fold((0.0, 0.0), |(sum, all), (weight, part)| (sum + weight * part, all + weight));
        Ranked { place: 0, run_index, parts, r_wc: sum / all }
    };
    let mut ranking: Vec<Ranked> = set.iter().enumerate().map(score).collect();
    ranking.sort_by(|a, b| b.r_wc.total_cmp(&a.r_wc));
    for index in 0..ranking.len() {
        let shared = index.checked_sub(1).filter(|&last| ranking[last].r_wc - ranking[index].r_wc <= SAME);
        ranking[index].place = shared.map_or(index + 1, |last| ranking[last].place);
    }
    ranking
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(rows: &[[f64; 4]]) -> Vec<Figures> {
        rows.iter().map(|&[pfp_n, tts_s, f21_n, f22_n]| Figures { pfp_n, tts_s, f21_n, f22_n }).collect()
    }

    /// By hand. Ranges: PFP 0…10, tts 5…9 ms, F21 10…30, F22 2…6.
    /// A: PFP 1, tts ½, F21 0, F22 ½ → 2/4. B: 0, 1, ½, 0 → 1.5/4. C: ½, 0, 1, 1 → 2.5/4.
    #[test]
    fn errata_11_more_force_at_the_tip_and_less_at_the_proximal_phalanx_is_better() {
        let set = figures(&[[10.0, 7e-3, 30.0, 4.0], [0.0, 5e-3, 20.0, 2.0], [5.0, 9e-3, 10.0, 6.0]]);
        let ranking = rank(&set, &Weights::default());
        let order: Vec<_> = ranking.iter().map(|ranked| (ranked.place, ranked.run_index)).collect();
        assert_eq!(order, [(1, 2), (2, 0), (3, 1)]);
        for (ranked, expected) in ranking.iter().zip([0.625, 0.5, 0.375]) {
            assert!((ranked.r_wc - expected).abs() < 1e-14, "{ranked:?}");
        }
        let best = ranking[0].parts;
        assert_eq!((best.pfp, best.tts, best.f21, best.f22), (0.5, 0.0, 1.0, 1.0));
    }

    #[test]
    fn weights_shift_the_order_and_only_their_proportions_count() {
        let set = figures(&[[10.0, 7e-3, 30.0, 4.0], [0.0, 5e-3, 20.0, 2.0], [5.0, 9e-3, 10.0, 6.0]]);
        let of = |pfp, tts, f21, f22| rank(&set, &Weights { pfp, tts, f21, f22 });
        // By hand, tts alone: B 1, A ½, C 0; PFP thrice and tts once: A 3.5/4, B 1/4, C 1.5/4.
        assert_eq!(of(0.0, 2.0, 0.0, 0.0).iter().map(|r| r.run_index).collect::<Vec<_>>(), [1, 0, 2]);
        let scores: Vec<_> = of(3.0, 1.0, 0.0, 0.0).iter().map(|r| (r.run_index, r.r_wc)).collect();
        assert_eq!(scores, [(0, 0.875), (2, 0.375), (1, 0.25)]);
        assert_eq!(of(3.0, 1.0, 0.0, 0.0), of(6.0, 2.0, 0.0, 0.0));
    }

    #[test]
    fn equals_share_a_place_in_the_order_they_came_in() {
        let set =
            figures(&[[1.0, 5e-3, 1.0, 1.0], [2.0, 5e-3, 1.0, 1.0], [2.0, 5e-3, 1.0, 1.0], [0.0, 5e-3, 1.0, 1.0]]);
        let ranking = rank(&set, &Weights::default());
        let order: Vec<_> = ranking.iter().map(|ranked| (ranked.place, ranked.run_index)).collect();
        assert_eq!(order, [(1, 1), (1, 2), (3, 0), (4, 3)]);
        assert!(ranking.iter().all(|ranked| ranked.parts.tts == 0.5), "tts is the same for all");
    }

    #[test]
    fn one_is_neither_best_nor_worst_and_none_is_no_ranking() {
        let alone = rank(&figures(&[[3.0, 7e-3, 20.0, 8.0]]), &Weights::default());
        assert_eq!((alone.len(), alone[0].place, alone[0].r_wc), (1, 1, 0.5));
        assert!(rank(&[], &Weights::default()).is_empty());
    }

    #[test]
    fn a_figure_that_is_not_there_and_does_not_count_is_no_harm() {
        let set = figures(&[[1.0, f64::NAN, 1.0, 1.0], [2.0, 5e-3, 1.0, 1.0]]);
        let ranking = rank(&set, &Weights { tts: 0.0, ..Weights::default() });
        assert_eq!(ranking.iter().map(|r| r.run_index).collect::<Vec<_>>(), [1, 0]);
        assert!((ranking[0].r_wc - 2.0 / 3.0).abs() < 1e-14);
    }
}
