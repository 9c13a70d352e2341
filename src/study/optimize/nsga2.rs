//! NSGA-II (Deb, Pratap, Agarwal and Meyarivan 2002) over the unit cube: non-dominated fronts, crowding distances,
//! tournaments by Deb's feasibility rules, and simulated binary crossover and polynomial mutation with bounds (Deb and
//! Agrawal 1995, as in the authors' code). Offspring never leave the cube and do not accumulate on its faces.
//!
//! Implemented here because the study needs an ask-and-tell interface: a whole generation is simulated on all cores, is
//! stored before the next one starts, and is read back when a search is resumed. The crates examined in 2026 evaluate
//! through a callback and run to completion; moors depends on about a hundred crates, and heuropt had ten releases
//! within ten days and none since.

use super::score::{Score, crowding_distances, non_dominated_fronts};
use crate::numeric::elementary::pow;
use crate::study::random::SplitMix64;

/// Crossover probability, as in the paper's code for real variables.
const CROSSOVER_PROBABILITY: f64 = 0.9;
/// Distribution index of the crossover, as in the paper's code.
const CROSSOVER_INDEX: f64 = 15.0;
/// Distribution index of the mutation, as in the paper's code.
const MUTATION_INDEX: f64 = 20.0;

/// Point of the unit cube.
type Candidate = Vec<f64>;

/// State of the search between two generations.
#[derive(Clone, Debug)]
pub struct Nsga2 {
    population: usize,
    random: SplitMix64,
    /// Parents, best first, with their front and crowding distance.
    parents: Vec<Parent>,
    pending: Vec<Candidate>,
    start: Option<Candidate>,
}

#[derive(Clone, Debug)]
struct Parent {
    candidate: Candidate,
    score: Score,
    front: usize,
    crowding: f64,
}

impl Nsga2 {
    /// Creates a search whose first generation contains `start`.
    pub fn new(start: Candidate, population: usize, seed: u64) -> Self {
        Nsga2 {
            population: population.max(4),
            random: SplitMix64::new(seed),
            parents: Vec::new(),
            pending: Vec::new(),
            start: Some(start),
        }
    }

    /// Returns the candidates of the next generation. [`tell`](Self::tell) expects their scores.
    pub fn ask(&mut self) -> Vec<Candidate> {
        self.pending = match self.start.take() {
            Some(start) => self.initial_population(start),
            None => self.offspring(),
        };
        self.pending.clone()
    }

    /// Updates the search with the scores of the last generation, in its order.
    pub fn tell(&mut self, scores: &[Score]) {
        let offspring = std::mem::take(&mut self.pending).into_iter().zip(scores.iter().cloned());
        let parents = std::mem::take(&mut self.parents).into_iter().map(|parent| (parent.candidate, parent.score));
        let all: Vec<(Candidate, Score)> = parents.chain(offspring).collect();
        let scores: Vec<&Score> = all.iter().map(|(_, score)| score).collect();
        for (front, members) in non_dominated_fronts(&scores).into_iter().enumerate() {
            let distances = crowding_distances(&scores, &members);
            let mut ranked: Vec<(usize, f64)> = members.iter().copied().zip(distances).collect();
            // The sort is stable: equal designs keep their order.
            ranked.sort_by(|(_, a), (_, b)| b.total_cmp(a));
            let vacancies = self.population - self.parents.len();
            self.parents.extend(ranked.into_iter().take(vacancies).map(|(index, crowding)| {
                let (candidate, score) = all[index].clone();
                Parent { candidate, score, front, crowding }
            }));
        }
    }

    /// Returns the start and a Latin hypercube sample: each variable has one value in each slice of its range.
    fn initial_population(&mut self, start: Candidate) -> Vec<Candidate> {
        let others = self.population - 1;
        let mut candidates = vec![vec![0.0; start.len()]; others];
        for variable in 0..start.len() {
            let mut slices: Vec<usize> = (0..others).collect();
            for last in (1..others).rev() {
                slices.swap(last, self.random.index_below(last + 1));
            }
            for (candidate, slice) in candidates.iter_mut().zip(slices) {
                candidate[variable] = (slice as f64 + self.random.uniform()) / others as f64;
            }
        }
        std::iter::once(start).chain(candidates).collect()
    }

