//! The searches on problems whose best is known in closed form.

use phalanx::study::optimize::{Algorithm, Method, Score, Search};

/// A search over the unit cube to its end; every place with its score, in the order they were asked for.
fn searched(method: Method, start: Vec<f64>, of: impl Fn(&[f64]) -> Score) -> Vec<(Vec<f64>, Score)> {
    let mut search = Search::new(&method, start);
    let mut all = Vec::new();
    for _ in 0..method.generations {
        if search.is_over() {
            break;
        }
        let places = search.ask();
        assert!(places.iter().flatten().all(|x| (0.0..=1.0).contains(x)), "outside the cube");
        let scores: Vec<Score> = places.iter().map(|place| of(place)).collect();
        search.tell(&scores);
        all.extend(places.into_iter().zip(scores));
    }
    all
}

fn nsga2(population: u64, generations: u64, seed: u64) -> Method {
    Method { algorithm: Algorithm::Nsga2, population, generations, seed }
}

fn cma_es(population: u64, generations: u64, seed: u64) -> Method {
    Method { algorithm: Algorithm::CmaEs, population, generations, seed }
}

fn free(objectives: &[f64]) -> Score {
    Score { objectives: objectives.to_vec(), violation: 0.0 }
}

/// Feasible ones that no other one beats.
fn front(all: &[(Vec<f64>, Score)]) -> Vec<&(Vec<f64>, Score)> {
    let beats = |a: &Score, b: &Score| {
        let pairs = || a.objectives.iter().zip(&b.objectives);
        a.is_feasible() && pairs().all(|(a, b)| a <= b) && pairs().any(|(a, b)| a < b)
    };
    let feasible = all.iter().filter(|(_, score)| score.is_feasible());
    feasible.filter(|(_, score)| !all.iter().any(|(_, other)| beats(other, score))).collect()
}

/// The mean distance of points of a known front from the nearest that was found.
fn distance(known: &[[f64; 2]], found: &[&(Vec<f64>, Score)]) -> f64 {
    let nearest = |at: &[f64; 2]| {
        let to = |(_, score): &&(Vec<f64>, Score)| (score.objectives[0] - at[0]).hypot(score.objectives[1] - at[1]);
        found.iter().map(to).fold(f64::INFINITY, f64::min)
    };
    known.iter().map(nearest).sum::<f64>() / known.len() as f64
}

/// ZDT1 (Zitzler, Deb and Thiele 2000) with ten variables: f2 = 1 − √f1 with all others 0.
#[test]
fn nsga2_finds_the_front_of_zdt1() {
    let of = |x: &[f64]| {
        let g = 1.0 + 9.0 * x[1..].iter().sum::<f64>() / (x.len() - 1) as f64;
        free(&[x[0], g * (1.0 - (x[0] / g).sqrt())])
    };
    for seed in [1, 2, 3] {
        let all = searched(nsga2(60, 120, seed), vec![0.5; 10], of);
        let found = front(&all);
        let known: Vec<[f64; 2]> = (0..=50).map(|k| f64::from(k) / 50.0).map(|f| [f, 1.0 - f.sqrt()]).collect();
        let off = distance(&known, &found);
        assert!(off < 0.02, "seed {seed}: {off} of {} designs", found.len());
        // The whole of it, and beyond it nothing: no value is better than the front's.
        assert!(found.iter().all(|(_, score)| score.objectives[1] >= 1.0 - score.objectives[0].sqrt() - 1e-12));
    }
}

/// CONSTR (Deb 2001): f = (x, (1 + y)/x) with y + 9 x ≥ 6 and 9 x − y ≥ 1, for x from 0.1 to 1 and y from 0 to 5. Its front follows the first
/// constraint from x = 7/18 to 2/3, then y = 0.
#[test]
fn nsga2_finds_a_front_along_a_constraint() {
    let of = |place: &[f64]| {
        let (x, y) = (0.1 + 0.9 * place[0], 5.0 * place[1]);
        let missed = (6.0 - y - 9.0 * x).max(0.0) + (1.0 + y - 9.0 * x).max(0.0);
        Score { objectives: vec![x, (1.0 + y) / x], violation: missed }
    };
    let all = searched(nsga2(60, 80, 1), vec![0.0, 1.0], of);
    assert!(!all[0].1.is_feasible(), "the start is not");
    let found = front(&all);
    let along = |x: f64| [x, if x < 2.0 / 3.0 { (7.0 - 9.0 * x) / x } else { 1.0 / x }];
    let (first, last) = (7.0 / 18.0, 1.0);
    let known: Vec<[f64; 2]> = (0..=50).map(|k| along(first + (last - first) * f64::from(k) / 50.0)).collect();
    let off = distance(&known, &found);
    assert!(off < 0.05, "{off} of {} designs", found.len());
    for (_, score) in &found {
        let [x, value] = score.objectives[..] else { panic!("two objectives") };
        assert!(x >= first - 1e-12 && value >= along(x)[1] - 1e-9, "{x} {value}");
    }
}

