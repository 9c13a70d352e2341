//! Measures every invariant while a run progresses.

use super::momentum::{FreeBody, MomentumBalance};
use super::{Finding, Invariant, Tolerances};
use crate::law::{FrictionLaw, NormalLaw, friction_coefficient, friction_cone};
use crate::numeric::elementary::pow;
use crate::scene::{ContactId, DiscMotion, Scene, Side, System};
use crate::trace::{ContactSample, Energy, Model, Sample, Sink, SinkError};

/// Tolerance for limits that hold in exact arithmetic.
const ROUNDING: f64 = 1e-9;
/// Relative tolerance of the available energy, which is a difference of large numbers at the start of a run.
const ENERGY_SUM_TOLERANCE: f64 = 0.01;
/// Rounding error of positions up to a metre, which bounds the accuracy of gaps.
const POSITION_ROUNDING_M: f64 = 1e-15;

/// A contact of two surfaces, or of a joint with its stop.
#[derive(Clone, Debug)]
struct MonitoredContact {
    name: String,
    law: NormalLaw,
    friction: Option<FrictionLaw>,
    /// Invariant that an excessive depth violates.
    depth: Invariant,
    /// Surface displacement per unit of the gap: 1 between surfaces; for a joint stop, whose gap is an angle, the arm
    /// length in m.
    reach_m: f64,
}

/// A sink that measures how close a run comes to violating each [`Invariant`].
#[derive(Clone, Debug)]
pub struct Invariants {
    model: Model,
    tolerances: Tolerances,
    contacts: Vec<MonitoredContact>,
    /// Momentum balance of a free object.
    momentum_balance: Option<MomentumBalance>,
    /// Worst values so far, in the order of [`Invariant::ALL`].
    worst: [Violation; Invariant::ALL.len()],
    start: Option<Energy>,
    /// Largest energy in the run so far: kinetic, stored, dissipated, and the work of the motor.
    throughput_j: f64,
    /// Largest |balance| and its time; evaluated at the end, when the throughput is known.
    max_imbalance: (f64, f64),
    /// Largest decrease of the dissipated energy and its time; also evaluated at the end.
    decrease: (f64, f64),
    dissipated_j: f64,
    /// Smallest mechanical energy minus the motor's work so far.
    lowest_j: f64,
    /// Largest increase of that difference above an earlier value.
    created_j: f64,
    /// Normal impulse of every contact.
    impulses: Vec<Impulse>,
    /// Slip of every contact in the last sample.
    slips_m_s: Vec<f64>,
    /// Gap rate of every contact in the last sample.
    gap_rates_m_s: Vec<f64>,
    last_s: f64,
    samples: u64,
}

/// Normal impulse of a contact: last value, largest value, and largest decrease with its time.
#[derive(Clone, Copy, Debug, Default)]
struct Impulse {
    last: f64,
    largest: f64,
    decrease: (f64, f64),
}

/// Value of an invariant that is closest to its limit, or furthest beyond it.
#[derive(Clone, Copy, Debug, Default)]
struct Violation {
    contact_index: Option<usize>,
    time_s: f64,
    measured: f64,
    allowed: f64,
}

impl Invariants {
    /// Measures a run of `scene` with `model`, with the tolerances of its settings.
    pub fn new(model: Model, scene: &Scene) -> Self {
        let system = &scene.system;
        // Discs have no joints that could open.
        let loop_gap_m = if system.fingers.is_empty() { 0.0 } else { scene.bounds.loop_gap_m };
        let tolerances = Tolerances::for_settings(model, &scene.integrator, &scene.engine, loop_gap_m);
        // Momentum is not conserved in a moving frame. The engine's forces are averages over steps, so their impulses
        // between samples are not known accurately enough.
        let free_object = object(system).filter(|_| system.palm_motion.is_none() && model == Model::Analytic);
        let contacts = monitored_contacts(system);
        Self {
            model,
            tolerances,
            impulses: vec![Impulse::default(); contacts.len()],
            slips_m_s: vec![f64::NAN; contacts.len()],
            gap_rates_m_s: vec![0.0; contacts.len()],
            contacts,
            momentum_balance: free_object
                .map(|(body, friction_laws)| MomentumBalance::new(tolerances.energy, body, friction_laws)),
            worst: [Violation::default(); Invariant::ALL.len()],
            start: None,
            throughput_j: 0.0,
            max_imbalance: (0.0, 0.0),
            decrease: (0.0, 0.0),
            dissipated_j: f64::NEG_INFINITY,
            lowest_j: f64::INFINITY,
            created_j: 0.0,
            last_s: 0.0,
            samples: 0,
        }
    }

