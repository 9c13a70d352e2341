//! The constant data of a hand, and the layout of its coordinates.

use super::components::{ContactModel, ContactPair, FingerComponent, HandDrive, ObjectComponent, Plane};
use super::{CONTACTS, FINGERS, GRASP_POSITIONS, GraspLayout, QUADRATURES};
use crate::analytic::closed_form::FingerModel;
use crate::fivebar::dynamics::{InertialForces, Terms};
use crate::gripper::FingerContact;
use crate::integrator::State;
use crate::law::Bristle;
use crate::numeric::array_from;
use crate::scene::{ContactOrder, Hand, HandContact, HandFinger, ObjectMotion, PalmMotion, Profile, Side};
use crate::shape::PlacedShape;

/// Position-dependent terms of both fingers.
pub(crate) type FingerTerms = [Terms<f64>; FINGERS];

/// The model of a gripper with at most N coordinates.
#[derive(Clone, Debug)]
pub struct Multibody<const N: usize> {
    pub(super) fingers: Vec<FingerComponent>,
    object: Option<ObjectComponent>,
    /// Contacts in the order of [`HandContact::ALL`]; `None` where the scene has no such surface.
    pub(super) contacts: [Option<ContactModel>; CONTACTS],
    pub(super) drives: Vec<HandDrive>,
    /// Index of the brake's bristle among the rates, for each drive.
    pub(super) brake_bristles: Vec<Option<usize>>,
    /// All bristles, with their indices among the rates.
    pub(super) bristles: Vec<(usize, Bristle)>,
    /// Inertia on (q11, q11) in addition to each finger's own mass matrix.
    pub(super) rotor_inertia: [f64; FINGERS],
    /// Entry of the mass matrix that couples both driven links.
    pub(super) coupling: f64,
    pub(super) palm_motion: Option<PalmMotion>,
    /// First coordinate of the object; beyond the last coordinate if it is fixed.
    object_coordinate: usize,
    /// Index of time among the coordinates of a moving palm.
    pub(super) time_index: Option<usize>,
    half_palm_width: f64,
    pub(super) gravity: [f64; 2],
    /// Index in `drives` of each actuator of the mechanism.
    actuators: Vec<usize>,
    contact_order: ContactOrder,
}

/// Builds a contact; `None` where the scene has no surface to touch.
fn build_contact(hand: &Hand, contact: HandContact) -> Option<ContactModel> {
    let plane = |level_m: Option<f64>, up| Plane::at_level(level_m.unwrap_or(f64::NAN), up);
    let pair = match contact {
        HandContact::Finger(side, FingerContact::Limit) => ContactPair::Stop { finger: side as usize },
        HandContact::Finger(side, phalanx) => ContactPair::Phalanx { finger: side as usize, phalanx },
        HandContact::Palm => ContactPair::Plane(plane(hand.palm.map(|palm| palm.level_m), 1.0)),
        HandContact::Table => {
            let plane = plane(hand.table.map(|table| table.level_m), -1.0);
            if hand.palm_motion.is_some() { ContactPair::MovingPlane(plane) } else { ContactPair::Plane(plane) }
        }
    };
    hand.contact_laws(contact).map(|laws| ContactModel::new(pair, laws))
}

