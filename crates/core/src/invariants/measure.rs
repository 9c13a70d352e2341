//! Measures every invariant as a run goes by, whatever it is a run of.

use super::momentum::Books;
use super::{Finding, Invariant, Tolerances};
use crate::law::{FrictionLaw, NormalLaw, cone, friction_coefficient};
use crate::numeric::elementary::pow;
use crate::trace::{Energy, Model, Sample};

/// Slack of bounds that hold in exact arithmetic.
const ROUNDING: f64 = 1e-9;
/// Part of the energy at hand that its own sum may be off by, where a run has just begun and little of it is about.
const BOOKS: f64 = 0.01;
/// Rounding of places of up to a metre: no gap is known to less.
const PLACE_ROUNDING_M: f64 = 1e-15;

/// Two surfaces, or a joint and its stop, that can meet.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub name: String,
    pub law: NormalLaw,
    pub friction: Option<FrictionLaw>,
    /// What a depth beyond its energy breaks.
    pub depth: Invariant,
    /// Metres of a surface in one unit of the gap: 1, or of a joint the length of the arm that turns.
    pub reach_m: f64,
}

/// What a place says at one instant. For a stop, read rad for m and N·m for N.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading {
    pub gap_m: f64,
    pub gap_rate_m_s: f64,
    pub normal_n: f64,
    pub tangential_n: f64,
    pub slip_m_s: f64,
    pub impulse_n_s: f64,
}

/// A sink that measures how near a run comes to breaking each [`Invariant`].
#[derive(Clone, Debug)]
pub struct Invariants {
    model: Model,
    tolerances: Tolerances,
    places: Vec<Place>,
    /// Of an object that is free.
    books: Option<Books>,
    found: [Worst; Invariant::ALL.len()],
    start: Option<Energy>,
    /// Most energy that was ever about: kinetic, stored, dissipated, and the motor's work.
    throughput_j: f64,
    /// Largest |balance| and fall of what is dissipated, and when; judged once the throughput is known.
    imbalance: (f64, f64),
    fall: (f64, f64),
    dissipated_j: f64,
    /// Least mechanical energy beyond the motor's work so far, and the largest rise above an earlier one.
    lowest_j: f64,
    created_j: f64,
    /// Of every place.
    impulses: Vec<Impulse>,
    slips_m_s: Vec<f64>,
    gap_rates_m_s: Vec<f64>,
    last_s: f64,
    samples: u64,
}

/// The normal impulse of a place: the last, the largest, and how far and when it fell most.
#[derive(Clone, Copy, Debug, Default)]
struct Impulse {
    last: f64,
    largest: f64,
    fall: (f64, f64),
}

/// The worst of one invariant so far.
#[derive(Clone, Copy, Debug, Default)]
struct Worst {
    place: Option<usize>,
    time_s: f64,
    measured: f64,
    allowed: f64,
}

impl Invariants {
    pub(super) fn watching(model: Model, tolerances: Tolerances, places: Vec<Place>, books: Option<Books>) -> Self {
        Self {
            model,
            tolerances,
            impulses: vec![Impulse::default(); places.len()],
            slips_m_s: vec![f64::NAN; places.len()],
            gap_rates_m_s: vec![0.0; places.len()],
            places,
            books,
            found: [Worst::default(); Invariant::ALL.len()],
            start: None,
            throughput_j: 0.0,
            imbalance: (0.0, 0.0),
            fall: (0.0, 0.0),
            dissipated_j: f64::NEG_INFINITY,
            lowest_j: f64::INFINITY,
            created_j: 0.0,
            last_s: 0.0,
            samples: 0,
        }
    }

    /// Samples looked at.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The same, with another part of the energy allowed to be missed.
    pub fn tolerating(mut self, energy: f64) -> Self {
        self.tolerances.energy = energy;
        self
    }

    /// Mechanical energy from nowhere so far, in J: the largest rise beyond the motor's work above any earlier instant.
    /// What a model says it dissipated does not enter, so that errors in that sum cannot pass for creation.
    pub fn created_j(&self) -> f64 {
        self.created_j
    }

