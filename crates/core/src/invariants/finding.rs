//! Results of measuring an invariant, and the tolerances of the invariants from the settings of a run.

use std::cmp::Ordering;
use std::fmt;

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::scene::{Engine, Integrator, Response, Stepping};
use crate::trace::Model;

/// A property that every run must have. See the [module](super) for their limits.
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
    pub const ALL: [Invariant; 10] = [
        Invariant::Finite,
        Invariant::Energy,
        Invariant::Passivity,
        Invariant::NoAdhesion,
        Invariant::Friction,
        Invariant::Penetration,
        Invariant::JointLimit,
        Invariant::LoopGap,
        Invariant::Momentum,
        Invariant::AngularMomentum,
    ];

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

/// The value of one invariant in a run that is closest to its limit, or furthest beyond it.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    pub invariant: Invariant,
    /// Name of the contact or stop.
    pub contact: Option<String>,
    /// Time of the value.
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

/// Tolerances due to discretisation. Invariants that hold exactly (finite values, no pulling contact) have none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// Tolerance of energies, as a fraction of the energy throughput.
    pub energy: f64,
    /// Largest gap at which a contact force is accepted; the opening during a step of `step_s` is added.
    pub gap_m: f64,
    /// Tolerance of the friction force, as a fraction of the normal force.
    pub friction: f64,
    pub loop_gap_m: f64,
    /// Length of fixed steps; 0 for adaptive steps, which are as short as contacts need. A force acts for a whole step,
    /// at whose end the surfaces may already be separated.
    pub step_s: f64,
    /// Whether contacts follow the scene's laws. rapier's own contact has a different friction law and no spring that
    /// bounds the depth.
    pub laws: bool,
}

impl Tolerances {
    /// Tolerances of a model with its settings; `loop_gap_m` is the tolerance of the scene for the engine's joints.
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
