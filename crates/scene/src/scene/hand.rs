//! A hand of five-bar fingers with its object, as plain lists of fingers, discs and planes, and its possible contacts. The
//! builder makes a mechanism of it; closed forms, statics and criteria of grasps read it.

use super::keywords::SceneKind;
use crate::drive::{Brake, Profile};
use crate::gripper::{Finger, FingerContact, Spring};
use crate::law::{Bristle, ContactLaw, FrictionLaw, NormalLaw};
use crate::palm_motion::PalmMotion;
use crate::shape::{PlacedShape, Shape};
pub use crate::statics::Side;

/// Fingers, discs, planes and their contact laws, in SI units.
///
/// For a hand built by a program, [`Hand::unsupported`] checks whether the models support it.
///
/// Coordinates are those of the palm frame: origin in the middle of the palm, x along it and y out of it. It is the
/// world frame if the palm is at rest or missing.
#[derive(Clone, Debug, PartialEq)]
pub struct Hand {
    /// None, one, or right and left. The left finger is described by its mirror image about x = 0.
    pub fingers: Vec<HandFinger>,
    /// Distance between the ground joints of two fingers; 0 for one finger, with its ground joint at the origin.
    pub palm_width_m: f64,
    /// Differential that drives both fingers.
    pub differential: Option<Differential>,
    /// With fingers, the first disc is the grasped object, the only disc that scene files allow. Without fingers, discs
    /// are ordered by name.
    pub discs: Vec<Disc>,
    /// Contact law between discs; `None` for fewer than two discs.
    pub between_discs: Option<ContactLaw>,
    /// The solid half plane below: the palm, which only discs touch, or the ground.
    pub palm: Option<HalfPlane>,
    /// The solid half plane above, at rest in the world frame, which is the initial palm frame.
    pub table: Option<HalfPlane>,
    /// Motion of the palm; `None` if the palm is at rest.
    pub palm_motion: Option<PalmMotion>,
    pub gravity_m_s2: [f64; 2],
}

impl Hand {
    /// A hand without fingers and discs, in scenes of mechanisms.
    pub const EMPTY: Self = Self {
        fingers: Vec::new(),
        palm_width_m: 0.0,
        differential: None,
        discs: Vec::new(),
        between_discs: None,
        palm: None,
        table: None,
        palm_motion: None,
        gravity_m_s2: [0.0; 2],
    };

    pub fn kind(&self) -> SceneKind {
        match self.fingers.len() {
            0 => SceneKind::Bodies,
            1 => SceneKind::Finger,
            _ => SceneKind::Gripper,
        }
    }

    /// Returns the finger on a side; a single finger is on the right.
    ///
    /// # Panics
    /// Panics if the finger does not exist.
    #[inline]
    pub fn finger(&self, side: Side) -> &HandFinger {
        &self.fingers[side as usize]
    }

    /// All fingers with their sides.
    pub fn fingers_by_side(&self) -> impl Iterator<Item = (Side, &HandFinger)> {
        Side::BOTH.into_iter().zip(&self.fingers)
    }

    /// Returns the object that fingers grasp.
    #[inline]
    pub fn object(&self) -> Option<&Disc> {
        self.discs.first().filter(|_| !self.fingers.is_empty())
    }

    /// Returns the grasped object, if it moves.
    pub fn moving_object(&self) -> Option<&Disc> {
        self.object().filter(|object| object.motion != DiscMotion::Fixed)
    }

    /// Returns the object of a gripper, which always has one.
    ///
    /// # Panics
    /// Panics if there is no object.
    #[inline]
    pub fn grasped(&self) -> &Disc {
        self.object().expect("a gripper has an object")
    }

    /// Mutable access to [`Hand::grasped`].
    ///
    /// # Panics
    /// Panics if there is no object.
    pub fn grasped_mut(&mut self) -> &mut Disc {
        self.discs.first_mut().expect("a gripper has an object")
    }