    /// Number of samples measured.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Replaces the part of the energy that may be missing.
    pub fn with_energy_tolerance(mut self, energy: f64) -> Self {
        self.tolerances.energy = energy;
        self
    }

    /// Mechanical energy created so far, J: the largest increase beyond the motor's work above any earlier instant. The
    /// dissipated energy is not used, so an error in that sum cannot hide created energy.
    pub fn created_j(&self) -> f64 {
        self.created_j
    }

    /// Largest energy in the run so far, J.
    pub fn throughput_j(&self) -> f64 {
        self.throughput_j
    }

    /// Returns the worst value of every invariant at the end of a run; `loop_gap_m` is the largest opening of a joint.
    pub fn findings(mut self, loop_gap_m: f64) -> Vec<Finding> {
        let momenta = self.momentum_balance.as_ref().map(MomentumBalance::worst).into_iter().flatten();
        for (invariant, imbalance) in [Invariant::Momentum, Invariant::AngularMomentum].into_iter().zip(momenta) {
            self.update(invariant, None, imbalance.time_s, imbalance.error, imbalance.allowed);
        }
        let allowed = self.tolerances.energy * self.throughput_j;
        let (max_imbalance, decrease, last_s) = (self.max_imbalance, self.decrease, self.last_s);
        self.update(Invariant::Energy, None, max_imbalance.1, max_imbalance.0, allowed);
        self.update(Invariant::Passivity, None, decrease.1, decrease.0, allowed);
        for (index, impulse) in self.impulses.clone().into_iter().enumerate() {
            let (decrease, at_s) = impulse.decrease;
            let allowed = self.tolerances.energy.max(ROUNDING) * impulse.largest;
            self.update(Invariant::NoAdhesion, Some(index), at_s, decrease, allowed);
        }
        self.update(Invariant::LoopGap, None, last_s, loop_gap_m, self.tolerances.loop_gap_m);
        let finding = |(invariant, worst): (Invariant, &Violation)| Finding {
            invariant,
            contact: worst.contact_index.map(|index| self.contacts[index].name.clone()),
            time_s: worst.time_s,
            measured: worst.measured,
            allowed: worst.allowed,
        };
        Invariant::ALL.into_iter().zip(&self.worst).map(finding).collect()
    }

    /// Records one instant: the number of non-finite values, the energies, and the state of every contact.
    fn record(
        &mut self,
        time_s: f64,
        non_finite: usize,
        energy: &Energy,
        contacts: impl IntoIterator<Item = ContactSample>,
    ) {
        self.samples += 1;
        self.last_s = time_s;
        self.update(Invariant::Finite, None, time_s, non_finite as f64, 0.0);
        if non_finite > 0 {
            return;
        }
        let start = *self.start.get_or_insert(*energy);
        self.energy(time_s, energy);
        let supplied_j = start.kinetic_j + start.elastic_j + energy.motor_work_j;
        let released_j = (start.gravity_j - energy.gravity_j) + (start.spring_j - energy.spring_j);
        let available_j =
            (1.0 + ENERGY_SUM_TOLERANCE) * (supplied_j + released_j) + self.tolerances.energy * self.throughput_j;
        for (index, values) in contacts.into_iter().enumerate() {
            self.contact(index, &values, time_s, available_j);
            self.friction(index, &values, time_s);
        }
    }

