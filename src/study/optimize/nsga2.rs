//! NSGA-II (Deb, Pratap, Agarwal and Meyarivan 2002) over the unit cube: fronts and crowding, tournaments by Deb's rules of
//! feasibility, simulated binary crossover and polynomial mutation that both know the bounds (Deb and Agrawal 1995, as in the authors'
//! code), so that children never leave the cube and gather on its faces no more than they should.
//!
//! Our own, because what is wanted is a search that is asked for a whole generation and told what came of it: the generation is then
//! simulated on all cores, is on the disk before the next begins, and is read from there when the search is taken up again. The
//! crates looked at in 2026 call an evaluation back and run to their end; moors brings some hundred crates along, heuropt had ten
//! releases within ten days and none since.

use super::score::{Score, crowding, fronts};
use crate::numeric::elementary::pow;
use crate::study::random::Random;

/// Share of pairs that are crossed, and the index of its distribution: those of the paper's code for real variables.
const CROSSED: f64 = 0.9;
const CROSSOVER_INDEX: f64 = 15.0;
const MUTATION_INDEX: f64 = 20.0;

/// A place in the unit cube.
type Place = Vec<f64>;

/// The search between two generations.
#[derive(Clone, Debug)]
pub struct Nsga2 {
    population: usize,
    random: Random,
    /// The parents, best first, with what is known of them: front and crowding.
    parents: Vec<Parent>,
    asked: Vec<Place>,
    start: Option<Place>,
}

#[derive(Clone, Debug)]
struct Parent {
    place: Place,
    score: Score,
    front: usize,
    crowding: f64,
}

impl Nsga2 {
    /// A search from `start`, which is in the first generation.
    pub fn new(start: Place, population: usize, seed: u64) -> Self {
        Nsga2 {
            population: population.max(4),
            random: Random::new(seed),
            parents: Vec::new(),
            asked: Vec::new(),
            start: Some(start),
        }
    }

    /// The next generation, to be told of.
    pub fn ask(&mut self) -> Vec<Place> {
        self.asked = match self.start.take() {
            Some(start) => self.first(start),
            None => self.children(),
        };
        self.asked.clone()
    }

    /// What came of the generation that was asked for, in its order.
    pub fn tell(&mut self, scores: &[Score]) {
        let children = std::mem::take(&mut self.asked).into_iter().zip(scores.iter().cloned());
        let parents = std::mem::take(&mut self.parents).into_iter().map(|parent| (parent.place, parent.score));
        let all: Vec<(Place, Score)> = parents.chain(children).collect();
        let scores: Vec<&Score> = all.iter().map(|(_, score)| score).collect();
        for (front, of) in fronts(&scores).into_iter().enumerate() {
            let mut lonely: Vec<(usize, f64)> = of.iter().copied().zip(crowding(&scores, &of)).collect();
            // The sort is stable, so that equals stay in the order they came in.
            lonely.sort_by(|(_, a), (_, b)| b.total_cmp(a));
            let left = self.population - self.parents.len();
            self.parents.extend(lonely.into_iter().take(left).map(|(index, crowding)| {
                let (place, score) = all[index].clone();
                Parent { place, score, front, crowding }
            }));
        }
    }

    /// The start and a Latin hypercube around it: each variable has one value in each slice of its range.
    fn first(&mut self, start: Place) -> Vec<Place> {
        let others = self.population - 1;
        let mut places = vec![vec![0.0; start.len()]; others];
        for variable in 0..start.len() {
            let mut slices: Vec<usize> = (0..others).collect();
            for last in (1..others).rev() {
                slices.swap(last, self.random.below(last + 1));
            }
            for (place, slice) in places.iter_mut().zip(slices) {
                place[variable] = (slice as f64 + self.random.unit()) / others as f64;
            }
        }
        std::iter::once(start).chain(places).collect()
    }

    fn children(&mut self) -> Vec<Place> {
        let mut children = Vec::with_capacity(self.population + 1);
        while children.len() < self.population {
            let (a, b) = (self.winner(), self.winner());
            let (mut one, mut other) = (self.parents[a].place.clone(), self.parents[b].place.clone());
            if self.random.unit() < CROSSED {
                crossover(&mut one, &mut other, &mut self.random);
            }
            for mut child in [one, other] {
                mutate(&mut child, &mut self.random);
                // A design that has been simulated says nothing new.
                while self.parents.iter().any(|parent| parent.place == child) {
                    let variable = self.random.below(child.len());
                    child[variable] = polynomial(child[variable], self.random.unit());
                }
                children.push(child);
            }
        }
        children.truncate(self.population);
        children
    }

    /// The better of two parents: of the better front, or lonelier on the same.
    fn winner(&mut self) -> usize {
        let (a, b) = (self.random.below(self.parents.len()), self.random.below(self.parents.len()));
        let key = |index: usize| (self.parents[index].front, -self.parents[index].crowding);
        let ((front_a, lonely_a), (front_b, lonely_b)) = (key(a), key(b));
        match front_a.cmp(&front_b).then(lonely_a.total_cmp(&lonely_b)) {
            std::cmp::Ordering::Greater => b,
            _ => a,
        }
    }
}

/// Simulated binary crossover within bounds, of each variable with a chance of one half.
fn crossover(one: &mut [f64], other: &mut [f64], random: &mut Random) {
    for (one, other) in one.iter_mut().zip(other) {
        let (low, high) = (one.min(*other), one.max(*other));
        if random.unit() >= 0.5 || high - low < 1e-14 {
            continue;
        }
        let (chance, swapped) = (random.unit(), random.unit() < 0.5);
        // How far a child goes beyond its parent, so that none goes beyond the bound that is `room` away.
        let spread = |room: f64| {
            let alpha = 2.0 - pow(1.0 + 2.0 * room / (high - low), -(CROSSOVER_INDEX + 1.0));
            let scaled = chance * alpha;
            let base = if scaled <= 1.0 { scaled } else { 1.0 / (2.0 - scaled) };
            pow(base, 1.0 / (CROSSOVER_INDEX + 1.0))
        };
        let lower = (0.5 * (low + high - spread(low) * (high - low))).clamp(0.0, 1.0);
        let upper = (0.5 * (low + high + spread(1.0 - high) * (high - low))).clamp(0.0, 1.0);
        (*one, *other) = if swapped { (upper, lower) } else { (lower, upper) };
    }
}

/// Polynomial mutation within bounds, of one variable on average.
fn mutate(place: &mut [f64], random: &mut Random) {
    let share = 1.0 / place.len() as f64;
    for variable in place {
        if random.unit() < share {
            *variable = polynomial(*variable, random.unit());
        }
    }
}

fn polynomial(value: f64, chance: f64) -> f64 {
    let power = 1.0 / (MUTATION_INDEX + 1.0);
    let kept = |room: f64| pow(1.0 - room, MUTATION_INDEX + 1.0);
    let step = if chance < 0.5 {
        pow(2.0 * chance + (1.0 - 2.0 * chance) * kept(value), power) - 1.0
    } else {
        1.0 - pow(2.0 * (1.0 - chance) + (2.0 * chance - 1.0) * kept(1.0 - value), power)
    };
    (value + step).clamp(0.0, 1.0)
}