    /// Most energy that was ever about, in J.
    pub fn throughput_j(&self) -> f64 {
        self.throughput_j
    }

    /// The worst of every invariant, once the run is over; `loop_gap_m` is the largest opening of a joint in it.
    pub fn findings(mut self, loop_gap_m: f64) -> Vec<Finding> {
        let momenta = self.books.as_ref().map(Books::worst).into_iter().flatten();
        for (invariant, found) in [Invariant::Momentum, Invariant::AngularMomentum].into_iter().zip(momenta) {
            self.note(invariant, None, found.time_s, found.off, found.allowed);
        }
        let allowed = self.tolerances.energy * self.throughput_j;
        let (imbalance, fall, last_s) = (self.imbalance, self.fall, self.last_s);
        self.note(Invariant::Energy, None, imbalance.1, imbalance.0, allowed);
        self.note(Invariant::Passivity, None, fall.1, fall.0, allowed);
        for (index, impulse) in self.impulses.clone().into_iter().enumerate() {
            let (fall, at_s) = impulse.fall;
            let allowed = self.tolerances.energy.max(ROUNDING) * impulse.largest;
            self.note(Invariant::NoAdhesion, Some(index), at_s, fall, allowed);
        }
        self.note(Invariant::LoopGap, None, last_s, loop_gap_m, self.tolerances.loop_gap_m);
        let finding = |(invariant, worst): (Invariant, &Worst)| Finding {
            invariant,
            place: worst.place.map(|index| self.places[index].name.clone()),
            time_s: worst.time_s,
            measured: worst.measured,
            allowed: worst.allowed,
        };
        Invariant::ALL.into_iter().zip(&self.found).map(finding).collect()
    }

    /// One instant: how many of its numbers are none, its energies, and what every place says.
    pub(super) fn look(
        &mut self,
        time_s: f64,
        strange: usize,
        energy: &Energy,
        readings: impl IntoIterator<Item = Reading>,
    ) {
        self.samples += 1;
        self.last_s = time_s;
        self.note(Invariant::Finite, None, time_s, strange as f64, 0.0);
        if strange > 0 {
            return;
        }
        let start = *self.start.get_or_insert(*energy);
        self.energy(time_s, energy);
        let given = start.kinetic_j + start.elastic_j + energy.motor_work_j;
        let released = (start.gravity_j - energy.gravity_j) + (start.spring_j - energy.spring_j);
        let available_j = (1.0 + BOOKS) * (given + released) + self.tolerances.energy * self.throughput_j;
        for (index, reading) in readings.into_iter().enumerate() {
            self.place(index, &reading, time_s, available_j);
            self.friction(index, &reading, time_s);
        }
    }

    /// Momentum of the object, up to a sample whose numbers are all there.
    pub(super) fn momentum(&mut self, sample: &Sample) {
        if let Some(books) = self.books.as_mut() {
            books.enter(sample);
        }
    }

    fn note(&mut self, invariant: Invariant, place: Option<usize>, time_s: f64, measured: f64, allowed: f64) {
        let worst = &mut self.found[invariant as usize];
        if Finding::part(measured, allowed) > Finding::part(worst.measured, worst.allowed) {
            *worst = Worst { place, time_s, measured, allowed };
        }
    }

    fn energy(&mut self, time_s: f64, energy: &Energy) {
        let stored = energy.kinetic_j + energy.elastic_j + energy.dissipated_j.abs();
        let moved = energy.motor_work_j.abs() + energy.spring_j.abs() + energy.gravity_j.abs();
        self.throughput_j = self.throughput_j.max(stored).max(moved);
        worst(&mut self.imbalance, energy.balance_j.abs(), time_s);
        let own = energy.kinetic_j + energy.gravity_j + energy.spring_j + energy.elastic_j - energy.motor_work_j;
        self.lowest_j = self.lowest_j.min(own);
        self.created_j = self.created_j.max(own - self.lowest_j);
        self.dissipated_j = self.dissipated_j.max(energy.dissipated_j);
        worst(&mut self.fall, self.dissipated_j - energy.dissipated_j, time_s);
    }

