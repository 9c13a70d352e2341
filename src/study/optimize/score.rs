//! Which of two designs is better: Deb's rules of feasibility, dominance, fronts, and how lonely a design is on its front.

use std::cmp::Ordering;

/// What a search knows of a design.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// All to be made small; of a design that is not feasible they may say nothing.
    pub objectives: Vec<f64>,
    /// By how much constraints are missed; 0 of a feasible design.
    pub violation: f64,
}

impl Score {
    /// Whether all constraints are met.
    pub fn is_feasible(&self) -> bool {
        self.violation <= 0.0
    }
}

/// Whether the first of two designs is better for certain (Deb 2000): feasible where the other is not; less violated where neither is;
/// where both are, in no objective worse and in one better.
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

/// The order by one objective, the better first, by the same rules.
pub(super) fn better(a: &Score, b: &Score) -> Ordering {
    match (a.is_feasible(), b.is_feasible()) {
        (true, false) => Ordering::Less,
        (false, true) => Ordering::Greater,
        (false, false) => a.violation.total_cmp(&b.violation),
        (true, true) => a.objectives[0].total_cmp(&b.objectives[0]),
    }
}

/// Fronts of designs, none of which dominates another of its front, the best front first (fast non-dominated sort, Deb et al. 2002);
/// indices ascend within a front.
pub(super) fn fronts(scores: &[&Score]) -> Vec<Vec<usize>> {
    let mut below: Vec<Vec<usize>> = vec![Vec::new(); scores.len()];
    let mut above = vec![0usize; scores.len()];
    for a in 0..scores.len() {
        for b in a + 1..scores.len() {
            let (better, worse) = match (dominates(scores[a], scores[b]), dominates(scores[b], scores[a])) {
                (true, _) => (a, b),
                (_, true) => (b, a),
                _ => continue,
            };
            below[better].push(worse);
            above[worse] += 1;
        }
    }
    let mut fronts = Vec::new();
    let mut front: Vec<usize> = (0..scores.len()).filter(|&index| above[index] == 0).collect();
    while !front.is_empty() {
        let mut next = Vec::new();
        for &worse in front.iter().flat_map(|&index| &below[index]) {
            above[worse] -= 1;
            if above[worse] == 0 {
                next.push(worse);
            }
        }
        next.sort_unstable();
        fronts.push(std::mem::replace(&mut front, next));
    }
    fronts
}

/// The feasible designs that no other one dominates, by their indices: one pass over those found so far, for there may be thousands.
pub(super) fn front(scores: &[&Score]) -> Vec<usize> {
    let mut kept: Vec<usize> = Vec::new();
    for (index, score) in scores.iter().enumerate().filter(|(_, score)| score.is_feasible()) {
        // Of equals the first is kept.
        let beaten = |&other: &usize| dominates(scores[other], score) || scores[other].objectives == score.objectives;
        if kept.iter().any(beaten) {
            continue;
        }
        kept.retain(|&other| !dominates(score, scores[other]));
        kept.push(index);
    }
    kept
}

/// How far each design of a front is from its neighbours: half the edges of the box between them, in shares of the front's extent;
/// infinite at the ends (crowding distance, Deb et al. 2002).
pub(super) fn crowding(scores: &[&Score], front: &[usize]) -> Vec<f64> {
    let mut distances = vec![0.0; front.len()];
    let objectives = front.first().map_or(0, |&first| scores[first].objectives.len());
    for objective in 0..objectives {
        let value = |place: usize| scores[front[place]].objectives[objective];
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
    fn feasible_designs_come_first_and_then_those_that_nothing_beats() {
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
        assert_eq!(fronts(&all), [vec![0, 1, 5, 6], vec![2], vec![4], vec![3]]);
        assert_eq!(front(&all), [0, 1, 5], "of equals the first");
        assert_eq!(better(all[3], all[4]), Ordering::Greater);
        assert_eq!(better(all[0], all[4]), Ordering::Less);
    }

    #[test]
    fn the_ends_of_a_front_are_the_loneliest() {
        let all = [[0.0, 10.0], [1.0, 6.0], [4.0, 4.0], [10.0, 0.0]].map(|of| score(&of, 0.0));
        let all: Vec<&Score> = all.iter().collect();
        let found = crowding(&all, &[0, 1, 2, 3]);
        assert_eq!((found[0], found[3]), (f64::INFINITY, f64::INFINITY));
        // By hand: (4 − 0)/10 + (10 − 4)/10 and (10 − 1)/10 + (6 − 0)/10.
        assert!((found[1] - 1.0).abs() < 1e-15 && (found[2] - 1.5).abs() < 1e-15, "{found:?}");
        assert_eq!(crowding(&all, &[2]), [f64::INFINITY]);
    }
}
