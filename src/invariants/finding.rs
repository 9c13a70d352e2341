//! How near an invariant came to being broken.

use crate::trace::Site;

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
}

impl Invariant {
    pub const ALL: [Invariant; 8] = [
        Invariant::Finite,
        Invariant::Energy,
        Invariant::Passivity,
        Invariant::NoAdhesion,
        Invariant::Friction,
        Invariant::Penetration,
        Invariant::JointLimit,
        Invariant::LoopGap,
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
        }
    }
}

/// The worst of one invariant over a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding {
    pub invariant: Invariant,
    /// Where and when it was worst.
    pub site: Option<Site>,
    pub time_s: f64,
    /// In the unit of the invariant; what is allowed there.
    pub measured: f64,
    pub allowed: f64,
}

impl Finding {
    pub(super) fn new(invariant: Invariant) -> Self {
        Self { invariant, site: None, time_s: 0.0, measured: 0.0, allowed: 0.0 }
    }

    /// Part of what is allowed; above 1 the invariant is broken.
    pub fn share(&self) -> f64 {
        match self.measured.partial_cmp(&0.0) {
            Some(std::cmp::Ordering::Greater) => self.measured / self.allowed,
            Some(_) => 0.0,
            None => f64::INFINITY,
        }
    }

    pub fn is_broken(&self) -> bool {
        self.share() > 1.0
    }

    /// Takes over a measurement that is worse.
    pub(super) fn note(&mut self, site: Option<Site>, time_s: f64, measured: f64, allowed: f64) {
        let found = Self { site, time_s, measured, allowed, ..*self };
        if found.share() > self.share() {
            *self = found;
        }
    }
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let site = self.site.map_or(String::new(), |site| format!(" ({})", site.name()));
        write!(
            f,
            "{}{site}: {:.3e} of {:.3e} allowed, at {:.6} ms",
            self.invariant.name(),
            self.measured,
            self.allowed,
            self.time_s * 1e3
        )
    }
}
