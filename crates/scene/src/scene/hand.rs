//! A hand of one or two five-bar fingers with its object, and its possible contacts. The builder makes a mechanism of it;
//! closed forms, statics and criteria of grasps read it.

use crate::drive::{Brake, Profile};
use crate::gripper::{Finger, FingerContact, Spring};
use crate::law::{ContactLaw, FrictionLaw, NormalLaw};
use crate::mechanism::{Mechanism, OutlineId};
use crate::palm_motion::PalmMotion;
use crate::shape::{PlacedShape, Shape};
use crate::statics::GraspKeys;
pub use crate::statics::Side;
use std::borrow::Cow;

/// Fingers, the object that they grasp, planes and contact laws, in SI units.
///
/// If a program has built the hand, [`Hand::unsupported`] checks whether the models support it.
///
/// Coordinates are those of the palm frame: its origin is in the middle of the palm, x points along the palm and y out
/// of it. If the palm is at rest or missing, it is the world frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Hand {
    /// One finger, or the right and the left finger. The left finger is described by its mirror image about x = 0.
    pub fingers: Vec<HandFinger>,
    /// Distance between the ground joints of two fingers; 0 for one finger, whose ground joint is at the origin.
    pub palm_width_m: f64,
    /// Differential that drives both fingers.
    pub differential: Option<Differential>,
    pub object: Option<Object>,
    /// The solid half plane below the object. Only the object touches it.
    pub palm: Option<HalfPlane>,
    /// The solid half plane above the object. It is at rest in the world frame, which is the initial palm frame.
    pub table: Option<HalfPlane>,
    /// Motion of the palm; `None` if the palm is at rest.
    pub palm_motion: Option<PalmMotion>,
    pub gravity_m_s2: [f64; 2],
}

impl Hand {
    /// The hand without fingers and object, as in scenes of mechanisms.
    pub const EMPTY: Self = Self {
        fingers: Vec::new(),
        palm_width_m: 0.0,
        differential: None,
        object: None,
        palm: None,
        table: None,
        palm_motion: None,
        gravity_m_s2: [0.0; 2],
    };

    /// Returns the finger on a side; a single finger is on the right.
    ///
    /// # Panics
    /// Panics if the finger does not exist.
    #[inline]
    pub fn finger(&self, side: Side) -> &HandFinger {
        &self.fingers[side as usize]
    }

    /// All fingers, each with its side.
    pub fn fingers_by_side(&self) -> impl Iterator<Item = (Side, &HandFinger)> {
        Side::BOTH.into_iter().zip(&self.fingers)
    }

    /// Returns the object if it can move; `None` if it is fixed, or without an object.
    pub fn moving_object(&self) -> Option<&Object> {
        self.object.as_ref().filter(|object| object.motion != ObjectMotion::Fixed)
    }

