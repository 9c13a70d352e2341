//! Invariants that no run may violate at any accuracy. They are measured at every sample while a run progresses.
//!
//! | invariant | measured value | limit |
//! |---|---|---|
//! | finite | number of values that are not finite | 0 |
//! | energy | largest \|balance\| | [`Tolerances::energy`] of the energy throughput of the run |
//! | passivity | largest decrease of the dissipated energy | the limit of the energy |
//! | no adhesion | largest gap with a contact force | [`Tolerances::gap_m`] plus the opening during a step |
//! | | most negative force; largest decrease of an impulse | 0; [`Tolerances::energy`] of the largest impulse |
//! | friction | \|F_t + μ(v) F_n\| / F_n, which includes the cone and the direction; in the engine, a force acts for a whole step, so the smallest value for any slip of the step counts | [`Tolerances::friction`] |
//! | penetration, limit | depth δ of a contact or joint limit | depth at which the spring alone stores all available energy: (e + 1) E = k δᵉ⁺¹ |
//! | loop gap | opening of a joint | [`Tolerances::loop_gap_m`] |
//! | momentum, angular momentum | momentum of a gripper's free object minus the impulses of contacts and weight | [`Tolerances::energy`] of the exchanged momentum, plus the change of friction and directions between samples |
//!
//! [`Invariants`] is a sink of runs; [`Invariants::findings`] returns how close each invariant came to its limit.

mod measure;

use crate::scene::{Engine, Integrator, Response, Scene, Stepping};
use crate::trace::{Energy, Model, RequiredData, Sample, Sink, SinkError};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::cmp::Ordering;
use std::fmt;

pub use measure::Invariants;

/// A property that every run must have. The limits are given in the [module](super).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Invariant {
    Finite,
    Energy,
    Passivity,
    NoAdhesion,
    Friction,
    Penetration,
    JointLimit,
    LoopGap,
    Momentum,
    AngularMomentum,
}

impl Invariant {
    pub const ALL: [Invariant; 10] = {
        use Invariant::*;
        [Finite, Energy, Passivity, NoAdhesion, Friction, Penetration, JointLimit, LoopGap, Momentum, AngularMomentum]
    };

    /// Name in JSON keys.
    pub fn name(self) -> &'static str {
        self.texts().0
    }

    /// Meaning, as a short sentence.
    pub fn meaning(self) -> &'static str {
        self.texts().1
    }

    fn texts(self) -> (&'static str, &'static str) {
        match self {
            Invariant::Finite => ("finite", "every number is finite"),
            Invariant::Energy => ("energy_balance", "energy balances"),
            Invariant::Passivity => ("passivity", "contacts, limit and friction only dissipate"),
            Invariant::NoAdhesion => ("no_adhesion", "no contact pulls, and no contact pushes across a gap"),
            Invariant::Friction => ("friction", "friction follows its law, within the cone and against the slip"),
            Invariant::Penetration => ("penetration", "no penetration is deeper than the available energy allows"),
            Invariant::JointLimit => {
                ("joint_limit", "no joint exceeds its limit further than the available energy allows")
            }
            Invariant::LoopGap => ("loop_gap", "joints stay closed"),
            Invariant::Momentum => {
                ("momentum", "the momentum of a free object equals the impulses of its contacts and its weight")
            }
            Invariant::AngularMomentum => {
                ("angular_momentum", "the angular momentum of a free object equals that of its contact impulses")
            }
        }
    }
}

/// The worst value of one invariant during a run: closest to its limit, or furthest beyond it.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    pub invariant: Invariant,
    /// Name of the contact or stop.
    pub contact: Option<String>,
    pub time_s: f64,
    /// Measured value, in the unit of the invariant.
    pub measured: f64,
    /// Limit of the value, in the same unit.
    pub allowed: f64,
}

impl Finding {
    /// Ratio of the measured value to the limit; above 1 the invariant is violated.
    pub fn ratio_to_limit(&self) -> f64 {
        Self::fraction_of_limit(self.measured, self.allowed)
    }

    pub fn is_violated(&self) -> bool {
        self.ratio_to_limit() > 1.0
    }

    /// Ratio of `measured` to `allowed`: 0 for values that are not positive, infinite for NaN.
    pub(super) fn fraction_of_limit(measured: f64, allowed: f64) -> f64 {
        match measured.partial_cmp(&0.0) {
            Some(Ordering::Greater) => measured / allowed,
            Some(_) => 0.0,
            None => f64::INFINITY,
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let contact = self.contact.as_ref().map_or(String::new(), |contact| format!(" ({contact})"));
        write!(
            f,
            "{}{contact}: {:.3e} of {:.3e} allowed, at {:.6} ms",
            self.invariant.name(),
            self.measured,
            self.allowed,
            self.time_s * 1e3
        )
    }
}

/// Serialises measured value and limit in the SI unit of the quantity.
impl Serialize for Finding {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("invariant", self.invariant.name())?;
        map.serialize_entry("meaning", self.invariant.meaning())?;
        map.serialize_entry("held", &!self.is_violated())?;
        map.serialize_entry("share", &self.ratio_to_limit())?;
        map.serialize_entry("measured", &self.measured)?;
        map.serialize_entry("allowed", &self.allowed)?;
        map.serialize_entry("place", &self.contact)?;
        map.serialize_entry("time_s", &self.time_s)?;
        map.end()
    }
}

