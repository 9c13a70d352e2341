//! Measures every invariant while a run progresses.

use super::{Finding, Invariant, Tolerances, update_max};
use crate::law::{FrictionLaw, NormalLaw, friction_coefficient};
use crate::mechanism::Limited;
use crate::numeric::elementary::{hypot, pow};
use crate::scene::{FINGER_JOINTS, Hand, ObjectMotion, Scene};
use crate::trace::{ContactSample, Energy, Model, Sample, Sink, SinkError};

/// Tolerance for limits that hold in exact arithmetic; relative rounding error of the exchanged momentum.
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
    /// Surface displacement per unit of the gap: 1, or the arm length, m, of a stop, whose gap is an angle.
    reach_m: f64,
    impulse: Impulse,
    /// Slip in the last sample; NaN before the first.
    slip_m_s: f64,
    /// Gap rate in the last sample.
    gap_rate_m_s: f64,
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
    /// See [`cables_return`](super::cables_return).
    cables_return: bool,
    /// Smallest mechanical energy minus the motor's work so far.
    lowest_j: f64,
    /// Largest increase of that difference above an earlier value.
    created_j: f64,
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
    /// Creates the sink for a run of `scene` with `model`; the tolerances follow from their settings.
    pub fn new(model: Model, scene: &Scene) -> Self {
        let hand = &scene.hand;
        // Discs have no joints that could open.
        let has_joints = !hand.fingers.is_empty() || scene.mechanism.is_some();
        let loop_gap_m = if has_joints { scene.bounds.loop_gap_m } else { 0.0 };
        let tolerances = Tolerances::for_settings(model, &scene.integrator, &scene.engine, loop_gap_m);
        // Momentum is not conserved in a moving frame. The engine's forces are averages over steps, so their impulses
        // between samples are not known accurately enough.
        let free_object = object(hand).filter(|_| hand.palm_motion.is_none() && model == Model::Analytic);
        Self {
            model,
            tolerances,
            contacts: monitored_contacts(scene),
            momentum_balance: free_object
                .map(|(body, friction_laws)| MomentumBalance::new(tolerances.energy, body, friction_laws)),
            worst: [Violation::default(); Invariant::ALL.len()],
            start: None,
            throughput_j: 0.0,
            max_imbalance: (0.0, 0.0),
            decrease: (0.0, 0.0),
            dissipated_j: f64::NEG_INFINITY,
            cables_return: super::cables_return(scene),
            lowest_j: f64::INFINITY,
            created_j: 0.0,
            last_s: 0.0,
            samples: 0,
        }
    }

    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Replaces the tolerance for missing energy, which is a fraction of the energy throughput.
    pub fn with_energy_tolerance(mut self, energy: f64) -> Self {
        self.tolerances.energy = energy;
        self
    }

    /// Mechanical energy created so far, J: the largest increase, after any earlier instant, beyond the work of the
    /// motor. The sum of the dissipated energy is not used, so that an error of this sum cannot hide created energy.
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
        for index in 0..self.contacts.len() {
            let Impulse { largest, decrease: (decrease, at_s), .. } = self.contacts[index].impulse;
            let allowed = self.tolerances.energy.max(ROUNDING) * largest;
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

    /// Replaces the worst value of an invariant by this one if it is worse.
    fn update(&mut self, invariant: Invariant, contact_index: Option<usize>, time_s: f64, measured: f64, allowed: f64) {
        let worst = &mut self.worst[invariant as usize];
        if Finding::fraction_of_limit(measured, allowed) > Finding::fraction_of_limit(worst.measured, worst.allowed) {
            *worst = Violation { contact_index, time_s, measured, allowed };
        }
    }

    fn energy(&mut self, time_s: f64, energy: &Energy) {
        let stored_j = energy.kinetic_j + energy.elastic_j + energy.dissipated_j.abs();
        let exchanged_j = energy.motor_work_j.abs() + energy.spring_j.abs() + energy.gravity_j.abs();
        self.throughput_j = self.throughput_j.max(stored_j).max(exchanged_j);
        update_max(&mut self.max_imbalance, energy.balance_j.abs(), time_s);
        let in_cables_j = if self.cables_return { energy.cable_friction_j } else { 0.0 };
        let mechanical_j = energy.kinetic_j + energy.gravity_j + energy.spring_j + energy.elastic_j
            - energy.motor_work_j
            + in_cables_j;
        self.lowest_j = self.lowest_j.min(mechanical_j);
        self.created_j = self.created_j.max(mechanical_j - self.lowest_j);
        let dissipated_j = energy.dissipated_j - in_cables_j;
        self.dissipated_j = self.dissipated_j.max(dissipated_j);
        update_max(&mut self.decrease, self.dissipated_j - dissipated_j, time_s);
    }

    /// Measures depth, force and impulse of a contact.
    fn contact(&mut self, index: usize, values: &ContactSample, time_s: f64, available_j: f64) {
        let contact = Some(index);
        let MonitoredContact { law, depth, reach_m, impulse, gap_rate_m_s, .. } = &mut self.contacts[index];
        let (law, depth, reach_m) = (*law, *depth, *reach_m);
        let previous_rate = std::mem::replace(gap_rate_m_s, values.gap_rate_m_s);
        let previous = std::mem::replace(&mut impulse.last, values.impulse_n_s);
        impulse.largest = impulse.largest.max(values.impulse_n_s);
        update_max(&mut impulse.decrease, previous - values.impulse_n_s, time_s);
        self.update(Invariant::NoAdhesion, contact, time_s, -values.normal_n, 0.0);
        if values.normal_n > 0.0 {
            let opening = values.gap_rate_m_s.abs().max(previous_rate.abs()) * self.tolerances.step_s;
            let allowed = self.tolerances.gap_m / reach_m + opening;
            self.update(Invariant::NoAdhesion, contact, time_s, values.gap_m, allowed);
        }
        if self.tolerances.laws {
            let allowed = max_depth(&law, available_j) + POSITION_ROUNDING_M / reach_m;
            self.update(depth, contact, time_s, -values.gap_m, allowed);
        }
    }

    fn friction(&mut self, index: usize, values: &ContactSample, time_s: f64) {
        let contact = Some(index);
        let previous = std::mem::replace(&mut self.contacts[index].slip_m_s, values.slip_m_s);
        if !self.tolerances.laws {
            return;
        }
        let Some(law) = self.contacts[index].friction.filter(|_| values.normal_n > 0.0) else {
            self.update(Invariant::Friction, contact, time_s, values.tangential_n.abs(), 0.0);
            return;
        };
        let mu = values.tangential_n / values.normal_n;
        // A force of a step belongs to all slips of that step: near v = 0 the law can reverse within one step.
        let slips = match self.model {
            Model::Engine if previous.is_finite() => [previous, values.slip_m_s],
            _ => [values.slip_m_s; 2],
        };
        let [lower, upper] = law.ratio_bounds(slips);
        let allowed = self.tolerances.friction;
        self.update(Invariant::Friction, contact, time_s, (lower - mu).max(mu - upper), allowed);
        self.update(Invariant::Friction, contact, time_s, mu.abs() - law.mu_static, ROUNDING);
    }
}