impl<const N: usize> Multibody<N> {
    /// Builds the model.
    ///
    /// # Panics
    ///
    /// Panics if the hand does not have two fingers, or has another number of coordinates.
    pub fn new(hand: &Hand) -> Self {
        assert_eq!(hand.fingers.len(), FINGERS, "fingers of a gripper");
        let [x, y] = hand.gravity_m_s2;
        let half_palm_width = 0.5 * hand.palm_width_m;
        let fingers_end = 2 * FINGERS;
        let object_end = fingers_end + if hand.moving_object().is_some() { 3 } else { 0 };
        let positions = object_end + usize::from(hand.palm_motion.is_some());
        assert!(!Self::GRASP || positions == N, "{positions} coordinates instead of {N}");
        let (time_index, first_bristle) = match Self::POSITIONS < N {
            true => (Self::POSITIONS - 1, Self::POSITIONS),
            false => (object_end, positions),
        };
        let mut contacts = HandContact::ALL.map(|contact| build_contact(hand, contact));
        let mut bristles = Vec::new();
        let mut add_bristle = |bristle: Option<Bristle>| {
            let bristle_index = first_bristle + bristles.len();
            bristles.extend(bristle.map(|bristle| (bristle_index, bristle)));
            bristle.map(|_| bristle_index)
        };
        for contact in contacts.iter_mut().flatten() {
            contact.bristle_index = add_bristle(contact.bristle());
        }
        let finger = |(side, finger): (Side, &HandFinger)| FingerComponent {
            side,
            model: FingerModel::new(finger, [side.mirror() * x, y]),
            inertial_load: InertialForces::new(&finger.linkage, [half_palm_width, 0.0]),
        };
        let mut rotor_inertia = [0.0; FINGERS];
        let mut drives = Vec::new();
        for (side, finger) in hand.fingers_by_side() {
            let weights = if side == Side::Right { [1.0, 0.0] } else { [0.0, 1.0] };
            drives.push(HandDrive::new(&finger.motor, weights));
            rotor_inertia[side as usize] = finger.motor.inertia_kg_m2;
        }
        let mut coupling = 0.0;
        if let Some(differential) = &hand.differential {
            drives.push(HandDrive::new(&differential.motor, [0.5, 0.5]));
            let (input, seesaw) = (differential.motor.inertia_kg_m2, differential.seesaw_inertia_kg_m2);
            rotor_inertia.iter_mut().for_each(|inertia| *inertia += (input + seesaw) / 4.0);
            coupling = (input - seesaw) / 4.0;
        }
        let brake_bristles = drives.iter().map(|drive| add_bristle(drive.bristle())).collect();
        assert!(first_bristle + bristles.len() <= N, "{} bristles exceed {N} coordinates", bristles.len());
        let motors = hand.fingers_by_side().filter(|(_, finger)| hand.has_motor(finger)).map(|(side, _)| side as usize);
        let actuators = motors.chain(hand.differential.iter().map(|_| FINGERS));
        Self {
            fingers: hand.fingers_by_side().map(finger).collect(),
            object: hand.object.as_ref().map(ObjectComponent::new),
            object_coordinate: if hand.moving_object().is_some() { fingers_end } else { N },
            contacts,
            brake_bristles,
            bristles,
            drives,
            rotor_inertia,
            coupling,
            palm_motion: hand.palm_motion.clone(),
            time_index: hand.palm_motion.is_some().then_some(time_index),
            half_palm_width,
            gravity: hand.gravity_m_s2,
            actuators: actuators.collect(),
            contact_order: ContactOrder::new(hand),
        }
    }

    /// Order of the contacts in samples.
    pub fn contact_order(&self) -> &ContactOrder {
        &self.contact_order
    }

    /// Returns the coordinates and rates at the start.
    pub fn start(&self, hand: &Hand) -> State<GraspLayout<N>> {
        let mut state = State::<GraspLayout<N>> { q: [0.0; N], v: [0.0; N], z: [0.0; QUADRATURES] };
        for (index, finger) in hand.fingers.iter().enumerate() {
            let initial = &finger.initial;
            (state.q[2 * index], state.q[2 * index + 1]) = (initial.q11_rad, initial.q21_rad);
            (state.v[2 * index], state.v[2 * index + 1]) = (initial.qd11_rad_s, initial.qd21_rad_s);
        }
        if let Some((first, object)) = self.moving_object()
            && let ObjectMotion::Free { velocity_m_s: [vx, vy], spin_rad_s, .. } = hand.grasped().motion
        {
            state.q[first..first + 3].copy_from_slice(&object.pose);
            state.v[first..first + 3].copy_from_slice(&[vx, vy, spin_rad_s]);
        }
        self.time_index.into_iter().for_each(|time_index| state.v[time_index] = 1.0);
        state
    }

    /// Index of a contact's bristle state among the rates, if it has a bristle.
    pub fn bristle_index(&self, contact: usize) -> Option<usize> {
        self.contacts[contact].and_then(|contact| contact.bristle_index)
    }

    /// Index of the bristle state of a drive's brake: drives of the fingers, then the drive of the differential.
    pub fn brake_bristle_index(&self, drive: usize) -> Option<usize> {
        self.brake_bristles[drive]
    }

    /// Whether the friction of a contact has a bristle, so that it can stick.
    pub(crate) fn has_stiction(&self, contact: usize) -> bool {
        self.bristle_index(contact).is_some()
    }

    /// Energy stored in the bristles, J.
    pub(super) fn bristle_energy(&self, v: &[f64; N]) -> f64 {
        self.bristles.iter().map(|(bristle_index, bristle)| bristle.energy(v[*bristle_index])).sum()
    }

    /// Rates of the driven links of both fingers.
    #[inline(always)]
    pub(super) fn driven_rates(&self, v: &[f64; N]) -> [f64; FINGERS] {
        array_from(|finger| v[2 * finger])
    }

    /// Torque of an actuator of the mechanism with its brake, N·m.
    pub(crate) fn effort(&self, t: f64, v: &[f64; N], actuator: usize) -> f64 {
        let (index, driven_rates) = (self.actuators[actuator], self.driven_rates(v));
        let drive = &self.drives[index];
        let brake = drive.brake_torque(t, driven_rates, self.brake_bristle(index).map(|index| v[index]));
        drive.motor_torque(t, driven_rates).torque + brake.map_or(0.0, |(shaft, _)| shaft.torque)
    }