    fn offspring(&mut self) -> Vec<Candidate> {
        let mut offspring = Vec::with_capacity(self.population + 1);
        while offspring.len() < self.population {
            let (a, b) = (self.select_parent(), self.select_parent());
            let (mut first, mut second) = (self.parents[a].candidate.clone(), self.parents[b].candidate.clone());
            if self.random.uniform() < CROSSOVER_PROBABILITY {
                crossover(&mut first, &mut second, &mut self.random);
            }
            for mut child in [first, second] {
                mutate(&mut child, &mut self.random);
                // A design that has already been simulated adds no information.
                while self.parents.iter().any(|parent| parent.candidate == child) {
                    let variable = self.random.index_below(child.len());
                    child[variable] = polynomial(child[variable], self.random.uniform());
                }
                offspring.push(child);
            }
        }
        offspring.truncate(self.population);
        offspring
    }

    /// Selects the better of two random parents: the one on the better front, or the less crowded one on the same
    /// front.
    fn select_parent(&mut self) -> usize {
        let (a, b) = (self.random.index_below(self.parents.len()), self.random.index_below(self.parents.len()));
        let key = |index: usize| (self.parents[index].front, -self.parents[index].crowding);
        let ((front_a, crowding_a), (front_b, crowding_b)) = (key(a), key(b));
        match front_a.cmp(&front_b).then(crowding_a.total_cmp(&crowding_b)) {
            std::cmp::Ordering::Greater => b,
            _ => a,
        }
    }
}

/// Applies simulated binary crossover within bounds; each variable is crossed with a probability of one half.
fn crossover(first: &mut [f64], second: &mut [f64], random: &mut SplitMix64) {
    for (first, second) in first.iter_mut().zip(second) {
        let (low, high) = (first.min(*second), first.max(*second));
        if random.uniform() >= 0.5 || high - low < 1e-14 {
            continue;
        }
        let (probability, swapped) = (random.uniform(), random.uniform() < 0.5);
        // Spread factor that keeps a child within the bound at this distance from its parent.
        let spread = |distance: f64| {
            let alpha = 2.0 - pow(1.0 + 2.0 * distance / (high - low), -(CROSSOVER_INDEX + 1.0));
            let scaled = probability * alpha;
            let base = if scaled <= 1.0 { scaled } else { 1.0 / (2.0 - scaled) };
            pow(base, 1.0 / (CROSSOVER_INDEX + 1.0))
        };
        let lower = (0.5 * (low + high - spread(low) * (high - low))).clamp(0.0, 1.0);
        let upper = (0.5 * (low + high + spread(1.0 - high) * (high - low))).clamp(0.0, 1.0);
        (*first, *second) = if swapped { (upper, lower) } else { (lower, upper) };
    }
}

/// Applies polynomial mutation within bounds; one variable is mutated on average.
fn mutate(candidate: &mut [f64], random: &mut SplitMix64) {
    let probability = 1.0 / candidate.len() as f64;
    for variable in candidate {
        if random.uniform() < probability {
            *variable = polynomial(*variable, random.uniform());
        }
    }
}

/// Returns the mutated value for a uniform random number `sample`.
fn polynomial(value: f64, sample: f64) -> f64 {
    let power = 1.0 / (MUTATION_INDEX + 1.0);
    let bound_factor = |distance: f64| pow(1.0 - distance, MUTATION_INDEX + 1.0);
    let step = if sample < 0.5 {
        pow(2.0 * sample + (1.0 - 2.0 * sample) * bound_factor(value), power) - 1.0
    } else {
        1.0 - pow(2.0 * (1.0 - sample) + (2.0 * sample - 1.0) * bound_factor(1.0 - value), power)
    };
    (value + step).clamp(0.0, 1.0)
}