/// Depth at which the spring of the law alone stores this energy; infinite without a spring.
fn max_depth(law: &NormalLaw, energy_j: f64) -> f64 {
    let NormalLaw { stiffness_n_per_m_e: k, exponent: e, .. } = *law;
    if k > 0.0 { pow((e + 1.0) * energy_j.max(0.0) / k, (e + 1.0).recip()) * (1.0 + ROUNDING) } else { f64::INFINITY }
}

impl Sink for Invariants {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let (time_s, energy, non_finite) = (sample.time_s, &sample.energy(), non_finite(sample));
        self.samples += 1;
        self.last_s = time_s;
        self.update(Invariant::Finite, None, time_s, non_finite as f64, 0.0);
        if non_finite > 0 {
            return Ok(());
        }
        let start = *self.start.get_or_insert(*energy);
        self.energy(time_s, energy);
        let supplied_j = start.kinetic_j + start.elastic_j + energy.motor_work_j;
        let released_j = (start.gravity_j - energy.gravity_j) + (start.spring_j - energy.spring_j);
        let available_j =
            (1.0 + ENERGY_SUM_TOLERANCE) * (supplied_j + released_j) + self.tolerances.energy * self.throughput_j;
        // The gap of two outlines of the ground, which cannot move, is infinite.
        for (index, values) in sample.contacts().enumerate().filter(|(_, contact)| contact.gap_m != f64::INFINITY) {
            self.contact(index, &values, time_s, available_j);
            self.friction(index, &values, time_s);
        }
        self.momentum_balance.iter_mut().for_each(|balance| balance.record(sample));
        Ok(())
    }
}

