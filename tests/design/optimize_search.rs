//! Search algorithms on test problems with known solutions.

use phalanx::study::optimize::{Algorithm, Method, Score, Search};

/// Runs a search over the unit cube to its end. Returns every candidate with its score, in the order of the search.
fn run_search(method: Method, start: Vec<f64>, evaluate: impl Fn(&[f64]) -> Score) -> Vec<(Vec<f64>, Score)> {
    let mut search = Search::new(&method, start);
    let mut all = Vec::new();
    for _ in 0..method.generations {
        if search.has_converged() {
            break;
        }
        let candidates = search.ask();
        assert!(candidates.iter().flatten().all(|x| (0.0..=1.0).contains(x)), "outside the cube");
        let scores: Vec<Score> = candidates.iter().map(|candidate| evaluate(candidate)).collect();
        search.tell(&scores);
        all.extend(candidates.into_iter().zip(scores));
    }
    all
}

fn nsga2(population: u64, generations: u64, seed: u64) -> Method {
    Method { algorithm: Algorithm::Nsga2, population, generations, seed }
}

fn cma_es(population: u64, generations: u64, seed: u64) -> Method {
    Method { algorithm: Algorithm::CmaEs, population, generations, seed }
}

fn feasible(objectives: &[f64]) -> Score {
    Score { objectives: objectives.to_vec(), violation: 0.0 }
}

/// Returns the feasible candidates that no other one dominates.
fn front(all: &[(Vec<f64>, Score)]) -> Vec<&(Vec<f64>, Score)> {
    let dominates = |a: &Score, b: &Score| {
        let pairs = || a.objectives.iter().zip(&b.objectives);
        a.is_feasible() && pairs().all(|(a, b)| a <= b) && pairs().any(|(a, b)| a < b)
    };
    let feasible = all.iter().filter(|(_, score)| score.is_feasible());
    feasible.filter(|(_, score)| !all.iter().any(|(_, other)| dominates(other, score))).collect()
}

/// Returns the mean distance of points on the known front from the nearest point found.
fn distance(known: &[[f64; 2]], front: &[&(Vec<f64>, Score)]) -> f64 {
    let nearest = |point: &[f64; 2]| {
        let distance_to =
            |(_, score): &&(Vec<f64>, Score)| (score.objectives[0] - point[0]).hypot(score.objectives[1] - point[1]);
        front.iter().map(distance_to).fold(f64::INFINITY, f64::min)
    };
    known.iter().map(nearest).sum::<f64>() / known.len() as f64
}

/// ZDT1 (Zitzler, Deb and Thiele 2000) with ten variables: on its front f2 = 1 − √f1, and all other variables are 0.
#[test]
fn nsga2_finds_the_front_of_zdt1() {
    let evaluate = |x: &[f64]| {
        let g = 1.0 + 9.0 * x[1..].iter().sum::<f64>() / (x.len() - 1) as f64;
        feasible(&[x[0], g * (1.0 - (x[0] / g).sqrt())])
    };
    for seed in [1, 2, 3] {
        let all = run_search(nsga2(60, 120, seed), vec![0.5; 10], evaluate);
        let actual = front(&all);
        let known: Vec<[f64; 2]> = (0..=50).map(|k| f64::from(k) / 50.0).map(|f| [f, 1.0 - f.sqrt()]).collect();
        let error = distance(&known, &actual);
        assert!(error < 0.02, "seed {seed}: {error} of {} designs", actual.len());
        // No value is better than the front.
        assert!(actual.iter().all(|(_, score)| score.objectives[1] >= 1.0 - score.objectives[0].sqrt() - 1e-12));
    }
}

/// CONSTR (Deb 2001): f = (x, (1 + y)/x) with y + 9 x ≥ 6 and 9 x − y ≥ 1, for x from 0.1 to 1 and y from 0 to 5. Its front follows the first
/// constraint from x = 7/18 to 2/3, then y = 0.
#[test]
fn nsga2_finds_a_front_along_a_constraint() {
    let evaluate = |candidate: &[f64]| {
        let (x, y) = (0.1 + 0.9 * candidate[0], 5.0 * candidate[1]);
        let violation = (6.0 - y - 9.0 * x).max(0.0) + (1.0 + y - 9.0 * x).max(0.0);
        Score { objectives: vec![x, (1.0 + y) / x], violation }
    };
    let all = run_search(nsga2(60, 80, 1), vec![0.0, 1.0], evaluate);
    assert!(!all[0].1.is_feasible(), "the start is infeasible");
    let actual = front(&all);
    let front_at = |x: f64| [x, if x < 2.0 / 3.0 { (7.0 - 9.0 * x) / x } else { 1.0 / x }];
    let (first, last) = (7.0 / 18.0, 1.0);
    let known: Vec<[f64; 2]> = (0..=50).map(|k| front_at(first + (last - first) * f64::from(k) / 50.0)).collect();
    let error = distance(&known, &actual);
    assert!(error < 0.05, "{error} of {} designs", actual.len());
    for (_, score) in &actual {
        let [x, value] = score.objectives[..] else { panic!("two objectives") };
        assert!(x >= first - 1e-12 && value >= front_at(x)[1] - 1e-9, "{x} {value}");
    }
}

