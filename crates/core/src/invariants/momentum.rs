//! Momentum of a free object: what its contacts and its weight have given it is what it has.
//!
//! Between two samples a contact gives ΔJ (n + μ t), where ΔJ is what its normal impulse grew by and μ = F_t / F_n. Directions
//! and μ change meanwhile, by what the samples before and after say: that is the doubt, which is allowed.

use crate::law::{FrictionLaw, friction_coefficient};
use crate::numeric::elementary::hypot;
use crate::trace::{ContactSample, Sample};

/// A body that nothing but its contacts and its weight moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Free {
    pub mass_kg: f64,
    pub inertia_kg_m2: f64,
    pub gravity_m_s2: [f64; 2],
}

/// Rounding, as a part of all that is exchanged in a run.
const ROUNDING: f64 = 1e-9;

/// How far momentum (N·s) or angular momentum (N·m·s) is off, and what of that samples cannot say or integration may miss.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Imbalance {
    pub time_s: f64,
    pub off: f64,
    pub allowed: f64,
}

/// What is known of one momentum so far.
#[derive(Clone, Copy, Debug, Default)]
struct Account {
    doubt: f64,
    /// Sizes of all that was exchanged, however it cancels.
    exchanged: f64,
    /// Where it was furthest beyond what is allowed.
    worst: Imbalance,
}

impl Account {
    fn enter(&mut self, time_s: f64, off: f64, tolerance: f64) {
        let found = Imbalance { time_s, off, allowed: tolerance * self.exchanged + self.doubt };
        if found.off - found.allowed >= self.worst.off - self.worst.allowed {
            self.worst = found;
        }
    }

    fn worst(&self) -> Imbalance {
        Imbalance { allowed: self.worst.allowed + ROUNDING * self.exchanged, ..self.worst }
    }
}

/// The books of one object.
#[derive(Clone, Debug)]
pub(super) struct Books {
    free: Free,
    /// Of every contact of a sample; none of stops.
    frictions: Vec<Option<FrictionLaw>>,
    last: Option<Sample>,
    /// What the object was given beyond what it has: along x, along y, about its centre.
    missing: [f64; 3],
    /// Part of what is exchanged that integration may miss.
    tolerance: f64,
    linear: Account,
    angular: Account,
}

impl Books {
    pub fn new(tolerance: f64, free: Free, frictions: Vec<Option<FrictionLaw>>) -> Self {
        let (linear, angular) = (Account::default(), Account::default());
        Self { free, frictions, last: None, missing: [0.0; 3], tolerance, linear, angular }
    }

    /// Momentum and angular momentum, each where it was furthest beyond what is allowed.
    pub fn worst(&self) -> [Imbalance; 2] {
        [self.linear.worst(), self.angular.worst()]
    }

    /// Enters the time up to a sample.
    pub fn enter(&mut self, sample: &Sample) {
        if let Some(last) = self.last.take() {
            self.weight(&last, sample);
            for index in (0..sample.contacts.len()).filter(|index| !sample.is_stop(*index)) {
                let ends = [(&last, &last.contacts[index]), (sample, &sample.contacts[index])];
                self.contact(ends, self.frictions[index]);
            }
            self.own(&last, sample);
        }
        self.last = Some(sample.clone());
        let [x, y, about] = self.missing;
        self.linear.enter(sample.time_s, hypot(x, y), self.tolerance);
        self.angular.enter(sample.time_s, about.abs(), self.tolerance);
    }

    fn weight(&mut self, last: &Sample, sample: &Sample) {
        for (missing, gravity) in self.missing.iter_mut().zip(self.free.gravity_m_s2) {
            let given = self.free.mass_kg * gravity * (sample.time_s - last.time_s);
            *missing += given;
            self.linear.exchanged += given.abs();
        }
    }

    fn own(&mut self, last: &Sample, sample: &Sample) {
        let (before, after) = (&last.bodies[0], &sample.bodies[0]);
        for axis in 0..2 {
            self.missing[axis] -= self.free.mass_kg * (after.velocity_m_s[axis] - before.velocity_m_s[axis]);
        }
        self.missing[2] -= self.free.inertia_kg_m2 * (after.spin_rad_s - before.spin_rad_s);
    }

    fn contact(&mut self, ends: [(&Sample, &ContactSample); 2], friction: Option<FrictionLaw>) {
        let impulse = ends[1].1.impulse_n_s - ends[0].1.impulse_n_s;
        if impulse == 0.0 {
            return;
        }
        // On the object, opposite to that on what presses; for an impulse of 1.
        let [from, to] = ends.map(|(sample, contact)| {
            let (normal, tangent, mu) = (contact.normal, contact.tangent(), ratio(contact, friction));
            let force = [0, 1].map(|axis| -normal[axis] - mu * tangent[axis]);
            let centre = sample.bodies[0].centre_m;
            let lever = [0, 1].map(|axis| contact.point_m[axis] - centre[axis]);
            [force[0], force[1], lever[0] * force[1] - lever[1] * force[0]]
        });
        let apart = [0, 1, 2].map(|part| (to[part] - from[part]).abs());
        for part in 0..3 {
            self.missing[part] += impulse * 0.5 * (from[part] + to[part]);
        }
        let (centre, point) = (ends[1].0.bodies[0].centre_m, ends[1].1.point_m);
        let radius = hypot(point[0] - centre[0], point[1] - centre[1]);
        self.linear.doubt += impulse.abs() * hypot(apart[0], apart[1]);
        self.linear.exchanged += impulse.abs();
        self.angular.doubt += impulse.abs() * apart[2];
        self.angular.exchanged += impulse.abs() * radius;
    }
}

/// F_t / F_n; of surfaces that do not press, what it would be if they did.
fn ratio(contact: &ContactSample, friction: Option<FrictionLaw>) -> f64 {
    if contact.normal_n > 0.0 {
        contact.tangential_n / contact.normal_n
    } else {
        friction.map_or(0.0, |law| -friction_coefficient(&law, contact.slip_m_s).0)
    }
}
