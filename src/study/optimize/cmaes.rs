//! CMA-ES with weighted recombination, cumulative step-size adaptation, and the rank-one and rank-µ updates (Hansen, "The CMA
//! evolution strategy: a tutorial", 2016: its default parameters, positive weights) over the unit cube.
//!
//! Bounds: a sample outside the cube is drawn again, a hundred times at most, then moved to the nearest face; what the search is told
//! is of the place that was simulated, and so is what it learns from. Constraints: places are ranked by Deb's rules of feasibility,
//! which is all that the strategy asks of values.
//!
//! Our own for the reason said in `nsga2`: of the crates there are, cmaes calls an evaluation back one by one or on threads of its own,
//! cannot be asked for a generation, and brings a second linear algebra, random numbers and statistics along; the update of the
//! covariance in heuropt divides by the step size of the next generation. The eigenvalues are nalgebra's.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::score::{Score, better};
use crate::numeric::elementary::{exp, ln, powi};
use crate::study::random::Random;

/// First step size, in shares of the ranges: about a third, so that the first samples reach all of the cube from its middle.
const FIRST_STEP: f64 = 0.3;
/// The search has converged when the largest deviation is less than this share of a range: far below what any part is made to.
const CONVERGED: f64 = 1e-6;
/// Samples that may be drawn for one place within the cube.
const DRAWS: usize = 100;

/// The search between two generations.
#[derive(Clone, Debug)]
pub struct CmaEs {
    population: usize,
    random: Random,
    /// Weights of the best half.
    weights: Vec<f64>,
    rates: Rates,
    mean: DVector<f64>,
    step: f64,
    covariance: DMatrix<f64>,
    /// Directions and deviations: columns and the roots of the eigenvalues.
    axes: DMatrix<f64>,
    deviations: DVector<f64>,
    /// Of the step size and of the covariance.
    paths: [DVector<f64>; 2],
    generation: i32,
    asked: Vec<DVector<f64>>,
    begun: bool,
}

/// What the strategy learns by.
#[derive(Clone, Copy, Debug)]
struct Rates {
    effective: f64,
    sigma: f64,
    damping: f64,
    path: f64,
    one: f64,
    many: f64,
    /// Expected length of a normal vector.
    length: f64,
}

impl CmaEs {
    /// A search from `start`, which alone is the first generation.
    pub fn new(start: Vec<f64>, population: usize, seed: u64) -> Self {
        let (n, population) = (start.len(), population.max(4));
        let half = population / 2;
        let raw: Vec<f64> = (1..=half).map(|rank| ln(0.5 * (population as f64 + 1.0)) - ln(rank as f64)).collect();
        let sum: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|weight| weight / sum).collect();
        let rates = Rates::new(n as f64, 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>());
        CmaEs {
            population,
            random: Random::new(seed),
            weights,
            rates,
            mean: DVector::from_vec(start),
            step: FIRST_STEP,
            covariance: DMatrix::identity(n, n),
            axes: DMatrix::identity(n, n),
            deviations: DVector::repeat(n, 1.0),
            paths: [DVector::zeros(n), DVector::zeros(n)],
            generation: 0,
            asked: Vec::new(),
            begun: false,
        }
    }

    /// Samples of a generation for so many variables (4 + ⌊3 ln n⌋, equation 48).
    pub fn usual_population(variables: usize) -> usize {
        4 + (3.0 * ln(variables as f64)).floor() as usize
    }

    /// The next generation, to be told of.
    pub fn ask(&mut self) -> Vec<Vec<f64>> {
        if !self.begun {
            return vec![self.mean.as_slice().to_vec()];
        }
        self.asked = (0..self.population).map(|_| self.sample()).collect();
        self.asked.iter().map(|place| place.as_slice().to_vec()).collect()
    }

    fn sample(&mut self) -> DVector<f64> {
        let mut place = self.mean.clone();
        for _ in 0..DRAWS {
            let normal = DVector::from_fn(self.mean.len(), |_, _| self.random.normal());
            place = &self.mean + &self.axes * self.deviations.component_mul(&normal) * self.step;
            if place.iter().all(|x| (0.0..=1.0).contains(x)) {
                return place;
            }
        }
        place.map(|x| x.clamp(0.0, 1.0))
    }

    /// What came of the generation that was asked for, in its order.
    pub fn tell(&mut self, scores: &[Score]) {
        if !std::mem::replace(&mut self.begun, true) {
            return;
        }
        let mut order: Vec<usize> = (0..self.asked.len()).collect();
        order.sort_by(|&a, &b| better(&scores[a], &scores[b]));
        // Steps of the best half from the mean that they were drawn around, in units of the step size.
        let best: Vec<DVector<f64>> =
            order.iter().take(self.weights.len()).map(|&at| (&self.asked[at] - &self.mean) / self.step).collect();
        let n = self.mean.len();
        let weighted = self.weights.iter().zip(&best);
        let shift = weighted.clone().fold(DVector::zeros(n), |sum, (weight, step)| sum + step * *weight);
        self.mean += &shift * self.step;
        self.generation += 1;

        let Rates { effective, sigma, damping, path, one, many, length } = self.rates;
        // The shift in coordinates in which the distribution is round.
        let round = &self.axes * (self.axes.transpose() * &shift).component_div(&self.deviations);
        self.paths[0] = &self.paths[0] * (1.0 - sigma) + round * (sigma * (2.0 - sigma) * effective).sqrt();
        let long = self.paths[0].norm();
        let settled = (1.0 - powi(1.0 - sigma, 2 * self.generation)).sqrt();
        let stalled = if long / settled < (1.4 + 2.0 / (n as f64 + 1.0)) * length { 1.0 } else { 0.0 };
        self.paths[1] = &self.paths[1] * (1.0 - path) + shift * (stalled * (path * (2.0 - path) * effective).sqrt());
        let lost = (1.0 - stalled) * path * (2.0 - path);
        let rank_one = &self.paths[1] * self.paths[1].transpose();
        let rank_many =
            weighted.fold(DMatrix::zeros(n, n), |sum, (weight, step)| sum + step * step.transpose() * *weight);
        self.covariance = &self.covariance * (1.0 - one - many + one * lost) + rank_one * one + rank_many * many;
        self.step *= exp((sigma / damping) * (long / length - 1.0)).min(std::f64::consts::E);
        // Wider than the cube there is nothing to find.
        self.step = self.step.min(1.0);

        let eigen = SymmetricEigen::new(self.covariance.clone());
        self.axes = eigen.eigenvectors;
        self.deviations = eigen.eigenvalues.map(|value| value.max(1e-20).sqrt());
    }

    /// Whether there is nothing left to find: all samples lie within a millionth of the ranges.
    pub fn is_over(&self) -> bool {
        self.begun && self.step * self.deviations.max() < CONVERGED
    }
}

impl Rates {
    /// For n variables and so many effective samples (table 1 of the tutorial).
    fn new(n: f64, effective: f64) -> Self {
        let sigma = (effective + 2.0) / (n + effective + 5.0);
        let one = 2.0 / (powi(n + 1.3, 2) + effective);
        Rates {
            effective,
            sigma,
            damping: 1.0 + 2.0 * (((effective - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + sigma,
            path: (4.0 + effective / n) / (n + 4.0 + 2.0 * effective / n),
            one,
            many: (1.0 - one).min(2.0 * (effective - 2.0 + 1.0 / effective) / (powi(n + 2.0, 2) + effective)),
            length: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
        }
    }
}
