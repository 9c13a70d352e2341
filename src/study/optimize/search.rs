//! A search by either algorithm: asked for a generation, told what came of it.

use super::cmaes::CmaEs;
use super::nsga2::Nsga2;
use super::problem::{Algorithm, Method};
use super::score::Score;

/// A search between two generations. Places are within the unit cube; equal seeds ask for equal places.
#[derive(Clone, Debug)]
pub enum Search {
    Nsga2(Nsga2),
    CmaEs(Box<CmaEs>),
}

impl Search {
    /// A search from a place, which is in its first generation.
    pub fn new(method: &Method, start: Vec<f64>) -> Self {
        let population = usize::try_from(method.population).unwrap_or(usize::MAX);
        match method.algorithm {
            Algorithm::Nsga2 => Search::Nsga2(Nsga2::new(start, population, method.seed)),
            Algorithm::CmaEs => Search::CmaEs(Box::new(CmaEs::new(start, population, method.seed))),
        }
    }

    /// The places of the next generation.
    pub fn ask(&mut self) -> Vec<Vec<f64>> {
        match self {
            Search::Nsga2(search) => search.ask(),
            Search::CmaEs(search) => search.ask(),
        }
    }

    /// What came of the places asked for, in their order.
    pub fn tell(&mut self, scores: &[Score]) {
        match self {
            Search::Nsga2(search) => search.tell(scores),
            Search::CmaEs(search) => search.tell(scores),
        }
    }

    /// Whether there is nothing left to find. NSGA-II never says so.
    pub fn is_over(&self) -> bool {
        match self {
            Search::Nsga2(_) => false,
            Search::CmaEs(search) => search.is_over(),
        }
    }
}
