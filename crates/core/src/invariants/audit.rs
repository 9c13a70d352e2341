//! The energy that a run exchanges, and whether it is all accounted for.

use std::fmt;

use super::Tolerances;
use crate::scene::Scene;
use crate::trace::{Energy, Event, Model, Sample, Sink, SinkError};

/// Part of a stored energy whose changes are rounding, at a few digits.
const ROUNDING: f64 = 1e-10;
/// Least part of the exchanged energy that counts as missing: the tolerance of the everyday preset, four digits of what is printed.
const LEAST: f64 = 1e-4;
/// The same for rapier's own contact, whose invariants have no bound: rigid impacts of discs keep their energy to 6e-4, and stacks
/// that gain some gain a half.
const RIGID: f64 = 1e-2;

/// A sink that adds up the energy exchanged in a run, and finds what is missing of it and what was created.
///
/// Its bound is that of [`Invariant::Energy`](super::Invariant::Energy) and [`Invariant::Passivity`](super::Invariant::Passivity), applied to
/// changes since the start: where the origin of the coordinates lies does not matter.
#[derive(Clone, Copy, Debug)]
pub struct EnergyAudit {
    /// Part of the exchanged energy that may be missing or created.
    tolerance: f64,
    start: Option<Energy>,
    /// Largest sum of energies and works at an instant, as changes since the start.
    exchanged_j: f64,
    /// Largest stored energy.
    stored_j: f64,
    dissipated_j: f64,
    /// Largest |balance|, and largest fall of the dissipated energy, each with its time.
    imbalance: (f64, f64),
    created: (f64, f64),
}

/// An energy that is not accounted for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breach {
    /// Whether contacts, friction and dampers gave energy back that they never took; otherwise the balance is off.
    pub created: bool,
    pub time_s: f64,
    pub off_j: f64,
    pub exchanged_j: f64,
    pub allowed_j: f64,
}

impl EnergyAudit {
    /// For a run of `scene` with `model`, with the tolerance of its settings.
    pub fn new(model: Model, scene: &Scene) -> Self {
        let bound = Tolerances::of(model, &scene.integrator, &scene.engine, scene.bounds.loop_gap_m).energy;
        let is_rigid = model == Model::Engine && !scene.engine.uses_laws();
        EnergyAudit {
            tolerance: if is_rigid { RIGID } else { bound.max(LEAST) },
            start: None,
            exchanged_j: 0.0,
            stored_j: 0.0,
            dissipated_j: 0.0,
            imbalance: (0.0, 0.0),
            created: (0.0, 0.0),
        }
    }

    /// What differences of energies are measured by, J: the largest energy exchanged so far, and the rounding of what is stored.
    pub fn scale_j(&self) -> f64 {
        self.exchanged_j + ROUNDING * self.stored_j
    }

    /// Takes the energies at an instant.
    pub fn enter(&mut self, time_s: f64, energy: &Energy) {
        let start = *self.start.get_or_insert(*energy);
        let Energy { kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j } = *energy;
        let [gravity, spring] = [gravity_j - start.gravity_j, spring_j - start.spring_j].map(f64::abs);
        let moved = kinetic_j + elastic_j + dissipated_j.abs();
        self.exchanged_j = self.exchanged_j.max(moved).max(motor_work_j.abs() + spring + gravity);
        self.stored_j = self.stored_j.max(gravity_j.abs()).max(spring_j.abs());
        self.dissipated_j = self.dissipated_j.max(dissipated_j);
        largest(&mut self.imbalance, balance_j.abs(), time_s);
        largest(&mut self.created, self.dissipated_j - dissipated_j, time_s);
    }

    /// The worse of a balance that is off and of energy that was created, if either is beyond its bound.
    pub fn breach(&self) -> Option<Breach> {
        let allowed_j = self.tolerance * self.scale_j();
        let [(balance, balance_s), (created, created_s)] = [self.imbalance, self.created];
        let is_created = created > balance;
        let (off_j, time_s) = if is_created { (created, created_s) } else { (balance, balance_s) };
        // What is no number is off too.
        let within = off_j <= allowed_j;
        (!within).then_some(Breach { created: is_created, time_s, off_j, exchanged_j: self.exchanged_j, allowed_j })
    }
}

fn largest((most, at_s): &mut (f64, f64), value: f64, time_s: f64) {
    if value > *most || value.is_nan() {
        (*most, *at_s) = (value, time_s);
    }
}

impl fmt::Display for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Breach { created, time_s, off_j, exchanged_j, allowed_j } = self;
        let what = if *created { "contacts created energy from nothing" } else { "the energy balance is off" };
        let (per_cent, time_ms) = (100.0 * off_j / exchanged_j, time_s * 1e3);
        write!(
            f,
            "{what}: {off_j:.2e} J at {time_ms:.6} ms, {per_cent:.2} % of the {exchanged_j:.2e} J exchanged; allowed are {allowed_j:.2e} J"
        )
    }
}

impl Sink for EnergyAudit {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.enter(sample.time_s, &sample.energy);
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}