    /// Replaces the torque of an actuator of the mechanism over time.
    pub fn set_actuation(&mut self, actuator: usize, actuation: Profile) {
        self.drives[self.actuators[actuator]].set_actuation(actuation);
    }

    /// Next time at which a torque, or a derivative of the palm's pose, is discontinuous.
    pub(super) fn next_time_discontinuity(&self, t: f64) -> f64 {
        let drives = self.drives.iter().map(|drive| drive.next_discontinuity(t));
        let palm = self.palm_motion.iter().map(|motion| motion.next_discontinuity(t));
        drives.chain(palm).fold(f64::INFINITY, f64::min)
    }

    /// Whether the gripper has no bristles. All indices are compile-time constants then, which reduces the
    /// instructions of a closing motion to a tenth.
    pub(super) const GRASP: bool = N <= GRASP_POSITIONS;

    /// Number of coordinates before the bristle states: four angles, the pose of the object and time; the last ones may
    /// be unused.
    pub(super) const POSITIONS: usize = if Self::GRASP { N } else { GRASP_POSITIONS };

    /// Index of the bristle state of a drive's brake.
    #[inline(always)]
    pub(super) fn brake_bristle(&self, drive: usize) -> Option<usize> {
        if Self::GRASP { None } else { self.brake_bristles[drive] }
    }

    /// First coordinate of the object; beyond the last coordinate if the object is fixed.
    #[inline(always)]
    pub(super) fn object_coordinate(&self) -> usize {
        if Self::GRASP { 2 * FINGERS } else { self.object_coordinate }
    }

    /// The object with its first coordinate, if it moves.
    #[inline(always)]
    pub(super) fn moving_object(&self) -> Option<(usize, &ObjectComponent)> {
        let first = self.object_coordinate();
        if first < N { Some((first, self.object.as_ref()?)) } else { None }
    }

    /// Whether the palm, and with it the frame, moves.
    #[inline(always)]
    pub(super) fn palm_moves(&self) -> bool {
        if Self::GRASP { N > 2 * FINGERS + 3 } else { self.time_index.is_some() }
    }

    #[inline(always)]
    pub(super) fn bristle_state(&self, contact: &ContactModel, v: &[f64; N]) -> Option<f64> {
        if Self::GRASP { None } else { contact.bristle_index.map(|bristle_index| v[bristle_index]) }
    }

    /// Returns the pair of surfaces of a finger's contact.
    #[inline(always)]
    pub(super) fn contact_pair(&self, finger: usize, index: usize, contact: &ContactModel) -> ContactPair {
        match index.wrapping_sub(FingerContact::ALL.len() * finger) {
            0 => ContactPair::Phalanx { finger, phalanx: FingerContact::Proximal },
            1 => ContactPair::Phalanx { finger, phalanx: FingerContact::Distal },
            2 => ContactPair::Stop { finger },
            _ => contact.pair,
        }
    }

    /// Pose (x, y, θ) of the object.
    #[inline(always)]
    pub(crate) fn object_pose(&self, q: &[f64; N]) -> [f64; 3] {
        let first = self.object_coordinate();
        if first < N {
            [q[first], q[first + 1], q[first + 2]]
        } else {
            self.object.as_ref().map_or([0.0; 3], |object| object.pose)
        }
    }

    /// Rates of the object's pose.
    #[inline(always)]
    pub(crate) fn object_rates(&self, v: &[f64; N]) -> [f64; 3] {
        let first = self.object_coordinate();
        if first < N { [v[first], v[first + 1], v[first + 2]] } else { [0.0; 3] }
    }

    /// Returns the object's shape at its pose.
    ///
    /// # Panics
    /// Panics if there is no object.
    #[inline(always)]
    pub(super) fn placed_object(&self, q: &[f64; N]) -> PlacedShape {
        let [x, y, angle_rad] = self.object_pose(q);
        let shape = self.object.as_ref().expect("a contact of the object").shape;
        PlacedShape { shape, centre_m: [x, y], angle_rad }
    }

    /// Returns the object's shape at its pose in a finger's frame.
    #[inline(always)]
    pub(super) fn object_in_finger_frame(&self, side: Side, q: &[f64; N]) -> PlacedShape {
        self.placed_object(q).in_finger_frame(side.mirror(), self.half_palm_width)
    }

    /// Half the distance between the ground joints, m.
    pub(super) fn half_palm_width(&self) -> f64 {
        self.half_palm_width
    }

    /// Transforms a point of a finger's frame to the palm's frame.
    pub(super) fn point_in_palm_frame(&self, side: Side, [x, y]: [f64; 2]) -> [f64; 2] {
        [side.mirror() * (x + self.half_palm_width), y]
    }

    /// Returns the two coordinates of a finger among all, or their rates.
    #[inline(always)]
    pub(super) fn finger_coordinates(finger: usize, all: &[f64; N]) -> [f64; 2] {
        [all[2 * finger], all[2 * finger + 1]]
    }
}
