//! A finger with its drive and contact laws.

use super::{Actuation, Brake};
use crate::gripper::{Finger, FingerContact, Spring};
use crate::law::{ContactLaw, NormalLaw};

/// A finger in its own frame: ground joint at the origin, object to its left.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivenFinger {
    /// The five-bar linkage: lengths, masses and assembly mode.
    pub linkage: Finger,
    pub motor: Motor,
    pub spring: Option<Spring>,
    /// Law of the joint limit q22 ≥ −φ22; `None` without a limit.
    pub limit: Option<NormalLaw>,
    /// Laws of the contacts with the object.
    pub contact: FingerContactLaws,
    pub initial: Initial,
}

/// A motor with gear and brake.
#[derive(Clone, Debug, PartialEq)]
pub struct Motor {
    pub actuation: Actuation,
    /// Inertia of rotor and gear, reflected to the driven link.
    pub inertia_kg_m2: f64,
    /// Rate at which the torque has fallen to 0; `None` if the torque does not depend on the rate.
    pub no_load_speed_rad_s: Option<f64>,
    pub brake: Option<Brake>,
}

/// A seesaw with one input and two outputs: each finger gets half of the torque; the input rotates by the mean of both
/// outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Differential {
    /// Motor at the input; its inertia is J_in.
    pub motor: Motor,
    /// J_s; the seesaw rotates by half the difference of both outputs.
    pub seesaw_inertia_kg_m2: f64,
}

/// Laws of the proximal (l21) and the distal (t22) contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FingerContactLaws {
    pub proximal: ContactLaw,
    pub distal: ContactLaw,
}

impl FingerContactLaws {
    /// Mutable access to both laws.
    pub fn both_mut(&mut self) -> [&mut ContactLaw; 2] {
        [&mut self.proximal, &mut self.distal]
    }

    /// μ_s of both contacts; 0 without friction.
    pub fn mu_static(&self) -> [f64; 2] {
        [self.proximal, self.distal].map(|law| law.friction.map_or(0.0, |law| law.mu_static))
    }
}

/// Initial joint angles and rates of the two generalised coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Initial {
    pub q11_rad: f64,
    pub q21_rad: f64,
    pub qd11_rad_s: f64,
    pub qd21_rad_s: f64,
}

impl DrivenFinger {
    /// Law of a contact; `None` for the joint limit, which is not a contact of two surfaces.
    #[inline]
    pub fn law(&self, site: FingerContact) -> Option<ContactLaw> {
        match site {
            FingerContact::Proximal => Some(self.contact.proximal),
            FingerContact::Distal => Some(self.contact.distal),
            FingerContact::Limit => None,
        }
    }
}

impl Motor {
    /// No motor: for fingers driven by a differential.
    pub const NONE: Self = Motor {
        actuation: Actuation::Constant { torque_n_m: 0.0 },
        inertia_kg_m2: 0.0,
        no_load_speed_rad_s: None,
        brake: None,
    };

    /// Creates an ideal torque source without inertia, speed limit or brake.
    pub fn from_actuation(actuation: Actuation) -> Self {
        Self { actuation, ..Self::NONE }
    }
}