    /// Returns the hand with a fixed object as one that moves, so that it is a body of the mechanism. Neither palm nor table
    /// can touch such an object.
    pub(crate) fn judged(&self) -> Cow<'_, Hand> {
        let Some(Object { motion: ObjectMotion::Fixed, .. }) = self.object else { return Cow::Borrowed(self) };
        let motion = ObjectMotion::Free { mass_kg: 0.0, inertia_kg_m2: 0.0, velocity_m_s: [0.0; 2], spin_rad_s: 0.0 };
        let object = self.object.clone().map(|object| Object { motion, ..object });
        Cow::Owned(Hand { object, palm: None, table: None, ..self.clone() })
    }

    /// Returns the object, the base and the surroundings of the grasp in a mechanism of the hand, and its release in a run of
    /// this duration. The base is the palm, which is the ground unless it moves; the table is no part of the hand.
    pub(crate) fn grasp_keys(&self, mechanism: &Mechanism, duration_s: f64) -> GraspKeys {
        let table = mechanism.ground_outlines.iter().position(|outline| outline.name == HandContact::Table.name());
        GraspKeys {
            object: mechanism.bodies.iter().position(|body| body.name == Object::NAME),
            base: Some(mechanism.palm().map(|(palm, _)| palm)),
            surroundings: table.map(|outline| OutlineId { body: None, outline }).into_iter().collect(),
            release_s: self.cycle(duration_s).release_s,
        }
    }

    /// Returns the object of a gripper, which always has one.
    ///
    /// # Panics
    /// Panics if there is no object.
    #[inline]
    pub fn grasped(&self) -> &Object {
        self.object.as_ref().expect("a gripper has an object")
    }

    /// Mutable access to [`Hand::grasped`].
    ///
    /// # Panics
    /// Panics if there is no object.
    pub fn grasped_mut(&mut self) -> &mut Object {
        self.object.as_mut().expect("a gripper has an object")
    }

    /// Contacts in the order of samples and of [`Hand::mechanism`]: first those of surfaces that can move relative to
    /// each other, then the joint limits.
    pub fn contacts(&self) -> impl Iterator<Item = HandContact> {
        let of_kind = |is_stop| {
            let all = HandContact::ALL.into_iter();
            all.filter(move |contact| contact.is_stop() == is_stop && self.contact_laws(*contact).is_some())
        };
        of_kind(false).chain(of_kind(true))
    }

    /// Index of a contact in samples; `None` if one of its surfaces does not exist.
    pub fn contact_index(&self, contact: HandContact) -> Option<usize> {
        self.contacts().position(|other| other == contact)
    }

    /// Laws of a contact; `None` if one of its surfaces does not exist.
    pub fn contact_laws(&self, contact: HandContact) -> Option<(NormalLaw, Option<FrictionLaw>)> {
        match contact {
            HandContact::Finger(side, _) if side as usize >= self.fingers.len() => return None,
            HandContact::Finger(side, FingerContact::Limit) => {
                return self.finger(side).limit.map(|normal| (normal, None));
            }
            HandContact::Finger(..) => self.object.as_ref()?,
            HandContact::Palm | HandContact::Table => self.moving_object()?,
        };
        self.law(contact).map(|law| (law.normal, law.friction))
    }

    /// Contact law; `None` for a joint limit, which is not a contact between two surfaces.
    #[inline]
    pub fn law(&self, contact: HandContact) -> Option<ContactLaw> {
        match contact {
            HandContact::Finger(side, finger_contact) => self.finger(side).law(finger_contact),
            HandContact::Palm => self.palm.and_then(|palm| palm.contact),
            HandContact::Table => self.table.and_then(|table| table.contact),
        }
    }

    /// Length of the shortest link, m; infinite without fingers.
    pub fn shortest_link_m(&self) -> f64 {
        let lengths = self.fingers.iter().map(|finger| finger.linkage.lengths);
        lengths
            .flat_map(|lengths_of_finger| {
                [lengths_of_finger.l11_m, lengths_of_finger.l12_m, lengths_of_finger.l21_m, lengths_of_finger.l22_m]
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// Largest motor torque over the length of the proximal phalanx, N; 0 without fingers.
    pub(crate) fn motor_force_n(&self) -> f64 {
        let input = self.differential.as_ref().map(|differential| &differential.motor);
        let force = |finger: &HandFinger| {
            let motor_torque = finger.motor.actuation.largest();
            let half = input.map_or(0.0, |motor| 0.5 * motor.actuation.largest());
            motor_torque.max(half) / finger.linkage.lengths.l21_m
        };
        self.fingers.iter().map(force).fold(0.0, f64::max)
    }

    /// Whether any contact or brake has stiction: friction with an internal state.
    pub fn has_stiction(&self) -> bool {
        let mut laws = self.contacts().filter_map(|contact| self.contact_laws(contact)?.1);
        let input = self.differential.iter().map(|differential| &differential.motor);
        let mut motors = self.fingers.iter().map(|finger| &finger.motor).chain(input);
        laws.any(|friction| friction.has_state())
            || motors.any(|motor| motor.brake.is_some_and(|brake| brake.bristle.is_some()))
    }

    /// Narrowest slip range of any friction law, m/s; infinite without friction.
    pub(crate) fn narrowest_slip_range_m_s(&self) -> f64 {
        let laws = self.contacts().filter_map(|contact| self.contact_laws(contact)?.1);
        laws.map(|friction| friction.min_slip_scale_m_s()).fold(f64::INFINITY, f64::min)
    }

    /// Returns the reason why neither model supports the hand, and how to change this; `None` if it is supported.
    pub fn unsupported(&self) -> Option<&'static str> {
        let (fingers, moves) = (self.fingers.len(), self.palm_motion.is_some());
        let is_fixed = self.object.is_some() && self.moving_object().is_none();
        let conditions = [
            (fingers == 0, "the hand has no fingers: add one"),
            (fingers > 2, "the hand has more than two fingers: remove all except a right and a left one"),
            (
                fingers < 2 && self.differential.is_some(),
                "a differential requires two fingers: remove it, or add the other finger",
            ),
            (
                moves && is_fixed,
                "the palm moves, but the object is fixed: remove the motion of the palm, or make the object free",
            ),
        ];
        conditions.iter().find(|(holds, _)| *holds).map(|(_, reason)| *reason)
    }
}

/// A finger in its own frame: the ground joint is at the origin, the object on the left.
#[derive(Clone, Debug, PartialEq)]
pub struct HandFinger {
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
    pub actuation: Profile,
    /// Inertia of rotor and gear, reflected to the driven link.
    pub inertia_kg_m2: f64,
    /// Rate at which the torque has fallen to 0; `None` if the torque does not depend on the rate.
    pub no_load_speed_rad_s: Option<f64>,
    pub brake: Option<Brake>,
}

/// A seesaw with one input and two outputs. Each finger gets half of the torque. The angle of the input is the mean of
/// the two outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Differential {
    /// Motor at the input. Its inertia is J_in.
    pub motor: Motor,
    /// J_s: inertia of the seesaw. Its angle is half the difference of the two outputs.
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

/// Initial angles of the joints, and initial rates of the two generalised coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Initial {
    pub q11_rad: f64,
    pub q21_rad: f64,
    pub qd11_rad_s: f64,
    pub qd21_rad_s: f64,
}