fn best(all: &[(Vec<f64>, Score)]) -> &(Vec<f64>, Score) {
    let feasible = all.iter().filter(|(_, score)| score.is_feasible());
    feasible.min_by(|(_, a), (_, b)| a.objectives[0].total_cmp(&b.objectives[0])).expect("a feasible place")
}

/// Axes a thousand times as long as others, turned against the variables: only who learns the covariance gets there.
#[test]
fn cma_es_learns_the_shape_of_the_ground() {
    let of = |place: &[f64]| {
        let x: Vec<f64> = place.iter().map(|x| x - 0.4).collect();
        // Sums over a Hadamard matrix: directions at right angles, none along a variable.
        let turned = |row: usize| -> f64 {
            let sign = |column: usize| if (row & column).count_ones().is_multiple_of(2) { 1.0 } else { -1.0 };
            x.iter().enumerate().map(|(column, x)| sign(column) * x).sum::<f64>() / 8f64.sqrt()
        };
        free(&[(0..8).map(|row| 10f64.powf(6.0 * row as f64 / 7.0) * turned(row).powi(2)).sum()])
    };
    for seed in [1, 2, 3] {
        let all = searched(cma_es(10, 900, seed), vec![0.8; 8], of);
        let (place, score) = best(&all);
        assert!(score.objectives[0] < 1e-6, "seed {seed}: {score:?}");
        assert!(place.iter().all(|x| (x - 0.4).abs() < 1e-3), "{place:?}");
    }
}

/// Rosenbrock's valley in four variables, and the end of a search that has converged.
#[test]
fn cma_es_follows_a_valley_and_ends_in_it() {
    let of = |place: &[f64]| {
        let x: Vec<f64> = place.iter().map(|x| 4.0 * x - 2.0).collect();
        free(&[x.windows(2).map(|x| 100.0 * (x[1] - x[0] * x[0]).powi(2) + (1.0 - x[0]).powi(2)).sum()])
    };
    let all = searched(cma_es(12, 2000, 4), vec![0.3; 4], of);
    let (place, score) = best(&all);
    assert!(score.objectives[0] < 1e-8, "{score:?}");
    assert!(place.iter().all(|x| (x - 0.75).abs() < 1e-4), "{place:?}");
    assert!(all.len() < 12 * 1000, "it has converged after {} places", all.len());
}

/// The best lies in a corner of the cube, or where a constraint ends.
#[test]
fn cma_es_goes_to_bounds_and_constraints() {
    let corner = |place: &[f64]| free(&[place[0] + 2.0 * place[1] - place[2]]);
    let all = searched(cma_es(10, 300, 2), vec![0.5; 3], corner);
    let (place, _) = best(&all);
    assert!(place[0] < 1e-5 && place[1] < 1e-5 && place[2] > 1.0 - 1e-5, "{place:?}");

    // The nearest point of x + y ≥ 1.2 to the origin, from where the constraint is missed.
    let edge = |place: &[f64]| Score {
        objectives: vec![place[0].powi(2) + place[1].powi(2)],
        violation: (1.2 - place[0] - place[1]).max(0.0),
    };
    let all = searched(cma_es(10, 400, 3), vec![0.1, 0.2], edge);
    let (place, score) = best(&all);
    assert!((score.objectives[0] - 0.72).abs() < 1e-3, "{place:?} {score:?}");
}

#[test]
fn a_seed_decides_and_nothing_else() {
    let of = |x: &[f64]| free(&[(x[0] - 0.3).powi(2), (x[1] - 0.6).powi(2) + x[0]]);
    let one = |x: &[f64]| free(&[(x[0] - 0.3).powi(2) + x[1]]);
    assert_eq!(searched(nsga2(12, 10, 5), vec![0.5; 2], of), searched(nsga2(12, 10, 5), vec![0.5; 2], of));
    assert_ne!(searched(nsga2(12, 10, 5), vec![0.5; 2], of), searched(nsga2(12, 10, 6), vec![0.5; 2], of));
    assert_eq!(searched(cma_es(6, 10, 5), vec![0.5; 2], one), searched(cma_es(6, 10, 5), vec![0.5; 2], one));
    assert_ne!(searched(cma_es(6, 10, 5), vec![0.5; 2], one), searched(cma_es(6, 10, 6), vec![0.5; 2], one));
    assert_eq!(searched(nsga2(12, 1, 5), vec![0.5; 2], of)[0].0, [0.5, 0.5], "the start is in the first generation");
}
