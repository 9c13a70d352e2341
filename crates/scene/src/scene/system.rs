//! The simulated system: the description that both models read, as plain lists.

use super::keywords::SceneKind;
use super::torque::largest_torque;
use super::{Differential, Disc, DiscMotion, DrivenFinger, GripperContact, HalfPlane, PalmMotion, Side};
use crate::gripper::FingerContact;
use crate::law::{Bristle, ContactLaw};

/// Fingers, discs, planes and their contact laws, in SI units.
///
/// For a system built by a program, [`System::unsupported`] checks whether the models support it.
///
/// Coordinates are those of the palm frame: origin in the middle of the palm, x along it and y out of it. It is the
/// world frame if the palm is at rest or missing.
#[derive(Clone, Debug, PartialEq)]
pub struct System {
    /// None, one, or right and left. The left finger is described by its mirror image about x = 0.
    pub fingers: Vec<DrivenFinger>,
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

impl System {
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
    pub fn finger(&self, side: Side) -> &DrivenFinger {
        &self.fingers[side as usize]
    }

    /// All fingers with their sides.
    pub fn fingers_by_side(&self) -> impl Iterator<Item = (Side, &DrivenFinger)> {
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

    /// Mutable access to [`System::grasped`].
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
        let force = |finger: &DrivenFinger| {
            let motor_torque = largest_torque(&finger.motor.actuation);
            let half = input.map_or(0.0, |motor| 0.5 * largest_torque(&motor.actuation));
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
}