/// Arm of the limit of a revolute joint without a five-bar finger, m: the length by which comparisons of both models convert angles.
const LIMIT_ARM_M: f64 = 0.1;

/// Returns the contacts of a scene, in the order of its samples.
fn monitored_contacts(scene: &Scene) -> Vec<MonitoredContact> {
    let hand = &scene.hand;
    let monitored =
        |name: String, (law, friction): (NormalLaw, Option<FrictionLaw>), depth, reach_m| MonitoredContact {
            name,
            law,
            friction,
            depth,
            reach_m,
            impulse: Impulse::default(),
            slip_m_s: f64::NAN,
            gap_rate_m_s: 0.0,
        };
    let mechanism = scene.drawn_mechanism();
    let points = mechanism.point_contacts().into_iter().map(|point| {
        let law = &mechanism.contacts[point.pair].law;
        monitored(point.name, (law.normal, law.friction), Invariant::Penetration, 1.0)
    });
    let arm_m = |finger: usize| hand.fingers.get(finger).map_or(LIMIT_ARM_M, |finger| finger.linkage.lengths.l22_m);
    let limits = mechanism.limits().into_iter().map(|limit| {
        let finger = match limit.of {
            Limited::Joint(joint) => joint / FINGER_JOINTS.len(),
            Limited::Sum(_) => usize::MAX,
        };
        let reach_m = if mechanism.is_angular(&limit) { arm_m(finger) } else { 1.0 };
        monitored(mechanism.limit_name(&limit), (limit.law, None), Invariant::JointLimit, reach_m)
    });
    points.chain(limits).collect()
}

/// Returns the object, if it is free, and the friction law of every contact.
fn object(hand: &Hand) -> Option<(FreeBody, Vec<Option<FrictionLaw>>)> {
    let ObjectMotion::Free { mass_kg, inertia_kg_m2, .. } = hand.object.as_ref()?.motion else { return None };
    let friction_laws = hand.contacts().map(|contact| hand.contact_laws(contact)?.1);
    Some((FreeBody { mass_kg, inertia_kg_m2, gravity_m_s2: hand.gravity_m_s2 }, friction_laws.collect()))
}

/// Number of values that are not finite. An infinite gap does not count: that of two outlines of the ground.
fn non_finite(sample: &Sample) -> usize {
    let fixed_gaps = sample.contacts().filter(|contact| contact.gap_m == f64::INFINITY).count();
    let all = sample.values().iter().chain([&sample.time_s]);
    all.filter(|number| !number.is_finite()).count() - fixed_gaps
}

/// A body that only contacts and gravity accelerate.
#[derive(Clone, Copy, Debug)]
pub(super) struct FreeBody {
    pub mass_kg: f64,
    pub inertia_kg_m2: f64,
    pub gravity_m_s2: [f64; 2],
}

/// Error of a momentum (N·s) or angular momentum (N·m·s), and its limit from samples and integration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Imbalance {
    pub time_s: f64,
    pub error: f64,
    pub allowed: f64,
}

/// Error of one momentum so far.
#[derive(Clone, Copy, Debug, Default)]
struct MomentumError {
    uncertainty: f64,
    /// Sum of the absolute values of all exchanged impulses.
    exchanged: f64,
    /// Imbalance furthest beyond its limit.
    worst: Imbalance,
}

impl MomentumError {
    fn record(&mut self, time_s: f64, error: f64, tolerance: f64) {
        let found = Imbalance { time_s, error, allowed: tolerance * self.exchanged + self.uncertainty };
        if found.error - found.allowed >= self.worst.error - self.worst.allowed {
            self.worst = found;
        }
    }

    fn worst(&self) -> Imbalance {
        Imbalance { allowed: self.worst.allowed + ROUNDING * self.exchanged, ..self.worst }
    }
}

/// Momentum balance of a free object: its momentum must equal the impulses of its contacts and its weight.
///
/// Between two samples a contact transfers ΔJ (n + μ t), where ΔJ is the increase of its normal impulse and μ = F_t /
/// F_n. Directions and μ change in between. Their differences between the two samples give the uncertainty, which is
/// allowed as an error.
#[derive(Clone, Debug)]
pub(super) struct MomentumBalance {
    body: FreeBody,
    /// Friction law of every contact of a sample; `None` for stops.
    friction_laws: Vec<Option<FrictionLaw>>,
    last: Option<Sample>,
    /// Impulses minus the change of momentum: along x, along y, about the centre.
    unbalanced: [f64; 3],
    /// Relative integration error of the exchanged momentum.
    tolerance: f64,
    linear: MomentumError,
    angular: MomentumError,
}

