//! What is simulated: the one description that both models read, as plain lists.

use super::torque::largest_torque;
use super::words::SceneKind;
use super::{Differential, Disc, DiscMotion, DrivenFinger, HalfPlane, PalmMotion, Place, Side};
use crate::gripper::Site;
use crate::law::{Bristle, ContactLaw};

/// Fingers, discs, planes and the laws by which they touch, in SI.
///
/// Where a program puts one together, [`System::objection`] says what runs take.
///
/// The frame is the palm's: its origin is in the palm's middle, x along it and y out of it. Where the palm is at rest, and where there
/// is none, that is the world.
#[derive(Clone, Debug, PartialEq)]
pub struct System {
    /// None, one alone, or right and left; everything of the left one is that of its mirror image about x = 0.
    pub fingers: Vec<DrivenFinger>,
    /// Distance between the ground joints of two fingers; 0 of one, whose ground joint is the origin.
    pub palm_width_m: f64,
    /// One input that drives both fingers.
    pub differential: Option<Differential>,
    /// Where there are fingers, the first is what they grasp: all that scene files have with fingers. Without fingers they are in the order
    /// of their names.
    pub discs: Vec<Disc>,
    /// Law by which discs touch one another; `None` where there are fewer than two.
    pub between_discs: Option<ContactLaw>,
    /// What is solid below: the palm, for discs only, or the ground; `None` where it is open.
    pub palm: Option<HalfPlane>,
    /// What is solid above, at rest in the world; the palm starts where world and palm have one frame.
    pub table: Option<HalfPlane>,
    /// `None` where the palm is at rest.
    pub palm_motion: Option<PalmMotion>,
    pub gravity_m_s2: [f64; 2],
}

impl System {
    /// Of which kind it is.
    pub fn kind(&self) -> SceneKind {
        match self.fingers.len() {
            0 => SceneKind::Bodies,
            1 => SceneKind::Finger,
            _ => SceneKind::Gripper,
        }
    }

    /// A finger by its side; one that is alone is a right one.
    ///
    /// # Panics
    /// Where there is none.
    #[inline]
    pub fn finger(&self, side: Side) -> &DrivenFinger {
        &self.fingers[side as usize]
    }

    /// The fingers, each with its side.
    pub fn sided(&self) -> impl Iterator<Item = (Side, &DrivenFinger)> {
        Side::BOTH.into_iter().zip(&self.fingers)
    }

    /// What fingers grasp.
    #[inline]
    pub fn object(&self) -> Option<&Disc> {
        self.discs.first().filter(|_| !self.fingers.is_empty())
    }

    /// What fingers grasp, if it moves.
    pub fn moving_object(&self) -> Option<&Disc> {
        self.object().filter(|object| object.motion != DiscMotion::Fixed)
    }

    /// What the fingers of a gripper grasp.
    ///
    /// # Panics
    /// Where nothing is there: a gripper has always something to grasp.
    #[inline]
    pub fn grasped(&self) -> &Disc {
        self.object().expect("something to grasp")
    }

    /// The same, to be changed.
    ///
    /// # Panics
    /// Where nothing is there.
    pub fn grasped_mut(&mut self) -> &mut Disc {
        self.discs.first_mut().expect("something to grasp")
    }

    /// Where fingers and what they grasp can touch, in the order of samples.
    #[inline]
    pub fn places(&self) -> &'static [Place] {
        Place::of_fingers(self.fingers.len())
    }

    /// Whether there is something to touch, or a stop, at one of them.
    pub fn is_there(&self, place: Place) -> bool {
        match place {
            Place::Finger(side, Site::Limit) => self.finger(side).limit.is_some(),
            Place::Finger(..) => self.object().is_some(),
            Place::Palm => self.palm.is_some(),
            Place::Table => self.table.is_some(),
        }
    }

    /// Name of a place in reports, keys and topics.
    pub fn place_name(&self, place: Place) -> String {
        place.name_among(self.fingers.len())
    }

    /// The discs that samples tell of: what one finger closes on is none of them, if it is alone and does not move.
    pub fn told_discs(&self) -> &[Disc] {
        let is_still = self.fingers.len() == 1 && self.discs.len() < 2 && self.moving_object().is_none();
        if is_still { &[] } else { &self.discs }
    }

    /// The law of a place; a joint limit has none of two surfaces.
    #[inline]
    pub fn law(&self, place: Place) -> Option<ContactLaw> {
        match place {
            Place::Finger(side, site) => self.finger(side).law(site),
            Place::Palm => self.palm.and_then(|palm| palm.contact),
            Place::Table => self.table.and_then(|table| table.contact),
        }
    }

    /// What holds at a place.
    #[inline]
    pub fn bristle(&self, place: Place) -> Option<Bristle> {
        self.law(place).and_then(|law| law.bristle())
    }

    /// Length of the shortest link, m; infinite without fingers.
    pub fn shortest_link_m(&self) -> f64 {
        let lengths = self.fingers.iter().map(|finger| finger.linkage.lengths);
        lengths.flat_map(|of| [of.l11_m, of.l12_m, of.l21_m, of.l22_m]).fold(f64::INFINITY, f64::min)
    }

    /// Largest force, N, that a motor exerts at the end of a proximal phalanx; 0 without fingers.
    pub fn motor_force_n(&self) -> f64 {
        let input = self.differential.as_ref().map(|differential| &differential.motor);
        let force = |finger: &DrivenFinger| {
            let own = largest_torque(&finger.motor.actuation);
            let half = input.map_or(0.0, |motor| 0.5 * largest_torque(&motor.actuation));
            own.max(half) / finger.linkage.lengths.l21_m
        };
        self.fingers.iter().map(force).fold(0.0, f64::max)
    }

    /// Whether friction holds anywhere: in a contact or in a brake.
    #[inline]
    pub fn holds(&self) -> bool {
        let phalanges = self.fingers.iter().filter(|_| self.object().is_some());
        let sites = phalanges.flat_map(|finger| Site::ALL.into_iter().filter_map(|site| finger.law(site)));
        let planes = self.palm.iter().chain(&self.table).filter_map(|plane| plane.contact);
        let mut laws = sites.chain(planes).chain(self.between_discs);
        let input = self.differential.iter().map(|differential| &differential.motor);
        let mut motors = self.fingers.iter().map(|finger| &finger.motor).chain(input);
        laws.any(|law| law.bristle().is_some())
            || motors.any(|motor| motor.brake.is_some_and(|brake| brake.bristle.is_some()))
    }
}
