//! Energy audit of a run: the exchanged energy, and whether it balances.

use std::fmt;

use super::Tolerances;
use crate::scene::Scene;
use crate::trace::{Energy, Model, Sample, Sink, SinkError};

/// Relative rounding error of stored energies.
const ROUNDING: f64 = 1e-10;
/// Smallest fraction of the exchanged energy that counts as missing: the tolerance of the everyday preset, four digits
/// of printed results.
const MIN_TOLERANCE: f64 = 1e-4;
/// [`MIN_TOLERANCE`] for rapier's own contact, whose energy has no error bound: rigid impacts of discs conserve energy
/// to 6e-4, and unstable stacks gain half of theirs.
const RIGID_CONTACT_TOLERANCE: f64 = 1e-2;

/// A sink that measures the energy exchanged in a run, and detects missing and created energy.
///
/// It uses the limits of [`Invariant::Energy`](super::Invariant::Energy) and
/// [`Invariant::Passivity`](super::Invariant::Passivity) for changes since the start, so that the origin of the
/// coordinates does not matter.
#[derive(Clone, Copy, Debug)]
pub struct EnergyAudit {
    /// Part of the exchanged energy that may be missing or created.
    tolerance: f64,
    start: Option<Energy>,
    /// Largest sum of energies and works at one instant, as changes since the start.
    max_exchanged_j: f64,
    /// Largest stored energy.
    max_stored_j: f64,
    dissipated_j: f64,
    /// Largest |balance| and its time.
    max_imbalance: (f64, f64),
    /// Largest decrease of the dissipated energy and its time.
    max_created: (f64, f64),
}

/// An energy error beyond its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyViolation {
    /// Whether contacts, friction and dampers released more energy than they had absorbed; otherwise the balance has an
    /// error.
    pub max_created: bool,
    pub time_s: f64,
    pub amount_j: f64,
    pub max_exchanged_j: f64,
    pub allowed_j: f64,
}

impl EnergyAudit {
    /// Audits a run of `scene` with `model`, with the tolerance of its settings.
    pub fn new(model: Model, scene: &Scene) -> Self {
        let bound = Tolerances::for_settings(model, &scene.integrator, &scene.engine, scene.bounds.loop_gap_m).energy;
        let is_rigid = model == Model::Engine && !scene.engine.uses_laws();
        EnergyAudit {
            tolerance: if is_rigid { RIGID_CONTACT_TOLERANCE } else { bound.max(MIN_TOLERANCE) },
            start: None,
            max_exchanged_j: 0.0,
            max_stored_j: 0.0,
            dissipated_j: 0.0,
            max_imbalance: (0.0, 0.0),
            max_created: (0.0, 0.0),
        }
    }

    /// Scale of energy differences, J: the largest energy exchanged so far, and the rounding error of stored energies.
    pub fn scale_j(&self) -> f64 {
        self.max_exchanged_j + ROUNDING * self.max_stored_j
    }

    /// Records the energies at one instant.
    pub fn record(&mut self, time_s: f64, energy: &Energy) {
        let start = *self.start.get_or_insert(*energy);
        let Energy { kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j } = *energy;
        let [gravity, spring] = [gravity_j - start.gravity_j, spring_j - start.spring_j].map(f64::abs);
        let absorbed_j = kinetic_j + elastic_j + dissipated_j.abs();
        self.max_exchanged_j = self.max_exchanged_j.max(absorbed_j).max(motor_work_j.abs() + spring + gravity);
        self.max_stored_j = self.max_stored_j.max(gravity_j.abs()).max(spring_j.abs());
        self.dissipated_j = self.dissipated_j.max(dissipated_j);
        update_max(&mut self.max_imbalance, balance_j.abs(), time_s);
        update_max(&mut self.max_created, self.dissipated_j - dissipated_j, time_s);
    }

    /// Returns the larger of the balance error and the created energy, if it is beyond the limit.
    pub fn violation(&self) -> Option<EnergyViolation> {
        let allowed_j = self.tolerance * self.scale_j();
        let [(imbalance_j, imbalance_s), (created_j, created_s)] = [self.max_imbalance, self.max_created];
        let is_created = created_j > imbalance_j;
        let (amount_j, time_s) = if is_created { (created_j, created_s) } else { (imbalance_j, imbalance_s) };
        // NaN is a violation too.
        let is_within_limit = amount_j <= allowed_j;
        (!is_within_limit).then_some(EnergyViolation {
            max_created: is_created,
            time_s,
            amount_j,
            max_exchanged_j: self.max_exchanged_j,
            allowed_j,
        })
    }
}

/// Updates a maximum and its time; NaN counts as the largest value.
fn update_max((max, at_s): &mut (f64, f64), value: f64, time_s: f64) {
    if value > *max || value.is_nan() {
        (*max, *at_s) = (value, time_s);
    }
}

impl fmt::Display for EnergyViolation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let EnergyViolation { max_created, time_s, amount_j, max_exchanged_j, allowed_j } = self;
        let description = if *max_created { "contacts created energy" } else { "the energy balance is violated" };
        let (per_cent, time_ms) = (100.0 * amount_j / max_exchanged_j, time_s * 1e3);
        write!(
            f,
            "{description}: {amount_j:.2e} J at {time_ms:.6} ms, {per_cent:.2} % of the {max_exchanged_j:.2e} J exchanged; allowed are {allowed_j:.2e} J"
        )
    }
}

impl Sink for EnergyAudit {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.record(sample.time_s, &sample.energy());
        Ok(())
    }
}