    /// Replaces the worst value of an invariant by this one if it is worse.
    fn update(&mut self, invariant: Invariant, contact_index: Option<usize>, time_s: f64, measured: f64, allowed: f64) {
        let worst = &mut self.worst[invariant as usize];
        if Finding::fraction_of_limit(measured, allowed) > Finding::fraction_of_limit(worst.measured, worst.allowed) {
            *worst = Violation { contact_index, time_s, measured, allowed };
        }
    }

    /// Measures the energies.
    fn energy(&mut self, time_s: f64, energy: &Energy) {
        let stored_j = energy.kinetic_j + energy.elastic_j + energy.dissipated_j.abs();
        let exchanged_j = energy.motor_work_j.abs() + energy.spring_j.abs() + energy.gravity_j.abs();
        self.throughput_j = self.throughput_j.max(stored_j).max(exchanged_j);
        record_max(&mut self.max_imbalance, energy.balance_j.abs(), time_s);
        let mechanical_j =
            energy.kinetic_j + energy.gravity_j + energy.spring_j + energy.elastic_j - energy.motor_work_j;
        self.lowest_j = self.lowest_j.min(mechanical_j);
        self.created_j = self.created_j.max(mechanical_j - self.lowest_j);
        self.dissipated_j = self.dissipated_j.max(energy.dissipated_j);
        record_max(&mut self.decrease, self.dissipated_j - energy.dissipated_j, time_s);
    }

    /// Measures depth, force and impulse of a contact.
    fn contact(&mut self, index: usize, values: &ContactSample, time_s: f64, available_j: f64) {
        let contact = Some(index);
        let MonitoredContact { law, depth, reach_m, .. } = self.contacts[index];
        self.update(Invariant::NoAdhesion, contact, time_s, -values.normal_n, 0.0);
        let previous_rate = std::mem::replace(&mut self.gap_rates_m_s[index], values.gap_rate_m_s);
        if values.normal_n > 0.0 {
            let opening = values.gap_rate_m_s.abs().max(previous_rate.abs()) * self.tolerances.step_s;
            let allowed = self.tolerances.gap_m / reach_m + opening;
            self.update(Invariant::NoAdhesion, contact, time_s, values.gap_m, allowed);
        }
        let Impulse { last, largest, decrease } = &mut self.impulses[index];
        let previous = std::mem::replace(last, values.impulse_n_s);
        *largest = largest.max(values.impulse_n_s);
        record_max(decrease, previous - values.impulse_n_s, time_s);
        if self.tolerances.laws {
            let allowed = max_depth(&law, available_j) + POSITION_ROUNDING_M / reach_m;
            self.update(depth, contact, time_s, -values.gap_m, allowed);
        }
    }

    /// Measures the friction of a contact.
    fn friction(&mut self, index: usize, values: &ContactSample, time_s: f64) {
        let contact = Some(index);
        let previous = std::mem::replace(&mut self.slips_m_s[index], values.slip_m_s);
        if !self.tolerances.laws {
            return;
        }
        let Some(law) = self.contacts[index].friction.filter(|_| values.normal_n > 0.0) else {
            self.update(Invariant::Friction, contact, time_s, values.tangential_n.abs(), 0.0);
            return;
        };
        let mu = values.tangential_n / values.normal_n;
        let slips = match self.model {
            Model::Engine if previous.is_finite() => [previous, values.slip_m_s],
            _ => [values.slip_m_s; 2],
        };
        let [lower, upper] = friction_range(&law, slips);
        let allowed = self.tolerances.friction;
        self.update(Invariant::Friction, contact, time_s, (lower - mu).max(mu - upper), allowed);
        self.update(Invariant::Friction, contact, time_s, mu.abs() - law.mu_static, ROUNDING);
    }
}