/// Tolerances due to discretisation. Invariants that hold exactly (finite values, no pulling contact) have no
/// tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Tolerance of energies, as a fraction of the energy throughput.
    pub energy: f64,
    /// Largest gap at which a contact force is accepted, m. The opening during a step of length `step_s` is added.
    pub gap_m: f64,
    /// Tolerance of the friction force, as a fraction of the normal force.
    pub friction: f64,
    pub loop_gap_m: f64,
    /// Length of fixed steps, s; 0 for adaptive steps, which are as short as contacts need. The force of a fixed step
    /// acts for the whole step, and the surfaces may already be separated at its end.
    pub step_s: f64,
    /// Whether contacts follow the laws of the scene. Otherwise they are those of rapier, which have other friction and
    /// no spring that bounds the depth.
    pub laws: bool,
}

impl Tolerances {
    /// Returns the tolerances for a model and its settings; `loop_gap_m` is the scene's tolerance for joints of the
    /// engine.
    pub fn for_settings(model: Model, integrator: &Integrator, engine: &Engine, loop_gap_m: f64) -> Self {
        match model {
            Model::Analytic => Self::analytic(integrator),
            Model::Engine => Self::engine(engine, loop_gap_m),
        }
    }

    /// Contact forces follow the state to rounding errors; the energy is as accurate as the integration.
    fn analytic(settings: &Integrator) -> Self {
        Self {
            energy: (10.0 * settings.rtol).max(1e-9),
            gap_m: 1e-15,
            friction: 1e-9,
            loop_gap_m: 0.0,
            step_s: 0.0,
            laws: true,
        }
    }

    /// Forces act for a step with fixed geometry, so they miss rotations within the step.
    fn engine(settings: &Engine, loop_gap_m: f64) -> Self {
        let (energy, gap_m, friction, step_s) = match settings.stepping {
            Stepping::Adaptive { tolerance_m, .. } => {
                let coarsening = (tolerance_m / 1e-7).max(1.0);
                (1e-3 * coarsening.sqrt(), tolerance_m, 0.02, 0.0)
            }
            // Half of g dt² at the accelerations of these grippers, 1e4 m/s².
            Stepping::Fixed { step_s } => {
                (1e-3 + 1e3 * step_s, 1e-9 + 5e3 * step_s * step_s, 0.02 + 2e4 * step_s, step_s)
            }
        };
        match settings.response {
            Response::Laws => Self { energy, gap_m, friction, loop_gap_m, step_s, laws: true },
            // Rigid contacts have impulses instead of forces.
            Response::Rapier { .. } => {
                Self { energy: 1.0, gap_m: f64::INFINITY, friction: f64::INFINITY, loop_gap_m, step_s, laws: false }
            }
        }
    }
}

/// Relative rounding error of stored energies.
const ROUNDING: f64 = 1e-10;
/// Energies of this size come from rounding errors, as those of a body at rest that touches another one, J.
const NEGLIGIBLE_J: f64 = 1e-26;
/// Smallest fraction of the exchanged energy that counts as missing: the tolerance of the everyday preset.
const MIN_TOLERANCE: f64 = 1e-4;
/// [`MIN_TOLERANCE`] for rapier's own contact, whose energy has no error bound: rigid impacts of discs conserve energy
/// to 6e-4, and unstable stacks gain half of theirs.
const RIGID_CONTACT_TOLERANCE: f64 = 1e-2;

/// A sink that measures the energy exchanged in a run, and detects missing and created energy.
///
/// It uses the limits of [`Invariant::Energy`] and
/// [`Invariant::Passivity`] for changes since the start, so that the origin of the
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
    /// See [`cables_return`].
    cables_return: bool,
    /// Largest |balance| and its time.
    max_imbalance: (f64, f64),
    /// Largest decrease of the dissipated energy and its time.
    max_created: (f64, f64),
}

/// An energy error that exceeds its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyViolation {
    /// Whether contacts, friction and dampers released more energy than they absorbed. Otherwise, the energy balance
    /// has an error.
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
            cables_return: cables_return(scene),
            max_imbalance: (0.0, 0.0),
            max_created: (0.0, 0.0),
        }
    }

    /// Scale of energy differences, J: the largest energy exchanged so far, plus the rounding error of the stored
    /// energies.
    pub fn scale_j(&self) -> f64 {
        self.max_exchanged_j + ROUNDING * self.max_stored_j + NEGLIGIBLE_J
    }

    pub fn record(&mut self, time_s: f64, energy: &Energy) {
        let start = *self.start.get_or_insert(*energy);
        let Energy { kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j, .. } = *energy;
        let [gravity, spring] = [gravity_j - start.gravity_j, spring_j - start.spring_j].map(f64::abs);
        let absorbed_j = kinetic_j + elastic_j + dissipated_j.abs();
        self.max_exchanged_j = self.max_exchanged_j.max(absorbed_j).max(motor_work_j.abs() + spring + gravity);
        self.max_stored_j = self.max_stored_j.max(gravity_j.abs()).max(spring_j.abs());
        let dissipated_j = dissipated_j - if self.cables_return { energy.cable_friction_j } else { 0.0 };
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

/// Whether the friction of a cable returns work: under `presliding` it deflects before it slips, and the work of the
/// deflection depends on the tension. Such work does not belong to what a run must not return.
fn cables_return(scene: &Scene) -> bool {
    let mut frictions = scene.mechanism.iter().flat_map(|mechanism| &mechanism.tendons).flat_map(|tendon| &tendon.path);
    frictions.any(|element| element.friction.is_some_and(|law| law.has_state()))
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
    fn required_data(&self) -> RequiredData {
        RequiredData { energies: true, ..RequiredData::NONE }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.record(sample.time_s, &sample.energy());
        Ok(())
    }
}
