//! A scene of kind "gripper": two fingers, an object between them that may move, the palm, and a table.

use super::{Actuation, Brake, Contacts, Engine, GripperBounds, Initial, Integrator, LogRates, PalmMotion};
use crate::gripper::{Finger, Site, Spring};
use crate::law::{Bristle, ContactLaw, NormalLaw};

/// A resolved scene of a gripper, in SI. Its frame G has its origin in the middle of the palm, x along it and y out of it.
#[derive(Clone, Debug, PartialEq)]
pub struct GripperScene {
    pub name: String,
    /// What the scene is for, in the user's words; empty if nothing was said.
    pub description: String,
    /// The exact text of the file, kept for the log's attachment.
    pub source: String,
    /// Right and left; everything of the left one is that of its mirror image about x = 0.
    pub fingers: [GripperFinger; 2],
    /// Distance between the fingers' ground joints.
    pub palm_width_m: f64,
    pub object: GripperObject,
    /// The half plane y ≤ 0 of G, for the object only; `None` where it is open.
    pub palm: Option<ContactLaw>,
    pub table: Option<Table>,
    /// One input that drives both fingers.
    pub differential: Option<Differential>,
    /// `None` where the palm is at rest.
    pub palm_motion: Option<PalmMotion>,
    pub gravity_m_s2: [f64; 2],
    pub duration_s: f64,
    pub integrator: Integrator,
    pub engine: Engine,
    pub bounds: GripperBounds,
    pub log: LogRates,
}

/// One finger of a gripper, in its own frame: ground joint at the origin, the object to its left.
#[derive(Clone, Debug, PartialEq)]
pub struct GripperFinger {
    pub finger: Finger,
    pub motor: Motor,
    pub spring: Option<Spring>,
    /// Joint limit q22 ≥ −φ22; `None` switches it off.
    pub limit: Option<NormalLaw>,
    /// Laws of its contacts with the object.
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

/// What is grasped: a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GripperObject {
    pub radius_m: f64,
    /// Where its centre starts.
    pub centre_m: [f64; 2],
    pub angle_rad: f64,
    pub motion: ObjectMotion,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObjectMotion {
    Fixed,
    Free { mass_kg: f64, inertia_kg_m2: f64, velocity_m_s: [f64; 2], spin_rad_s: f64 },
}

/// The half plane y ≥ level of the world, at rest; the palm starts where world and gripper have one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table {
    pub level_m: f64,
    pub contact: ContactLaw,
}

/// Where something can touch: three sites of either finger, the object on the palm, and on the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    Finger(Side, Site),
    Palm,
    Table,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Right,
    Left,
}

impl Motor {
    /// None at all: that of a finger which a differential drives.
    pub const NONE: Self = Motor {
        actuation: Actuation::Constant { torque_n_m: 0.0 },
        inertia_kg_m2: 0.0,
        no_load_speed_rad_s: None,
        brake: None,
    };
}

impl Side {
    pub const BOTH: [Self; 2] = [Side::Right, Side::Left];

    /// +1 where x of the finger's frame is that of G, −1 where it is its mirror image.
    #[inline]
    pub fn mirror(self) -> f64 {
        if self == Side::Right { 1.0 } else { -1.0 }
    }

    pub fn word(self) -> &'static str {
        if self == Side::Right { "right" } else { "left" }
    }
}

impl Place {
    /// All places, in the order in which both models count them.
    pub const ALL: [Self; 8] = [
        Place::Finger(Side::Right, Site::Proximal),
        Place::Finger(Side::Right, Site::Distal),
        Place::Finger(Side::Right, Site::Limit),
        Place::Finger(Side::Left, Site::Proximal),
        Place::Finger(Side::Left, Site::Distal),
        Place::Finger(Side::Left, Site::Limit),
        Place::Palm,
        Place::Table,
    ];

    /// Whether it is the stop of a joint, whose gap is an angle.
    #[inline]
    pub fn is_stop(self) -> bool {
        matches!(self, Place::Finger(_, Site::Limit))
    }

    /// Where it is in [`Place::ALL`].
    #[inline(always)]
    pub fn index(self) -> usize {
        match self {
            Place::Finger(side, site) => Site::ALL.len() * side as usize + site as usize,
            Place::Palm => 6,
            Place::Table => 7,
        }
    }

    /// Name in reports, keys and topics: `right_distal`, `palm`.
    pub fn name(self) -> String {
        match self {
            Place::Finger(side, site) => format!("{}_{}", side.word(), site.name()),
            Place::Palm => "palm".to_string(),
            Place::Table => "table".to_string(),
        }
    }
}

impl GripperScene {
    #[inline]
    pub fn finger(&self, side: Side) -> &GripperFinger {
        &self.fingers[side as usize]
    }

    /// What holds at a place; joint limits have no friction.
    #[inline]
    pub fn bristle(&self, place: Place) -> Option<Bristle> {
        let law = match place {
            Place::Finger(side, Site::Proximal) => Some(self.finger(side).contact.proximal),
            Place::Finger(side, Site::Distal) => Some(self.finger(side).contact.distal),
            Place::Finger(_, Site::Limit) => None,
            Place::Palm => self.palm,
            Place::Table => self.table.map(|table| table.contact),
        };
        law.and_then(|law| law.bristle())
    }

    /// Whether friction holds anywhere: in a contact or in a brake.
    #[inline]
    pub fn holds(&self) -> bool {
        let held = Place::ALL.into_iter().any(|place| self.bristle(place).is_some());
        let input = self.differential.iter().map(|differential| &differential.motor);
        let motors = self.fingers.iter().map(|finger| &finger.motor).chain(input);
        held || motors.into_iter().any(|motor| motor.brake.is_some_and(|brake| brake.bristle.is_some()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_is_where_its_index_says() {
        for (index, place) in Place::ALL.into_iter().enumerate() {
            assert_eq!(place.index(), index, "{place:?}");
        }
    }
}