impl MomentumBalance {
    pub fn new(tolerance: f64, body: FreeBody, friction_laws: Vec<Option<FrictionLaw>>) -> Self {
        let (linear, angular) = (MomentumError::default(), MomentumError::default());
        Self { body, friction_laws, last: None, unbalanced: [0.0; 3], tolerance, linear, angular }
    }

    /// Imbalances of momentum and of angular momentum that are closest to, or furthest beyond, their limits.
    pub fn worst(&self) -> [Imbalance; 2] {
        [self.linear.worst(), self.angular.worst()]
    }

    /// Adds the interval between the last sample and this one.
    pub fn record(&mut self, sample: &Sample) {
        if let Some(last) = self.last.take() {
            self.add_weight(&last, sample);
            for index in (0..sample.counts().contacts).filter(|index| !sample.is_stop(*index)) {
                let ends = [(&last, &last.contact(index)), (sample, &sample.contact(index))];
                self.add_contact(ends, self.friction_laws[index]);
            }
            self.subtract_momentum_change(&last, sample);
        }
        self.last = Some(sample.clone());
        let [x, y, angular] = self.unbalanced;
        self.linear.record(sample.time_s, hypot(x, y), self.tolerance);
        self.angular.record(sample.time_s, angular.abs(), self.tolerance);
    }

    fn add_weight(&mut self, last: &Sample, sample: &Sample) {
        for (unbalanced, gravity) in self.unbalanced.iter_mut().zip(self.body.gravity_m_s2) {
            let impulse = self.body.mass_kg * gravity * (sample.time_s - last.time_s);
            *unbalanced += impulse;
            self.linear.exchanged += impulse.abs();
        }
    }

    fn subtract_momentum_change(&mut self, last: &Sample, sample: &Sample) {
        let (before, after) = (last.body(0), sample.body(0));
        for axis in 0..2 {
            self.unbalanced[axis] -= self.body.mass_kg * (after.velocity_m_s[axis] - before.velocity_m_s[axis]);
        }
        self.unbalanced[2] -= self.body.inertia_kg_m2 * (after.spin_rad_s - before.spin_rad_s);
    }

    fn add_contact(&mut self, ends: [(&Sample, &ContactSample); 2], friction: Option<FrictionLaw>) {
        let impulse = ends[1].1.impulse_n_s - ends[0].1.impulse_n_s;
        if impulse == 0.0 {
            return;
        }
        // Force and moment on the object, opposite to those on its partner, per unit of normal impulse.
        let [from, to] = ends.map(|(sample, contact)| {
            let (normal, tangent, mu) = (contact.normal, contact.tangent(), friction_ratio(contact, friction));
            let force = [0, 1].map(|axis| -normal[axis] - mu * tangent[axis]);
            let centre = sample.body(0).centre_m;
            let lever = [0, 1].map(|axis| contact.point_m[axis] - centre[axis]);
            [force[0], force[1], lever[0] * force[1] - lever[1] * force[0]]
        });
        let change = [0, 1, 2].map(|axis| (to[axis] - from[axis]).abs());
        for axis in 0..3 {
            self.unbalanced[axis] += impulse * 0.5 * (from[axis] + to[axis]);
        }
        let (centre, point) = (ends[1].0.body(0).centre_m, ends[1].1.point_m);
        let radius = hypot(point[0] - centre[0], point[1] - centre[1]);
        self.linear.uncertainty += impulse.abs() * hypot(change[0], change[1]);
        self.linear.exchanged += impulse.abs();
        self.angular.uncertainty += impulse.abs() * change[2];
        self.angular.exchanged += impulse.abs() * radius;
    }
}

/// F_t / F_n; without a normal force, the ratio that the law gives at this slip.
fn friction_ratio(contact: &ContactSample, friction: Option<FrictionLaw>) -> f64 {
    if contact.normal_n > 0.0 {
        contact.tangential_n / contact.normal_n
    } else {
        friction.map_or(0.0, |law| -friction_coefficient(&law, contact.slip_m_s).0)
    }
}