impl HandFinger {
    /// Law of a contact; `None` for the joint limit, which is not a contact between two surfaces.
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
    /// No motor, as for fingers driven by a differential.
    pub const NONE: Self = Motor {
        actuation: Profile::Constant { value: 0.0 },
        inertia_kg_m2: 0.0,
        no_load_speed_rad_s: None,
        brake: None,
    };

    /// Creates an ideal torque source without inertia, speed limit or brake.
    pub fn from_actuation(actuation: Profile) -> Self {
        Self { actuation, ..Self::NONE }
    }
}

/// The object that the fingers grasp.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    pub shape: Shape,
    /// Initial position of the centre.
    pub centre_m: [f64; 2],
    pub angle_rad: f64,
    pub motion: ObjectMotion,
}

/// Motion of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ObjectMotion {
    Fixed,
    /// Moves under gravity and contact forces.
    Free {
        mass_kg: f64,
        inertia_kg_m2: f64,
        velocity_m_s: [f64; 2],
        spin_rad_s: f64,
    },
}

/// A half plane bounded by a horizontal line: solid below it for a palm, above it for a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlane {
    pub level_m: f64,
    /// Contact law for the object; `None` if no moving object can reach the half plane.
    pub contact: Option<ContactLaw>,
}

impl Object {
    pub const NAME: &str = "object";

    /// Creates a fixed object.
    pub fn fixed(placed: PlacedShape) -> Self {
        let PlacedShape { shape, centre_m, angle_rad } = placed;
        Self { shape, centre_m, angle_rad, motion: ObjectMotion::Fixed }
    }

    /// Shape and initial pose.
    pub fn placed(&self) -> PlacedShape {
        PlacedShape { shape: self.shape, centre_m: self.centre_m, angle_rad: self.angle_rad }
    }
}

/// A possible contact of a hand: three for each finger, and the contacts of the object with palm and table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HandContact {
    Finger(Side, FingerContact),
    Palm,
    Table,
}

impl HandContact {
    /// All contacts, in the order of the closed form of a gripper.
    pub const ALL: [Self; 8] = [
        HandContact::Finger(Side::Right, FingerContact::Proximal),
        HandContact::Finger(Side::Right, FingerContact::Distal),
        HandContact::Finger(Side::Right, FingerContact::Limit),
        HandContact::Finger(Side::Left, FingerContact::Proximal),
        HandContact::Finger(Side::Left, FingerContact::Distal),
        HandContact::Finger(Side::Left, FingerContact::Limit),
        HandContact::Palm,
        HandContact::Table,
    ];

    /// Whether the contact is a joint stop, whose gap is an angle.
    #[inline]
    pub fn is_stop(self) -> bool {
        matches!(self, HandContact::Finger(_, FingerContact::Limit))
    }

    /// Index in [`HandContact::ALL`].
    #[inline(always)]
    pub fn index(self) -> usize {
        match self {
            HandContact::Finger(side, finger_contact) => {
                FingerContact::ALL.len() * side as usize + finger_contact as usize
            }
            HandContact::Palm => 6,
            HandContact::Table => 7,
        }
    }

    /// Name in reports, keys and topics for a hand with `fingers` fingers. Examples are `distal` and `object-palm` for
    /// one finger, `right_distal` and `palm` for two.
    pub fn name_for(self, fingers: usize) -> String {
        match self {
            HandContact::Finger(_, finger_contact) if fingers == 1 => finger_contact.name().to_string(),
            HandContact::Palm | HandContact::Table if fingers == 1 => {
                format!("{}-{}", Object::NAME, self.name())
            }
            _ => self.name(),
        }
    }

    /// Name in a hand with two fingers.
    pub fn name(self) -> String {
        match self {
            HandContact::Finger(side, finger_contact) => format!("{}_{}", side.name(), finger_contact.name()),
            HandContact::Palm => "palm".to_string(),
            HandContact::Table => "table".to_string(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn index_agrees_with_order_of_all() {
        for (index, contact) in HandContact::ALL.into_iter().enumerate() {
            assert_eq!(contact.index(), index, "{contact:?}");
        }
    }
}