    /// Possible contacts of fingers and object, in the order of samples.
    #[inline]
    pub fn gripper_contacts(&self) -> &'static [GripperContact] {
        GripperContact::for_fingers(self.fingers.len())
    }

    /// Whether the surfaces of a contact exist.
    pub fn has_contact(&self, contact: GripperContact) -> bool {
        match contact {
            GripperContact::Finger(side, FingerContact::Limit) => self.finger(side).limit.is_some(),
            GripperContact::Finger(..) => self.object().is_some(),
            GripperContact::Palm => self.palm.is_some(),
            GripperContact::Table => self.table.is_some(),
        }
    }

    /// Discs that samples report: all, except a single fixed object of one finger.
    pub fn reported_discs(&self) -> &[Disc] {
        let only_fixed_object = self.fingers.len() == 1 && self.discs.len() < 2 && self.moving_object().is_none();
        if only_fixed_object { &[] } else { &self.discs }
    }

    /// Contact law; `None` for a joint limit, which is not a contact of two surfaces.
    #[inline]
    pub fn law(&self, contact: GripperContact) -> Option<ContactLaw> {
        match contact {
            GripperContact::Finger(side, finger_contact) => self.finger(side).law(finger_contact),
            GripperContact::Palm => self.palm.and_then(|palm| palm.contact),
            GripperContact::Table => self.table.and_then(|table| table.contact),
        }
    }

    /// Bristle of the friction law of a contact.
    #[inline]
    pub fn bristle(&self, contact: GripperContact) -> Option<Bristle> {
        self.law(contact).and_then(|law| law.bristle())
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

    /// Whether any contact or brake has stiction, that is, a bristle.
    #[inline]
    pub fn has_stiction(&self) -> bool {
        let phalanges = self.fingers.iter().filter(|_| self.object().is_some());
        let finger_contacts = phalanges
            .flat_map(|finger| FingerContact::ALL.into_iter().filter_map(|finger_contact| finger.law(finger_contact)));
        let planes = self.palm.iter().chain(&self.table).filter_map(|plane| plane.contact);
        let mut laws = finger_contacts.chain(planes).chain(self.between_discs);
        let input = self.differential.iter().map(|differential| &differential.motor);
        let mut motors = self.fingers.iter().map(|finger| &finger.motor).chain(input);
        laws.any(|law| law.bristle().is_some())
            || motors.any(|motor| motor.brake.is_some_and(|brake| brake.bristle.is_some()))
    }

    /// All pairs of discs, or of a disc and the half plane, with at least one that moves, in the order of both models: by
    /// the index of the first disc, then of the second, with the half plane last.
    pub fn pairs(&self) -> Vec<ContactId> {
        let mut pairs = Vec::new();
        for (i, first) in self.discs.iter().enumerate() {
            for (j, second) in self.discs.iter().enumerate().skip(i + 1) {
                match (first.motion.moves(), second.motion.moves()) {
                    (true, _) => pairs.push(ContactId::Discs(i, j)),
                    (false, true) => pairs.push(ContactId::Discs(j, i)),
                    (false, false) => {}
                }
            }
            if self.palm.is_some() && first.motion.moves() {
                pairs.push(ContactId::Palm(i));
            }
        }
        pairs
    }

    /// All possible contacts. With fingers: first [`Hand::gripper_contacts`] with the first disc, whether or not it
    /// exists; then the contacts of the other discs with the fingers; then pairs of discs. Without fingers: only pairs.
    pub fn contact_ids(&self) -> Vec<ContactId> {
        let pairs = self.pairs().into_iter();
        let table_contacts = |from: usize| {
            let moving = (from..self.discs.len()).filter(|disc| self.discs[*disc].motion.moves());
            moving.filter(|_| self.table.is_some()).map(ContactId::Table)
        };
        if self.fingers.is_empty() {
            return pairs.chain(table_contacts(0)).collect();
        }
        let mut all: Vec<ContactId> =
            self.gripper_contacts().iter().map(|gripper_contact| gripper_contact.contact_id(0)).collect();
        let finger_contacts = |(side, disc)| {
            [FingerContact::Proximal, FingerContact::Distal]
                .map(|finger_contact| ContactId::Phalanx(side, finger_contact, disc))
        };
        let others = (1..self.discs.len()).flat_map(|disc| self.fingers_by_side().map(move |(side, _)| (side, disc)));
        all.extend(others.flat_map(finger_contacts));
        // With two fingers, `gripper_contacts` includes the contacts of the first disc with palm and table.
        let is_included = |contact: &ContactId| self.fingers.len() > 1 && matches!(contact, ContactId::Palm(0));
        all.extend(pairs.filter(|contact| !is_included(contact)));
        all.extend(table_contacts(usize::from(self.fingers.len() > 1)));
        all
    }

    /// Name of a contact in reports, keys and topics: `distal`, `left_distal`, `hammer-anvil`, `hammer-plane`; with
    /// fingers, `ball-distal` for all discs except the first.
    pub fn contact_name(&self, contact: ContactId) -> String {
        let (disc, other) = match contact {
            ContactId::Phalanx(side, finger_contact, disc) => {
                (disc, GripperContact::Finger(side, finger_contact).name_for(self.fingers.len()))
            }
            ContactId::Stop(side) => {
                return GripperContact::Finger(side, FingerContact::Limit).name_for(self.fingers.len());
            }
            ContactId::Discs(disc, other) => (disc, self.discs[other].name.clone()),
            ContactId::Palm(disc) if self.fingers.is_empty() => (disc, "plane".to_string()),
            ContactId::Palm(disc) => (disc, GripperContact::Palm.name()),
            ContactId::Table(disc) => (disc, GripperContact::Table.name()),
        };
        let is_gripper_contact =
            self.gripper_contacts().iter().any(|gripper_contact| gripper_contact.contact_id(0) == contact);
        if is_gripper_contact { other } else { format!("{}-{other}", self.discs[disc].name) }
    }

    /// Laws of a contact; `None` if one of its surfaces does not exist.
    pub fn contact_laws(&self, contact: ContactId) -> Option<(NormalLaw, Option<FrictionLaw>)> {
        let law = match contact {
            ContactId::Stop(side) => return self.finger(side).limit.map(|normal| (normal, None)),
            ContactId::Phalanx(side, finger_contact, disc) => {
                self.discs.get(disc).and_then(|_| self.finger(side).law(finger_contact))
            }
            ContactId::Discs(..) => self.between_discs,
            ContactId::Palm(disc) => self.discs.get(disc).and(self.palm).and_then(|palm| palm.contact),
            ContactId::Table(disc) => self.discs.get(disc).and(self.table).and_then(|table| table.contact),
        };
        law.map(|law| (law.normal, law.friction))
    }

    /// Narrowest slip range of any friction law, m/s; infinite without friction.
    pub(crate) fn narrowest_slip_range_m_s(&self) -> f64 {
        let laws = self.contact_ids().into_iter().filter_map(|contact| self.contact_laws(contact)?.1);
        laws.map(|friction| friction.min_slip_scale_m_s()).fold(f64::INFINITY, f64::min)
    }

    /// Returns why neither model supports the hand and how to change it; `None` for a supported one.
    pub fn unsupported(&self) -> Option<&'static str> {
        let (fingers, moves) = (self.fingers.len(), self.palm_motion.is_some());
        let is_free = |disc: &Disc| matches!(disc.motion, DiscMotion::Free { .. });
        let lacks_law = |contact: &ContactId| matches!(contact, ContactId::Discs(..)) && self.between_discs.is_none();
        let conditions = [
            (fingers > 2, "the hand has more than two fingers: remove all except a right and a left one"),
            (
                fingers < 2 && self.differential.is_some(),
                "a differential requires two fingers: remove it, or add the other finger",
            ),
            (fingers == 0 && moves, "a moving palm requires fingers: remove its motion, or add a finger"),
            (
                moves && !self.discs.iter().all(is_free),
                "the palm moves, but a disc is fixed or driven: remove the motion of the palm, or make the disc free",
            ),
            (
                fingers == 0 && self.between_discs.is_none() || fingers < 3 && self.contact_ids().iter().any(lacks_law),
                "the contacts between discs have no law: set between_discs",
            ),
        ];
        conditions.iter().find(|(holds, _)| *holds).map(|(_, reason)| *reason)
    }
}

