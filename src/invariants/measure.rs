//! Measures every invariant as a run goes by.

use super::{Finding, Invariant, Tolerances};
use crate::law::{FrictionLaw, NormalLaw, friction_coefficient};
use crate::scene::Scene;
use crate::trace::{ContactSample, Energy, Event, Model, Outcome, Sample, Sink, SinkError, Site};

/// Slack of bounds that hold in exact arithmetic.
const ROUNDING: f64 = 1e-9;

/// A [`Sink`] that measures how near a run comes to breaking each [`Invariant`].
#[derive(Clone, Debug)]
pub struct Invariants {
    tolerances: Tolerances,
    laws: [Option<NormalLaw>; 3],
    friction: [Option<FrictionLaw>; 2],
    found: [Finding; 8],
    start: Option<Energy>,
    /// Most energy that was ever about: kinetic, stored, dissipated, and the motor's work.
    throughput_j: f64,
    /// Largest |balance| and fall of what is dissipated, and when; judged once the throughput is known.
    imbalance: (f64, f64),
    fall: (f64, f64),
    dissipated_j: f64,
    impulses: [f64; 3],
    samples: u64,
}

impl Invariants {
    /// For a run of `scene` with `model`, held to the tolerances of its settings.
    pub fn new(model: Model, scene: &Scene) -> Self {
        let there = |law: NormalLaw| scene.object.map(|_| law);
        Self {
            tolerances: Tolerances::of(model, scene),
            laws: [there(scene.contact.proximal.normal), there(scene.contact.distal.normal), scene.limit],
            friction: [scene.contact.proximal.friction, scene.contact.distal.friction],
            found: Invariant::ALL.map(Finding::new),
            start: None,
            throughput_j: 0.0,
            imbalance: (0.0, 0.0),
            fall: (0.0, 0.0),
            dissipated_j: f64::NEG_INFINITY,
            impulses: [0.0; 3],
            samples: 0,
        }
    }

    /// Samples looked at.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The worst of every invariant, once the run is over.
    pub fn findings(mut self, outcome: &Outcome) -> [Finding; 8] {
        let allowed = self.tolerances.energy * self.throughput_j;
        let (imbalance, fall) = (self.imbalance, self.fall);
        self.note(Invariant::Energy, None, imbalance.1, imbalance.0, allowed);
        self.note(Invariant::Passivity, None, fall.1, fall.0, allowed);
        let (gap, most) = (outcome.loop_gap_m, self.tolerances.loop_gap_m);
        self.note(Invariant::LoopGap, None, outcome.last.time_s, gap, most);
        self.found
    }

    fn note(&mut self, invariant: Invariant, site: Option<Site>, time_s: f64, measured: f64, allowed: f64) {
        self.found[invariant as usize].note(site, time_s, measured, allowed);
    }

    fn energy(&mut self, time_s: f64, energy: &Energy) {
        let stored = energy.kinetic_j + energy.elastic_j + energy.dissipated_j.abs();
        let moved = energy.motor_work_j.abs() + energy.spring_j.abs() + energy.gravity_j.abs();
        self.throughput_j = self.throughput_j.max(stored).max(moved);
        worst(&mut self.imbalance, energy.balance_j.abs(), time_s);
        self.dissipated_j = self.dissipated_j.max(energy.dissipated_j);
        worst(&mut self.fall, self.dissipated_j - energy.dissipated_j, time_s);
    }

    /// One contact or the limit: depth, force and impulse.
    fn site(&mut self, site: Site, sample: &Sample, available_j: f64) {
        let Some(law) = self.laws[site as usize] else { return };
        let (gap, force, impulse) = match site {
            Site::Proximal => reading(&sample.proximal),
            Site::Distal => reading(&sample.distal),
            Site::Limit => (sample.limit.gap_rad, sample.limit.torque_n_m, sample.limit.impulse_n_m_s),
        };
        let (at, t) = (Some(site), sample.time_s);
        self.note(Invariant::NoAdhesion, at, t, -force, 0.0);
        if force > 0.0 {
            self.note(Invariant::NoAdhesion, at, t, gap, self.tolerances.gap_m);
        }
        let before = std::mem::replace(&mut self.impulses[site as usize], impulse);
        self.note(Invariant::NoAdhesion, at, t, before - impulse, ROUNDING * impulse.abs());
        let depth = match site {
            Site::Limit => Invariant::JointLimit,
            _ => Invariant::Penetration,
        };
        self.note(depth, at, t, -gap, deepest(&law, available_j));
    }

