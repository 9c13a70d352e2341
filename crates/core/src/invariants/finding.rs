//! How near an invariant came to being broken.

use std::cmp::Ordering;
use std::fmt;

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
        match self {
            Invariant::Finite => "finite",
            Invariant::Energy => "energy_balance",
            Invariant::Passivity => "passivity",
            Invariant::NoAdhesion => "no_adhesion",
            Invariant::Friction => "friction",
            Invariant::Penetration => "penetration",
            Invariant::JointLimit => "joint_limit",
            Invariant::LoopGap => "loop_gap",
            Invariant::Momentum => "momentum",
            Invariant::AngularMomentum => "angular_momentum",
        }
    }

    /// In words.
    pub fn meaning(self) -> &'static str {
        match self {
            Invariant::Finite => "every number is finite",
            Invariant::Energy => "energy balances",
            Invariant::Passivity => "contacts, limit and friction only dissipate",
            Invariant::NoAdhesion => "nothing pulls, and nothing pushes from afar",
            Invariant::Friction => "friction follows its law, within the cone and against the slip",
            Invariant::Penetration => "no surface is deeper in than its energy allows",
            Invariant::JointLimit => "the joint limit holds",
            Invariant::LoopGap => "joints stay closed",
            Invariant::Momentum => "a free object has the momentum that contacts and weight gave it",
            Invariant::AngularMomentum => "a free object turns as its contacts made it",
        }
    }
}

/// The worst of one invariant over a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    pub invariant: Invariant,
    /// Where (the name of a contact or stop) and when it was worst.
    pub place: Option<String>,
    pub time_s: f64,
    /// In the unit of the invariant; what is allowed there.
    pub measured: f64,
    pub allowed: f64,
}

impl Finding {
    /// Part of what is allowed; above 1 the invariant is broken.
    pub fn share(&self) -> f64 {
        Self::part(self.measured, self.allowed)
    }

    pub fn is_broken(&self) -> bool {
        self.share() > 1.0
    }

    /// `measured` as a part of what is allowed: 0 for nothing, infinite for what is no number.
    pub(super) fn part(measured: f64, allowed: f64) -> f64 {
        match measured.partial_cmp(&0.0) {
            Some(Ordering::Greater) => measured / allowed,
            Some(_) => 0.0,
            None => f64::INFINITY,
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = self.place.as_ref().map_or(String::new(), |place| format!(" ({place})"));
        write!(
            f,
            "{}{place}: {:.3e} of {:.3e} allowed, at {:.6} ms",
            self.invariant.name(),
            self.measured,
            self.allowed,
            self.time_s * 1e3
        )
    }
}