fn best(all: &[(Vec<f64>, Score)]) -> &(Vec<f64>, Score) {
    let feasible = all.iter().filter(|(_, score)| score.is_feasible());
    feasible.min_by(|(_, a), (_, b)| a.objectives[0].total_cmp(&b.objectives[0])).expect("a feasible candidate")
}

/// Rotated ellipsoid with an axis ratio of one thousand: converges only if the covariance is adapted.
#[test]
fn cma_es_adapts_the_covariance() {
    let evaluate = |candidate: &[f64]| {
        let x: Vec<f64> = candidate.iter().map(|x| x - 0.4).collect();
        // Rows of a Hadamard matrix: orthogonal directions, none along a variable.
        let rotated = |row: usize| -> f64 {
            let sign = |column: usize| if (row & column).count_ones().is_multiple_of(2) { 1.0 } else { -1.0 };
            x.iter().enumerate().map(|(column, x)| sign(column) * x).sum::<f64>() / 8f64.sqrt()
        };
        feasible(&[(0..8).map(|row| 10f64.powf(6.0 * row as f64 / 7.0) * rotated(row).powi(2)).sum()])
    };
    for seed in [1, 2, 3] {
        let all = run_search(cma_es(10, 900, seed), vec![0.8; 8], evaluate);
        let (candidate, score) = best(&all);
        assert!(score.objectives[0] < 1e-6, "seed {seed}: {score:?}");
        assert!(candidate.iter().all(|x| (x - 0.4).abs() < 1e-3), "{candidate:?}");
    }
}

/// Rosenbrock function of four variables; the search ends by convergence.
#[test]
fn cma_es_converges_on_the_rosenbrock_function() {
    let evaluate = |candidate: &[f64]| {
        let x: Vec<f64> = candidate.iter().map(|x| 4.0 * x - 2.0).collect();
        feasible(&[x.windows(2).map(|x| 100.0 * (x[1] - x[0] * x[0]).powi(2) + (1.0 - x[0]).powi(2)).sum()])
    };
    let all = run_search(cma_es(12, 2000, 4), vec![0.3; 4], evaluate);
    let (candidate, score) = best(&all);
    assert!(score.objectives[0] < 1e-8, "{score:?}");
    assert!(candidate.iter().all(|x| (x - 0.75).abs() < 1e-4), "{candidate:?}");
    assert!(all.len() < 12 * 1000, "converged after {} candidates", all.len());
}

/// The optimum is a corner of the cube, or lies on a constraint.
#[test]
fn cma_es_reaches_bounds_and_constraints() {
    let corner = |candidate: &[f64]| feasible(&[candidate[0] + 2.0 * candidate[1] - candidate[2]]);
    let all = run_search(cma_es(10, 300, 2), vec![0.5; 3], corner);
    let (candidate, _) = best(&all);
    assert!(candidate[0] < 1e-5 && candidate[1] < 1e-5 && candidate[2] > 1.0 - 1e-5, "{candidate:?}");

    // Point of x + y ≥ 1.2 nearest to the origin, from an infeasible start.
    let edge = |candidate: &[f64]| Score {
        objectives: vec![candidate[0].powi(2) + candidate[1].powi(2)],
        violation: (1.2 - candidate[0] - candidate[1]).max(0.0),
    };
    let all = run_search(cma_es(10, 400, 3), vec![0.1, 0.2], edge);
    let (candidate, score) = best(&all);
    assert!((score.objectives[0] - 0.72).abs() < 1e-3, "{candidate:?} {score:?}");
}

#[test]
fn equal_seeds_give_equal_searches() {
    let evaluate = |x: &[f64]| feasible(&[(x[0] - 0.3).powi(2), (x[1] - 0.6).powi(2) + x[0]]);
    let single = |x: &[f64]| feasible(&[(x[0] - 0.3).powi(2) + x[1]]);
    assert_eq!(
        run_search(nsga2(12, 10, 5), vec![0.5; 2], evaluate),
        run_search(nsga2(12, 10, 5), vec![0.5; 2], evaluate)
    );
    assert_ne!(
        run_search(nsga2(12, 10, 5), vec![0.5; 2], evaluate),
        run_search(nsga2(12, 10, 6), vec![0.5; 2], evaluate)
    );
    assert_eq!(run_search(cma_es(6, 10, 5), vec![0.5; 2], single), run_search(cma_es(6, 10, 5), vec![0.5; 2], single));
    assert_ne!(run_search(cma_es(6, 10, 5), vec![0.5; 2], single), run_search(cma_es(6, 10, 6), vec![0.5; 2], single));
    assert_eq!(
        run_search(nsga2(12, 1, 5), vec![0.5; 2], evaluate)[0].0,
        [0.5, 0.5],
        "the start is in the first generation"
    );
}
