//! Results of measuring an invariant.

use std::cmp::Ordering;
use std::fmt;

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
