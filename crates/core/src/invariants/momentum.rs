//! Momentum balance of a free object: its momentum must equal the impulses of its contacts and its weight.
//!
//! Between two samples a contact transfers ΔJ (n + μ t), where ΔJ is the increase of its normal impulse and μ = F_t /
//! F_n. Directions and μ change in between. Their differences between the two samples give the uncertainty, which is
//! allowed as an error.

use crate::law::{FrictionLaw, friction_coefficient};
use crate::numeric::elementary::hypot;
use crate::trace::{ContactSample, Sample};

/// A body that only contacts and gravity accelerate.
#[derive(Clone, Copy, Debug)]
pub(super) struct FreeBody {
    pub mass_kg: f64,
    pub inertia_kg_m2: f64,
    pub gravity_m_s2: [f64; 2],
}

/// Relative rounding error of the exchanged momentum.
const ROUNDING: f64 = 1e-9;

/// Error of a momentum (N·s) or an angular momentum (N·m·s), and its limit from the uncertainty of the samples and the
/// integration error.
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

/// Momentum balance of one object.
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

    /// Imbalances of momentum and angular momentum furthest beyond their limits.
    pub fn worst(&self) -> [Imbalance; 2] {
        [self.linear.worst(), self.angular.worst()]
    }

    /// Adds the interval from the last sample to this one.
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