/// A finger in its own frame: ground joint at the origin, object to its left.
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

impl HandFinger {
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

/// A body with its shape and motion; called a disc whatever its shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Disc {
    pub name: String,
    pub shape: Shape,
    /// Initial position of the centre.
    pub centre_m: [f64; 2],
    pub angle_rad: f64,
    pub motion: DiscMotion,
}

/// Motion of a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiscMotion {
    Fixed,
    /// Prescribed motion, not affected by contacts: x(t) = centre + velocity t + ½ acceleration t², angle = spin t.
    Driven {
        velocity_m_s: [f64; 2],
        acceleration_m_s2: [f64; 2],
        spin_rad_s: f64,
    },
    /// Moves under gravity and contact forces. `inertia_kg_m2` is `None` for a disc that does not rotate.
    Free {
        mass_kg: f64,
        inertia_kg_m2: Option<f64>,
        velocity_m_s: [f64; 2],
        spin_rad_s: f64,
    },
}

/// A half plane bounded by a horizontal line: solid below it for a palm or the ground, above it for a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlane {
    pub level_m: f64,
    /// Law of its contacts with discs; `None` if no moving disc can reach it.
    pub contact: Option<ContactLaw>,
}

impl DiscMotion {
    pub fn moves(&self) -> bool {
        !matches!(self, DiscMotion::Fixed)
    }
}

