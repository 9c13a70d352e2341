//! Ask-and-tell interface of both search algorithms.

use super::cmaes::CmaEs;
use super::nsga2::Nsga2;
use super::problem::{Algorithm, Method};
use super::score::Score;

/// State of a search between two generations. Candidates are points of the unit cube; equal seeds give equal
/// candidates.
#[derive(Clone, Debug)]
pub enum Search {
    Nsga2(Nsga2),
    CmaEs(Box<CmaEs>),
}

impl Search {
    /// Creates a search whose first generation contains `start`.
    pub fn new(method: &Method, start: Vec<f64>) -> Self {
        let population = usize::try_from(method.population).unwrap_or(usize::MAX);
        match method.algorithm {
            Algorithm::Nsga2 => Search::Nsga2(Nsga2::new(start, population, method.seed)),
            Algorithm::CmaEs => Search::CmaEs(Box::new(CmaEs::new(start, population, method.seed))),
        }
    }

    /// Returns the candidates of the next generation.
    pub fn ask(&mut self) -> Vec<Vec<f64>> {
        match self {
            Search::Nsga2(search) => search.ask(),
            Search::CmaEs(search) => search.ask(),
        }
    }

    /// Updates the search with the scores of the last generation, in its order.
    pub fn tell(&mut self, scores: &[Score]) {
        match self {
            Search::Nsga2(search) => search.tell(scores),
            Search::CmaEs(search) => search.tell(scores),
        }
    }

    /// Returns whether the search has converged; always `false` for NSGA-II.
    pub fn has_converged(&self) -> bool {
        match self {
            Search::Nsga2(_) => false,
            Search::CmaEs(search) => search.has_converged(),
        }
    }
}
