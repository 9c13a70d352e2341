//! CMA-ES over the unit cube with weighted recombination, cumulative step-size adaptation, and rank-one and rank-µ
//! updates (Hansen, "The CMA evolution strategy: a tutorial", 2016, with its default parameters and positive weights).
//!
//! Bounds: a sample outside the cube is redrawn at most a hundred times and then projected onto the nearest face. The
//! update uses the projected sample, which is the one that was simulated. Constraints: samples are ranked by Deb's
//! feasibility rules; the strategy needs only a ranking.
//!
//! Implemented here for the reasons given in `nsga2`: the crate cmaes evaluates samples through a callback, one by one
//! or on its own threads, cannot return a whole generation, and depends on a second set of crates for linear algebra,
//! random numbers and statistics; the covariance update in heuropt divides by the step size of the next generation.
//! Eigenvalues are computed by nalgebra.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::score::{Score, compare};
use crate::numeric::elementary::{exp, ln, powi};
use crate::study::random::SplitMix64;

/// Initial step size relative to the ranges: about a third, so that the first samples cover the whole cube from its
/// centre.
const INITIAL_STEP_SIZE: f64 = 0.3;
/// The search has converged when the largest standard deviation is below this fraction of a range, far below
/// manufacturing tolerances.
const CONVERGENCE_TOLERANCE: f64 = 1e-6;
/// Maximum number of draws for a sample within the cube.
const MAX_RESAMPLES: usize = 100;

/// State of the search between two generations.
#[derive(Clone, Debug)]
pub struct CmaEs {
    population: usize,
    random: SplitMix64,
    /// Recombination weights of the better half.
    weights: Vec<f64>,
    parameters: StrategyParameters,
    mean: DVector<f64>,
    step: f64,
    covariance: DMatrix<f64>,
    /// Principal axes of the distribution: eigenvectors of the covariance as columns.
    axes: DMatrix<f64>,
    /// Square roots of the eigenvalues of the covariance.
    deviations: DVector<f64>,
    /// Evolution paths of the step size and of the covariance.
    paths: [DVector<f64>; 2],
    generation: i32,
    /// Samples of the current generation, without scores yet.
    pending: Vec<DVector<f64>>,
    /// Whether the start has been scored.
    has_started: bool,
}

/// Strategy parameters (table 1 of the tutorial).
#[derive(Clone, Copy, Debug)]
struct StrategyParameters {
    /// Variance-effective selection mass.
    mu_eff: f64,
    /// Learning rate of the step-size path.
    c_sigma: f64,
    /// Damping of the step-size update.
    d_sigma: f64,
    /// Learning rate of the covariance path.
    c_c: f64,
    /// Learning rate of the rank-one update.
    c_1: f64,
    /// Learning rate of the rank-µ update.
    c_mu: f64,
    /// Expected norm of a standard normal vector.
    chi_n: f64,
}

impl CmaEs {
    /// Creates a search whose first generation contains only `start`.
    pub fn new(start: Vec<f64>, population: usize, seed: u64) -> Self {
        let (n, population) = (start.len(), population.max(4));
        let half = population / 2;
        let raw: Vec<f64> = (1..=half).map(|rank| ln(0.5 * (population as f64 + 1.0)) - ln(rank as f64)).collect();
        let sum: f64 = raw.iter().sum();
        let weights: Vec<f64> = raw.iter().map(|weight| weight / sum).collect();
        let parameters =
            StrategyParameters::new(n as f64, 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>());
        CmaEs {
            population,
            random: SplitMix64::new(seed),
            weights,
            parameters,
            mean: DVector::from_vec(start),
            step: INITIAL_STEP_SIZE,
            covariance: DMatrix::identity(n, n),
            axes: DMatrix::identity(n, n),
            deviations: DVector::repeat(n, 1.0),
            paths: [DVector::zeros(n), DVector::zeros(n)],
            generation: 0,
            pending: Vec::new(),
            has_started: false,
        }
    }

    /// Returns the default number of samples per generation for n variables: 4 + ⌊3 ln n⌋ (equation 48).
    pub fn default_population(variables: usize) -> usize {
        4 + (3.0 * ln(variables as f64)).floor() as usize
    }

    /// Returns the candidates of the next generation. [`tell`](Self::tell) expects their scores.
    pub fn ask(&mut self) -> Vec<Vec<f64>> {
        if !self.has_started {
            return vec![self.mean.as_slice().to_vec()];
        }
        self.pending = (0..self.population).map(|_| self.sample()).collect();
        self.pending.iter().map(|candidate| candidate.as_slice().to_vec()).collect()
    }