    fn friction(&mut self, site: Site, contact: &ContactSample, time_s: f64) {
        let Some(law) = self.friction[site as usize] else {
            self.note(Invariant::Friction, Some(site), time_s, contact.tangential_n.abs(), 0.0);
            return;
        };
        if contact.normal_n <= 0.0 {
            self.note(Invariant::Friction, Some(site), time_s, contact.tangential_n.abs(), 0.0);
            return;
        }
        let mu = contact.tangential_n / contact.normal_n;
        let wanted = -friction_coefficient(&law, contact.slip_m_s).0;
        let (at, allowed) = (Some(site), self.tolerances.friction);
        self.note(Invariant::Friction, at, time_s, (mu - wanted).abs(), allowed);
        if allowed.is_finite() {
            self.note(Invariant::Friction, at, time_s, mu.abs() - law.mu_static, ROUNDING);
        }
    }
}

impl Sink for Invariants {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.samples += 1;
        let strange = strange_numbers(sample);
        self.note(Invariant::Finite, None, sample.time_s, strange as f64, 0.0);
        if strange > 0 {
            return Ok(());
        }
        let start = *self.start.get_or_insert(sample.energy);
        let now = &sample.energy;
        self.energy(sample.time_s, now);
        let given = start.kinetic_j + start.elastic_j + now.motor_work_j;
        let released = (start.gravity_j - now.gravity_j) + (start.spring_j - now.spring_j);
        let available_j = given + released + self.tolerances.energy * self.throughput_j;
        for site in Site::ALL {
            self.site(site, sample, available_j);
        }
        self.friction(Site::Proximal, &sample.proximal, sample.time_s);
        self.friction(Site::Distal, &sample.distal, sample.time_s);
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

fn reading(contact: &ContactSample) -> (f64, f64, f64) {
    (contact.gap_m, contact.normal_n, contact.impulse_n_s)
}

fn worst((most, at_s): &mut (f64, f64), measured: f64, time_s: f64) {
    if measured > *most {
        (*most, *at_s) = (measured, time_s);
    }
}

/// Depth in which the law's spring alone stores this energy; infinite where there is none to hold anything back.
fn deepest(law: &NormalLaw, energy_j: f64) -> f64 {
    let NormalLaw { stiffness_n_per_m_e: k, exponent: e, .. } = *law;
    if k > 0.0 { ((e + 1.0) * energy_j.max(0.0) / k).powf((e + 1.0).recip()) * (1.0 + ROUNDING) } else { f64::INFINITY }
}

/// How many numbers are none. A gap to nothing is infinite and does not count.
fn strange_numbers(sample: &Sample) -> usize {
    let Sample { proximal, distal, limit, energy, .. } = sample;
    let angles = [sample.q11_rad, sample.q21_rad, sample.q12_rad, sample.q22_rad, sample.q13_rad];
    let rates = [sample.qd11_rad_s, sample.qd21_rad_s, sample.qd12_rad_s, sample.qd22_rad_s];
    let stored = [energy.kinetic_j, energy.gravity_j, energy.spring_j, energy.elastic_j];
    let given = [energy.dissipated_j, energy.motor_work_j, energy.balance_j];
    let plain =
        [sample.time_s, sample.motor_torque_n_m].into_iter().chain(angles).chain(rates).chain(stored).chain(given);
    let sites = [proximal, distal].into_iter().flat_map(|contact| {
        let ContactSample { gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s, point_m, normal, .. } =
            *contact;
        let scalars = [gap_rate_m_s, slip_m_s, normal_n, tangential_n, impulse_n_s];
        scalars.into_iter().chain(point_m).chain(normal)
    });
    let stop = [limit.gap_rate_rad_s, limit.torque_n_m, limit.impulse_n_m_s];
    let gaps = [proximal.gap_m, distal.gap_m, limit.gap_rad].into_iter().filter(|gap| *gap != f64::INFINITY);
    plain.chain(sites).chain(stop).chain(gaps).filter(|number| !number.is_finite()).count()
}