impl Disc {
    /// Name of the grasped object.
    pub const OBJECT: &str = "object";

    /// Creates a fixed object.
    pub fn fixed_object(placed: PlacedShape) -> Self {
        let PlacedShape { shape, centre_m, angle_rad } = placed;
        Self { name: Self::OBJECT.to_string(), shape, centre_m, angle_rad, motion: DiscMotion::Fixed }
    }

    /// Shape and initial pose.
    pub fn placed(&self) -> PlacedShape {
        PlacedShape { shape: self.shape, centre_m: self.centre_m, angle_rad: self.angle_rad }
    }
}

/// A possible contact of a gripper: three at each finger, and the contacts of the object with palm and table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GripperContact {
    Finger(Side, FingerContact),
    Palm,
    Table,
}

impl GripperContact {
    /// All contacts, in the order of both models.
    pub const ALL: [Self; 8] = [
        GripperContact::Finger(Side::Right, FingerContact::Proximal),
        GripperContact::Finger(Side::Right, FingerContact::Distal),
        GripperContact::Finger(Side::Right, FingerContact::Limit),
        GripperContact::Finger(Side::Left, FingerContact::Proximal),
        GripperContact::Finger(Side::Left, FingerContact::Distal),
        GripperContact::Finger(Side::Left, FingerContact::Limit),
        GripperContact::Palm,
        GripperContact::Table,
    ];

    /// Whether the contact is a joint stop, whose gap is an angle.
    #[inline]
    pub fn is_stop(self) -> bool {
        matches!(self, GripperContact::Finger(_, FingerContact::Limit))
    }

    /// Index in [`GripperContact::ALL`].
    #[inline(always)]
    pub fn index(self) -> usize {
        match self {
            GripperContact::Finger(side, finger_contact) => {
                FingerContact::ALL.len() * side as usize + finger_contact as usize
            }
            GripperContact::Palm => 6,
            GripperContact::Table => 7,
        }
    }

    /// Returns the contacts of a hand with this number of fingers, in the order of [`GripperContact::ALL`].
    pub fn for_fingers(count: usize) -> &'static [Self] {
        &Self::ALL[..[0, FingerContact::ALL.len(), Self::ALL.len()][count]]
    }

    /// Name in reports, keys and topics for a hand with this number of fingers: `distal` with one, `right_distal`
    /// with two.
    pub fn name_for(self, fingers: usize) -> String {
        match self {
            GripperContact::Finger(_, finger_contact) if fingers == 1 => finger_contact.name().to_string(),
            contact => contact.name(),
        }
    }

    /// Name in a hand with two fingers.
    pub fn name(self) -> String {
        match self {
            GripperContact::Finger(side, finger_contact) => format!("{}_{}", side.name(), finger_contact.name()),
            GripperContact::Palm => "palm".to_string(),
            GripperContact::Table => "table".to_string(),
        }
    }

    /// Returns the contact with a given disc.
    pub fn contact_id(self, disc: usize) -> ContactId {
        match self {
            GripperContact::Finger(side, FingerContact::Limit) => ContactId::Stop(side),
            GripperContact::Finger(side, finger_contact) => ContactId::Phalanx(side, finger_contact, disc),
            GripperContact::Palm => ContactId::Palm(disc),
            GripperContact::Table => ContactId::Table(disc),
        }
    }
}

/// Two surfaces that may come into contact, or the stop of a joint. Discs are identified by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactId {
    /// A phalanx and a disc.
    Phalanx(Side, FingerContact, usize),
    Stop(Side),
    /// Two discs; the first one moves.
    Discs(usize, usize),
    /// A disc on palm or ground.
    Palm(usize),
    Table(usize),
}

impl ContactId {
    /// Whether the contact is a joint stop, whose gap is an angle.
    pub fn is_stop(self) -> bool {
        matches!(self, ContactId::Stop(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn index_agrees_with_order_of_all() {
        for (index, contact) in GripperContact::ALL.into_iter().enumerate() {
            assert_eq!(contact.index(), index, "{contact:?}");
        }
    }
}