    fn sample(&mut self) -> DVector<f64> {
        let mut candidate = self.mean.clone();
        for _ in 0..MAX_RESAMPLES {
            let normal = DVector::from_fn(self.mean.len(), |_, _| self.random.normal());
            candidate = &self.mean + &self.axes * self.deviations.component_mul(&normal) * self.step;
            if candidate.iter().all(|x| (0.0..=1.0).contains(x)) {
                return candidate;
            }
        }
        candidate.map(|x| x.clamp(0.0, 1.0))
    }

    /// Updates the search with the scores of the last generation, in its order.
    pub fn tell(&mut self, scores: &[Score]) {
        if !std::mem::replace(&mut self.has_started, true) {
            return;
        }
        let mut order: Vec<usize> = (0..self.pending.len()).collect();
        order.sort_by(|&a, &b| compare(&scores[a], &scores[b]));
        // Steps of the better half from the mean of their distribution, in units of the step size.
        let best: Vec<DVector<f64>> = order
            .iter()
            .take(self.weights.len())
            .map(|&index| (&self.pending[index] - &self.mean) / self.step)
            .collect();
        let n = self.mean.len();
        let weighted = self.weights.iter().zip(&best);
        let shift = weighted.clone().fold(DVector::zeros(n), |sum, (weight, step)| sum + step * *weight);
        self.mean += &shift * self.step;
        self.generation += 1;

        let StrategyParameters { mu_eff, c_sigma, d_sigma, c_c, c_1, c_mu, chi_n } = self.parameters;
        // Shift in coordinates in which the distribution is isotropic.
        let whitened = &self.axes * (self.axes.transpose() * &shift).component_div(&self.deviations);
        self.paths[0] = &self.paths[0] * (1.0 - c_sigma) + whitened * (c_sigma * (2.0 - c_sigma) * mu_eff).sqrt();
        let path_norm = self.paths[0].norm();
        let path_scale = (1.0 - powi(1.0 - c_sigma, 2 * self.generation)).sqrt();
        let h_sigma = if path_norm / path_scale < (1.4 + 2.0 / (n as f64 + 1.0)) * chi_n { 1.0 } else { 0.0 };
        self.paths[1] = &self.paths[1] * (1.0 - c_c) + shift * (h_sigma * (c_c * (2.0 - c_c) * mu_eff).sqrt());
        let delta_h = (1.0 - h_sigma) * c_c * (2.0 - c_c);
        let rank_one = &self.paths[1] * self.paths[1].transpose();
        let rank_mu =
            weighted.fold(DMatrix::zeros(n, n), |sum, (weight, step)| sum + step * step.transpose() * *weight);
        self.covariance = &self.covariance * (1.0 - c_1 - c_mu + c_1 * delta_h) + rank_one * c_1 + rank_mu * c_mu;
        self.step *= exp((c_sigma / d_sigma) * (path_norm / chi_n - 1.0)).min(std::f64::consts::E);
        // A step size above the width of the cube is useless.
        self.step = self.step.min(1.0);

        let eigen = SymmetricEigen::new(self.covariance.clone());
        self.axes = eigen.eigenvectors;
        self.deviations = eigen.eigenvalues.map(|value| value.max(1e-20).sqrt());
    }

    /// Returns whether the search has converged: all samples lie within a millionth of the ranges.
    pub fn has_converged(&self) -> bool {
        self.has_started && self.step * self.deviations.max() < CONVERGENCE_TOLERANCE
    }
}

impl StrategyParameters {
    /// Default parameters for n variables and the selection mass `mu_eff` (table 1 of the tutorial).
    fn new(n: f64, mu_eff: f64) -> Self {
        let c_sigma = (mu_eff + 2.0) / (n + mu_eff + 5.0);
        let c_1 = 2.0 / (powi(n + 1.3, 2) + mu_eff);
        StrategyParameters {
            mu_eff,
            c_sigma,
            d_sigma: 1.0 + 2.0 * (((mu_eff - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + c_sigma,
            c_c: (4.0 + mu_eff / n) / (n + 4.0 + 2.0 * mu_eff / n),
            c_1,
            c_mu: (1.0 - c_1).min(2.0 * (mu_eff - 2.0 + 1.0 / mu_eff) / (powi(n + 2.0, 2) + mu_eff)),
            chi_n: n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
        }
    }
}