/// Range of F_t / F_n by the law while the slip changes between two values. A force of a step belongs to all slips of
/// that step: near v = 0 the law can reverse within one step.
fn friction_range(law: &FrictionLaw, slips_m_s: [f64; 2]) -> [f64; 2] {
    if law.bristle.is_some() {
        // The slip does not determine the force of a bristle, which is only bounded by the cone.
        let limit = slips_m_s.into_iter().map(|slip| friction_cone(law, slip).0).fold(0.0, f64::max);
        return [-limit, limit];
    }
    let [from, to] = [slips_m_s[0].min(slips_m_s[1]), slips_m_s[0].max(slips_m_s[1])];
    let peaks = [-law.v_static_m_s, law.v_static_m_s].into_iter().filter(|peak| (from..=to).contains(peak));
    let ratios = [from, to].into_iter().chain(peaks).map(|slip| -friction_coefficient(law, slip).0);
    ratios.fold([f64::INFINITY, f64::NEG_INFINITY], |[lower, upper], ratio| [lower.min(ratio), upper.max(ratio)])
}

/// Updates a maximum and its time.
fn record_max((max, at_s): &mut (f64, f64), measured: f64, time_s: f64) {
    if measured > *max {
        (*max, *at_s) = (measured, time_s);
    }
}

/// Depth at which the spring of the law alone stores this energy; infinite without a spring.
fn max_depth(law: &NormalLaw, energy_j: f64) -> f64 {
    let NormalLaw { stiffness_n_per_m_e: k, exponent: e, .. } = *law;
    if k > 0.0 { pow((e + 1.0) * energy_j.max(0.0) / k, (e + 1.0).recip()) * (1.0 + ROUNDING) } else { f64::INFINITY }
}

impl Sink for Invariants {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        // An infinite gap belongs to a contact that the scene does not have.
        let existing = sample.contacts().filter(|contact| contact.gap_m != f64::INFINITY);
        let non_finite = non_finite(sample);
        self.record(sample.time_s, non_finite, &sample.energy(), existing);
        if non_finite == 0 {
            self.momentum_balance.iter_mut().for_each(|balance| balance.record(sample));
        }
        Ok(())
    }
}

/// All contacts of a system.
fn monitored_contacts(system: &System) -> Vec<MonitoredContact> {
    let surface = |name: String, (law, friction): (NormalLaw, Option<FrictionLaw>)| MonitoredContact {
        name,
        law,
        friction,
        depth: Invariant::Penetration,
        reach_m: 1.0,
    };
    let stop = |name: String, side: Side| {
        let (law, reach_m) = (system.finger(side).limit?, system.finger(side).linkage.lengths.l22_m);
        Some(MonitoredContact { name, law, friction: None, depth: Invariant::JointLimit, reach_m })
    };
    let monitored = |contact| match contact {
        ContactId::Stop(side) => stop(system.contact_name(contact), side),
        _ => system.contact_laws(contact).map(|law| surface(system.contact_name(contact), law)),
    };
    system.contact_ids().into_iter().filter_map(monitored).collect()
}

/// Returns a free object that is the only disc, and the friction law of every contact.
fn object(system: &System) -> Option<(FreeBody, Vec<Option<FrictionLaw>>)> {
    let object = system.object().filter(|_| system.discs.len() == 1)?;
    let DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), .. } = object.motion else {
        return None;
    };
    let friction_laws = system
        .contact_ids()
        .into_iter()
        .map(|touching| system.contact_laws(touching).and_then(|(_, friction)| friction));
    Some((FreeBody { mass_kg, inertia_kg_m2, gravity_m_s2: system.gravity_m_s2 }, friction_laws.collect()))
}

/// Number of values that are not finite. An infinite gap belongs to a missing contact and does not count.
fn non_finite(sample: &Sample) -> usize {
    let missing_gaps = sample.contacts().filter(|contact| contact.gap_m == f64::INFINITY).count();
    let all = sample.values().iter().chain([&sample.time_s]);
    all.filter(|number| !number.is_finite()).count() - missing_gaps
}
