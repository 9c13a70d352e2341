//! A finger with what drives it and what it touches by.

use super::{Actuation, Brake};
use crate::gripper::{Finger, Site, Spring};
use crate::law::{ContactLaw, NormalLaw};

/// A finger in its own frame: ground joint at the origin, what it grasps to its left.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivenFinger {
    /// Its five-bar: lengths, masses, and how it is put together.
    pub linkage: Finger,
    pub motor: Motor,
    pub spring: Option<Spring>,
    /// Joint limit q22 ≥ −φ22; `None` switches it off.
    pub limit: Option<NormalLaw>,
    /// Laws of its contacts with what it grasps.
    pub contact: Contacts,
    pub initial: Initial,
}

/// A motor as bought.
#[derive(Clone, Debug, PartialEq)]
pub struct Motor {
    pub actuation: Actuation,
    /// Of rotor and gear, as the driven link feels it.
    pub inertia_kg_m2: f64,
    /// Rate at which nothing is left of the torque.
    pub no_load_speed_rad_s: Option<f64>,
    pub brake: Option<Brake>,
}

/// One input, a seesaw and two outputs: both fingers get half of its torque, and it turns by the mean of both.
#[derive(Clone, Debug, PartialEq)]
pub struct Differential {
    /// Of the input; its inertia is J_in.
    pub motor: Motor,
    /// J_s, which turns by half the difference of both outputs.
    pub seesaw_inertia_kg_m2: f64,
}

/// Laws of the proximal (l21) and the distal (t22) contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contacts {
    pub proximal: ContactLaw,
    pub distal: ContactLaw,
}

impl Contacts {
    /// Both laws, to be changed.
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
    /// The law of a contact of it; the joint limit is none of two surfaces.
    #[inline]
    pub fn law(&self, site: Site) -> Option<ContactLaw> {
        match site {
            Site::Proximal => Some(self.contact.proximal),
            Site::Distal => Some(self.contact.distal),
            Site::Limit => None,
        }
    }
}

impl Motor {
    /// None at all: that of a finger which a differential drives.
    pub const NONE: Self = Motor {
        actuation: Actuation::Constant { torque_n_m: 0.0 },
        inertia_kg_m2: 0.0,
        no_load_speed_rad_s: None,
        brake: None,
    };

    /// One that does nothing but turn, as told, the link it drives.
    pub fn of(actuation: Actuation) -> Self {
        Self { actuation, ..Self::NONE }
    }
}
