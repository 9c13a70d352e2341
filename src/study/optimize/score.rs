//! Ranks designs: Deb's feasibility rules, dominance, non-dominated fronts and crowding distances.

use std::cmp::Ordering;

/// Score of a design, as used by the searches.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// Objectives, all to be minimised; may be meaningless if the design is infeasible.
    pub objectives: Vec<f64>,
    /// Total constraint violation; 0 for a feasible design.
    pub violation: f64,
}

impl Score {
    /// Returns whether all constraints are satisfied.
    pub fn is_feasible(&self) -> bool {
        self.violation <= 0.0
    }
}

/// Returns whether `a` dominates `b` (Deb 2000): it is feasible and `b` is not; or both are infeasible and it has the
/// smaller violation; or both are feasible, and it is no worse in every objective and better in at least one.
pub(super) fn dominates(a: &Score, b: &Score) -> bool {
    match (a.is_feasible(), b.is_feasible()) {
        (true, false) => true,
        (false, true) => false,
        (false, false) => a.violation < b.violation,
        (true, true) => {
            let pairs = || a.objectives.iter().zip(&b.objectives);
            pairs().all(|(a, b)| a <= b) && pairs().any(|(a, b)| a < b)
        }
    }
}

/// Compares two designs by the first objective with the same rules; the better one is less.
pub(super) fn compare(a: &Score, b: &Score) -> Ordering {
    match (a.is_feasible(), b.is_feasible()) {
        (true, false) => Ordering::Less,
        (false, true) => Ordering::Greater,
        (false, false) => a.violation.total_cmp(&b.violation),
        (true, true) => a.objectives[0].total_cmp(&b.objectives[0]),
    }
}

/// Returns the non-dominated fronts, best first (fast non-dominated sort, Deb et al. 2002). Indices ascend within a
/// front.
pub(super) fn non_dominated_fronts(scores: &[&Score]) -> Vec<Vec<usize>> {
    let mut dominated: Vec<Vec<usize>> = vec![Vec::new(); scores.len()];
    let mut dominator_counts = vec![0usize; scores.len()];
    for a in 0..scores.len() {
        for b in a + 1..scores.len() {
            let (better, worse) = match (dominates(scores[a], scores[b]), dominates(scores[b], scores[a])) {
                (true, _) => (a, b),
                (_, true) => (b, a),
                _ => continue,
            };
            dominated[better].push(worse);
            dominator_counts[worse] += 1;
        }
    }
    let mut non_dominated_fronts = Vec::new();
    let mut front: Vec<usize> = (0..scores.len()).filter(|&index| dominator_counts[index] == 0).collect();
    while !front.is_empty() {
        let mut next = Vec::new();
        for &worse in front.iter().flat_map(|&index| &dominated[index]) {
            dominator_counts[worse] -= 1;
            if dominator_counts[worse] == 0 {
                next.push(worse);
            }
        }
        next.sort_unstable();
        non_dominated_fronts.push(std::mem::replace(&mut front, next));
    }
    non_dominated_fronts
}

/// Returns the indices of the feasible designs that no other design dominates. A single pass with a running front,
/// because there may be thousands of designs.
pub(super) fn pareto_front(scores: &[&Score]) -> Vec<usize> {
    let mut front: Vec<usize> = Vec::new();
    for (index, score) in scores.iter().enumerate().filter(|(_, score)| score.is_feasible()) {
        // The first of equal designs is kept.
        let is_excluded_by =
            |&other: &usize| dominates(scores[other], score) || scores[other].objectives == score.objectives;
        if front.iter().any(is_excluded_by) {
            continue;
        }
        front.retain(|&other| !dominates(score, scores[other]));
        front.push(index);
    }
    front
}

/// Crowding distance of each design of a front (Deb et al. 2002): distance between its two neighbours, summed over the
/// objectives and relative to the front's extent; infinite at the ends.
pub(super) fn crowding_distances(scores: &[&Score], front: &[usize]) -> Vec<f64> {
    let mut distances = vec![0.0; front.len()];
    let objectives = front.first().map_or(0, |&first| scores[first].objectives.len());
    for objective in 0..objectives {
        let value = |index: usize| scores[front[index]].objectives[objective];
        let mut order: Vec<usize> = (0..front.len()).collect();
        order.sort_by(|&a, &b| value(a).total_cmp(&value(b)));
        let (first, last) = (order[0], order[order.len() - 1]);
        let extent = value(last) - value(first);
        distances[first] = f64::INFINITY;
        distances[last] = f64::INFINITY;
        if extent > 0.0 && extent.is_finite() {
            for neighbours in order.windows(3) {
                distances[neighbours[1]] += (value(neighbours[2]) - value(neighbours[0])) / extent;
            }
        }
    }
    distances
}

#[cfg(test)]
mod tests {
    use super::*;

    fn score(objectives: &[f64], violation: f64) -> Score {
        Score { objectives: objectives.to_vec(), violation }
    }

    #[test]
    fn feasible_designs_dominate_infeasible_ones() {
        let all = [
            score(&[1.0, 4.0], 0.0),
            score(&[2.0, 2.0], 0.0),
            score(&[3.0, 3.0], 0.0),
            score(&[0.0, 0.0], 0.5),
            score(&[9.0, 9.0], 0.1),
            score(&[4.0, 1.0], 0.0),
            score(&[2.0, 2.0], 0.0),
        ];
        let all: Vec<&Score> = all.iter().collect();
        assert_eq!(non_dominated_fronts(&all), [vec![0, 1, 5, 6], vec![2], vec![4], vec![3]]);
        assert_eq!(pareto_front(&all), [0, 1, 5], "the first of equal designs");
        assert_eq!(compare(all[3], all[4]), Ordering::Greater);
        assert_eq!(compare(all[0], all[4]), Ordering::Less);
    }

    #[test]
    fn ends_of_a_front_have_infinite_crowding_distance() {
        let all = [[0.0, 10.0], [1.0, 6.0], [4.0, 4.0], [10.0, 0.0]].map(|objectives| score(&objectives, 0.0));
        let all: Vec<&Score> = all.iter().collect();
        let found = crowding_distances(&all, &[0, 1, 2, 3]);
        assert_eq!((found[0], found[3]), (f64::INFINITY, f64::INFINITY));
        // By hand: (4 − 0)/10 + (10 − 4)/10 and (10 − 1)/10 + (6 − 0)/10.
        assert!((found[1] - 1.0).abs() < 1e-15 && (found[2] - 1.5).abs() < 1e-15, "{found:?}");
        assert_eq!(crowding_distances(&all, &[2]), [f64::INFINITY]);
    }
}