    /// Depth, force and impulse.
    fn place(&mut self, index: usize, reading: &Reading, time_s: f64, available_j: f64) {
        let at = Some(index);
        let Place { law, depth, reach_m, .. } = self.places[index];
        self.note(Invariant::NoAdhesion, at, time_s, -reading.normal_n, 0.0);
        let rate_before = std::mem::replace(&mut self.gap_rates_m_s[index], reading.gap_rate_m_s);
        if reading.normal_n > 0.0 {
            let parted = reading.gap_rate_m_s.abs().max(rate_before.abs()) * self.tolerances.step_s;
            let allowed = self.tolerances.gap_m / reach_m + parted;
            self.note(Invariant::NoAdhesion, at, time_s, reading.gap_m, allowed);
        }
        let Impulse { last, largest, fall } = &mut self.impulses[index];
        let before = std::mem::replace(last, reading.impulse_n_s);
        *largest = largest.max(reading.impulse_n_s);
        worst(fall, before - reading.impulse_n_s, time_s);
        if self.tolerances.laws {
            let allowed = deepest(&law, available_j) + PLACE_ROUNDING_M / reach_m;
            self.note(depth, at, time_s, -reading.gap_m, allowed);
        }
    }

    fn friction(&mut self, index: usize, reading: &Reading, time_s: f64) {
        let at = Some(index);
        let before = std::mem::replace(&mut self.slips_m_s[index], reading.slip_m_s);
        if !self.tolerances.laws {
            return;
        }
        let Some(law) = self.places[index].friction.filter(|_| reading.normal_n > 0.0) else {
            self.note(Invariant::Friction, at, time_s, reading.tangential_n.abs(), 0.0);
            return;
        };
        let mu = reading.tangential_n / reading.normal_n;
        let slips = match self.model {
            Model::Engine if before.is_finite() => [before, reading.slip_m_s],
            _ => [reading.slip_m_s; 2],
        };
        let [least, most] = friction_range(&law, slips);
        let allowed = self.tolerances.friction;
        self.note(Invariant::Friction, at, time_s, (least - mu).max(mu - most), allowed);
        self.note(Invariant::Friction, at, time_s, mu.abs() - law.mu_static, ROUNDING);
    }
}

/// Range of F_t / F_n by the law while the slip goes from one value to another. A force of a step belongs to all of its
/// slips: near v = 0 the law can turn over within one.
fn friction_range(law: &FrictionLaw, slips_m_s: [f64; 2]) -> [f64; 2] {
    if law.bristle.is_some() {
        // What a bristle holds slip does not say: only that it is within the cone.
        let most = slips_m_s.into_iter().map(|slip| cone(law, slip).0).fold(0.0, f64::max);
        return [-most, most];
    }
    let [from, to] = [slips_m_s[0].min(slips_m_s[1]), slips_m_s[0].max(slips_m_s[1])];
    let peaks = [-law.v_static_m_s, law.v_static_m_s].into_iter().filter(|peak| (from..=to).contains(peak));
    let ratios = [from, to].into_iter().chain(peaks).map(|slip| -friction_coefficient(law, slip).0);
    ratios.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], ratio| [least.min(ratio), most.max(ratio)])
}

fn worst((most, at_s): &mut (f64, f64), measured: f64, time_s: f64) {
    if measured > *most {
        (*most, *at_s) = (measured, time_s);
    }
}

/// Depth in which the law's spring alone stores this energy; infinite where there is none to hold anything back.
fn deepest(law: &NormalLaw, energy_j: f64) -> f64 {
    let NormalLaw { stiffness_n_per_m_e: k, exponent: e, .. } = *law;
    if k > 0.0 { pow((e + 1.0) * energy_j.max(0.0) / k, (e + 1.0).recip()) * (1.0 + ROUNDING) } else { f64::INFINITY }
}
