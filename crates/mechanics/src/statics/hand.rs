//! The hand: fingers in any posture with their active contacts, and the palm; and a gripper and its object in one
//! configuration, without assuming symmetry.

use super::equilibrium::static_kinematics_at;
use super::{Result, StaticKinematics};
use crate::fivebar::kinematics::{Capsule, ClosestPoints, closest_points};
use crate::gripper::{FinalPosture, Finger, FingerContact, Posture, close_loop, joint_positions};
use crate::numeric::elementary::{cos, sin};
use crate::numeric::plane::{Vector, add, cross, perp, scale, sub};
use crate::shape::PlacedShape;

/// Side of a finger: the modelled finger is to the right of the object, its mirror image to the left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    Right,
    Left,
}

impl Side {
    pub const BOTH: [Self; 2] = [Side::Right, Side::Left];

    /// Returns +1 if the x axis of the finger frame is the x axis of the palm, −1 if it is mirrored.
    #[inline]
    pub fn mirror(self) -> f64 {
        if self == Side::Right { 1.0 } else { -1.0 }
    }

    pub fn name(self) -> &'static str {
        if self == Side::Right { "right" } else { "left" }
    }
}

/// Contact of a phalanx with the object, in the frame of a right finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhalanxContact {
    /// Unit normal, from the phalanx into the object.
    pub normal: [f64; 2],
    /// Speed of the phalanx along the normal per rad/s of θ̇1 and θ̇2: the row of J of (1.8) without friction.
    pub levers_m: [f64; 2],
}

impl PhalanxContact {
    /// Returns the contact of the proximal phalanx, which rotates about the origin. `foot` is the point of its centre
    /// line nearest to the object. The half width is irrelevant, because all points on the normal have the same lever.
    pub fn proximal(foot: Vector<f64>, normal: Vector<f64>) -> Self {
        PhalanxContact { normal, levers_m: [cross(foot, normal), 0.0] }
    }

    /// Returns the contact of the distal phalanx, which rotates with the proximal phalanx and about A22.
    pub fn distal(foot: Vector<f64>, normal: Vector<f64>, a22: Vector<f64>) -> Self {
        PhalanxContact { normal, levers_m: [cross(foot, normal), cross(sub(foot, a22), normal)] }
    }
}

/// One finger and its contacts with the object.
#[derive(Clone, Copy, Debug)]
pub struct FingerGrip<'a> {
    pub finger: &'a Finger,
    /// Posture in the frame of a right finger; a left finger is its mirror image.
    pub posture: Posture,
    pub side: Side,
    /// Contact of the proximal phalanx, if active (S of (1.17)).
    pub proximal: Option<PhalanxContact>,
    /// Contact of the distal phalanx, if active.
    pub distal: Option<PhalanxContact>,
    /// Whether the finger can back-drive the motor; if not, θ̇_a ≥ 0.
    pub backdrivable: bool,
}

impl<'a> FingerGrip<'a> {
    /// Returns a grip in which both phalanges touch the object and the motor cannot be back-driven.
    pub fn with_both_contacts(finger: &'a Finger, end: &FinalPosture, side: Side) -> Self {
        let FinalPosture { posture, l_c21_m, l_c22_m, .. } = *end;
        let direction = |angle: f64| [cos(angle), sin(angle)];
        let along = direction(posture.q21_rad);
        let tip = direction(posture.q21_rad + posture.q22_rad + finger.lengths.phi22_rad);
        let a22 = scale(along, finger.lengths.l21_m);
        Self {
            finger,
            posture,
            side,
            proximal: Some(PhalanxContact::proximal(scale(along, l_c21_m), perp(along))),
            distal: Some(PhalanxContact::distal(add(a22, scale(tip, l_c22_m)), perp(tip), a22)),
            backdrivable: false,
        }
    }
}

/// All fingers and the palm.
#[derive(Clone, Debug)]
pub struct Hand<'a> {
    pub fingers: Vec<FingerGrip<'a>>,
    /// Whether the object is in contact with the palm.
    pub palm: bool,
}

impl<'a> Hand<'a> {
    /// Returns the gripper of the thesis: a finger, its mirror image and the palm.
    pub fn symmetric(finger: &'a Finger, end: &FinalPosture) -> Self {
        Self { fingers: Side::BOTH.map(|side| FingerGrip::with_both_contacts(finger, end, side)).to_vec(), palm: true }
    }
}

/// A gripper in one posture with its object. In the frame of the palm, the origin is at the centre of the palm, x
/// points along it, and y out of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraspConfiguration<'a> {
    /// Right and left finger.
    pub fingers: [&'a Finger; 2],
    /// (q11, q21) of each finger. For the left finger, they are the angles of its mirror image.
    pub angles_rad: [[f64; 2]; 2],
    /// Distance between the ground joints.
    pub palm_width_m: f64,
    pub object: PlacedShape,
}

/// The point of a surface of the hand nearest to the object, in the frame of the palm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// Point on the surface of the phalanx or palm.
    pub point_m: [f64; 2],
    /// Unit normal into the object.
    pub normal: [f64; 2],
    /// Gap, m; negative in penetration.
    pub gap_m: f64,
}

/// One value for each contact of a hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PerContact<T> {
    /// Right and left finger; for each, proximal and distal phalanx.
    pub phalanges: [[T; 2]; 2],
    pub palm: T,
}

impl<T> PerContact<T> {
    pub fn map<S>(self, f: impl Fn(T) -> S) -> PerContact<S> {
        PerContact { phalanges: self.phalanges.map(|finger| finger.map(&f)), palm: f(self.palm) }
    }
}

impl<T: Copy> PerContact<T> {
    /// Combines the values of two sets, contact by contact.
    pub fn zip_with<S: Copy, R>(self, other: PerContact<S>, f: impl Fn(T, S) -> R) -> PerContact<R> {
        let phalanx = |side: usize, site: usize| f(self.phalanges[side][site], other.phalanges[side][site]);
        PerContact {
            phalanges: [0, 1].map(|side| [0, 1].map(|site| phalanx(side, site))),
            palm: f(self.palm, other.palm),
        }
    }
}

impl<'a> GraspConfiguration<'a> {
    /// Returns the points of the phalanges and the palm that are nearest to the object, whether or not they touch it.
    pub fn contact_points(&self) -> Result<PerContact<ContactPoint>> {
        let contact_points = |side: Side| -> Result<[ContactPoint; 2]> {
            let FingerGeometry { finger, phalanges, .. } = self.finger_geometry(side)?;
            Ok(phalanges.map(|ClosestPoint { foot, normal: [nx, ny], gap }| ContactPoint {
                point_m: self.in_palm_frame(side, add(foot, scale([nx, ny], finger.lengths.half_width_m))),
                normal: [side.mirror() * nx, ny],
                gap_m: gap,
            }))
        };
        let [x, gap_m] = self.object.lowest_point_m();
        let palm = ContactPoint { point_m: [x, 0.0], normal: [0.0, 1.0], gap_m };
        Ok(PerContact { phalanges: [contact_points(Side::Right)?, contact_points(Side::Left)?], palm })
    }

    /// Returns the hand with these active contacts. The normals are those of the closest points, regardless of the gap:
    /// in a simulation, contacts penetrate by some micrometres.
    pub fn hand(&self, active_contacts: &PerContact<bool>) -> Result<Hand<'a>> {
        let grip = |side: Side| -> Result<FingerGrip<'a>> {
            let FingerGeometry { finger, posture, a22, phalanges: [proximal, distal], .. } =
                self.finger_geometry(side)?;
            let [is_proximal, is_distal] = active_contacts.phalanges[side as usize];
            let proximal = is_proximal.then(|| PhalanxContact::proximal(proximal.foot, proximal.normal));
            let distal = is_distal.then(|| PhalanxContact::distal(distal.foot, distal.normal, a22));
            Ok(FingerGrip { finger, posture, side, proximal, distal, backdrivable: false })
        };
        Ok(Hand { fingers: vec![grip(Side::Right)?, grip(Side::Left)?], palm: active_contacts.palm })
    }

    /// Geometry of a finger in its own frame: the ground joint is the origin, and the object is to its left. In a singular
    /// posture there are motions that no force at the driven links resists.
    fn finger_geometry(&self, side: Side) -> Result<FingerGeometry<'a>> {
        let (finger, [q11, q21]) = (self.fingers[side as usize], self.angles_rad[side as usize]);
        let posture = close_loop(&finger.lengths, finger.assembly, q11, q21)?;
        static_kinematics_at(finger, &posture)?;
        let joints = joint_positions(&finger.lengths, &posture);
        let object = self.object.in_finger_frame(side.mirror(), 0.5 * self.palm_width_m);
        let w = finger.lengths.half_width_m;
        let phalanges = [([0.0; 2], joints.a22_m), (joints.a22_m, joints.tip_m)]
            .map(|(from, to)| closest_point(from, to, w, &object));
        Ok(FingerGeometry { finger, posture, a22: joints.a22_m, phalanges })
    }

    /// Transforms a point from the frame of a finger to the frame of the palm.
    fn in_palm_frame(&self, side: Side, [x, y]: Vector<f64>) -> [f64; 2] {
        [side.mirror() * (x + 0.5 * self.palm_width_m), y]
    }
}

/// Geometry of a finger and the object, in the frame of the finger.
struct FingerGeometry<'a> {
    finger: &'a Finger,
    posture: Posture,
    a22: Vector<f64>,
    /// Closest points of the proximal and the distal phalanx.
    phalanges: [ClosestPoint; 2],
}

/// The point on the centre line of a phalanx nearest to the object, with the normal into the object.
#[derive(Clone, Copy)]
struct ClosestPoint {
    foot: Vector<f64>,
    normal: Vector<f64>,
    gap: f64,
}

fn closest_point(from: Vector<f64>, to: Vector<f64>, half_width: f64, object: &PlacedShape) -> ClosestPoint {
    let ClosestPoints { foot, normal, gap, .. } = closest_points(&Capsule::between(from, to, half_width), object);
    ClosestPoint { foot, normal: scale(normal, -1.0), gap }
}

/// One constraint; fingers are counted from 0 as in [`Hand::fingers`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Row {
    /// Separation rate of a phalanx and the object, in m/s.
    Contact { finger: usize, site: FingerContact },
    /// Separation rate of the object and the palm, in m/s.
    Palm,
    /// Rate θ̇_a of a motor that cannot be back-driven, in rad/s.
    Motor { finger: usize },
    /// Rate (θ̇_a,right + θ̇_a,left)/2 of the input of a differential that cannot be back-driven, in rad/s.
    Input,
    /// A constraint of a mechanism, by its index.
    Constraint { index: usize },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowKind {
    /// A motor: its rate is in rad/s and its multiplier is a torque. All other kinds have a speed and a force.
    Motor,
    Palm,
    Distal,
    Proximal,
    /// A constraint of a mechanism.
    Constraint,
}

impl From<Row> for RowKind {
    fn from(row: Row) -> Self {
        match row {
            Row::Motor { .. } | Row::Input => RowKind::Motor,
            Row::Palm => RowKind::Palm,
            Row::Constraint { .. } => RowKind::Constraint,
            Row::Contact { site: FingerContact::Distal, .. } => RowKind::Distal,
            Row::Contact { .. } => RowKind::Proximal,
        }
    }
}

/// One coordinate of a motion of the grasp. The rotation of a disc under central forces is not included (d = 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// Velocity of the object, in m/s.
    ObjectX,
    ObjectY,
    /// θ̇1 = q̇21 of a finger, in rad/s; counter-clockwise on the right, clockwise on the left.
    Proximal {
        finger: usize,
    },
    /// θ̇2 = q̇22 of a finger, in rad/s.
    Distal {
        finger: usize,
    },
    /// A coordinate of a mechanism, by its index.
    Coordinate {
        index: usize,
    },
}

/// U ω ≥ 0 (1.18): each row is a rate that must not be negative, each column an unknown of ω.
#[derive(Clone, Debug, PartialEq)]
pub struct Unilateral {
    pub rows: Vec<Row>,
    pub unknowns: Vec<Unknown>,
    /// U by rows, in units of [`Row`] per unit of [`Unknown`].
    pub matrix: Vec<f64>,
    /// For each unknown, the speed in m/s of one unit, so that rates of different kinds are comparable.
    pub scale: Vec<f64>,
}

/// Necessary condition (1.19) of form closure: n_c + n_u ≥ n_h + d + 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NecessaryCount {
    /// n_c: contacts with phalanges and palm.
    pub contacts: usize,
    /// n_u: motors that cannot be back-driven.
    pub motors: usize,
    /// n_h: degrees of freedom of the fingers.
    pub hand: usize,
    /// d: degrees of freedom of the object.
    pub object: usize,
}

impl NecessaryCount {
    pub fn is_met(&self) -> bool {
        self.contacts + self.motors > self.hand + self.object
    }
}

impl Unilateral {
    /// Returns an empty set of constraints on these unknowns.
    pub fn new(unknowns: Vec<Unknown>, scale: Vec<f64>) -> Self {
        Self { rows: Vec::new(), unknowns, matrix: Vec::new(), scale }
    }

    /// Appends a row; `entry` gives its entry for each unknown.
    pub fn push(&mut self, row: Row, entry: impl Fn(Unknown) -> f64) {
        self.rows.push(row);
        self.matrix.extend(self.unknowns.iter().map(|&unknown| entry(unknown)));
    }

    /// Appends a row with these entries, in the order of the unknowns.
    pub fn append(&mut self, row: Row, entries: &[f64]) {
        self.rows.push(row);
        self.matrix.extend(entries);
    }

    pub fn row(&self, index: usize) -> &[f64] {
        let width = self.unknowns.len();
        &self.matrix[index * width..(index + 1) * width]
    }

    /// Returns the numbers of contacts, motors and unknowns in (1.19).
    pub fn necessary_count(&self) -> NecessaryCount {
        let motors = self.rows.iter().filter(|&&row| RowKind::from(row) == RowKind::Motor).count();
        let object = self.unknowns.iter().filter(|u| matches!(u, Unknown::ObjectX | Unknown::ObjectY)).count();
        NecessaryCount { contacts: self.rows.len() - motors, motors, hand: self.unknowns.len() - object, object }
    }
}

/// U of a hand (1.15)–(1.18): contacts of each finger, then motors, then the palm.
///
/// * Contact: (velocity of the object − velocity of the phalanx) · n ≥ 0, n from the phalanx into the object; the speed
///   of the phalanx along n is J θ̇ with J of (1.8) without friction.
/// * Motor that cannot be back-driven: θ̇_a = θ̇1 + θ̇2/(∂q22/∂q11) ≥ 0, the actuator's row of T⁻¹ (errata 12).
/// * Palm: the object does not penetrate it.
pub fn unilateral(hand: &Hand<'_>) -> Result<Unilateral> {
    let mut unknowns = vec![Unknown::ObjectX, Unknown::ObjectY];
    let mut scale = vec![1.0, 1.0];
    for (finger, grip) in hand.fingers.iter().enumerate() {
        unknowns.extend([Unknown::Proximal { finger }, Unknown::Distal { finger }]);
        scale.extend([grip.finger.lengths.l21_m; 2]);
    }
    let mut u = Unilateral::new(unknowns, scale);
    let mut motors = Vec::with_capacity(hand.fingers.len());
    for (finger, grip) in hand.fingers.iter().enumerate() {
        let StaticKinematics { tip_slope: [alpha, _], .. } = static_kinematics_at(grip.finger, &grip.posture)?;
        // The object is to the left of the phalanges of a right finger.
        let mirror = grip.side.mirror();
        for (site, phalanx_contact) in [(FingerContact::Proximal, grip.proximal), (FingerContact::Distal, grip.distal)]
        {
            let Some(PhalanxContact { normal: [x, y], levers_m: levers }) = phalanx_contact else { continue };
            u.push(Row::Contact { finger, site }, |unknown| match unknown {
                Unknown::ObjectX => mirror * x,
                Unknown::ObjectY => y,
                Unknown::Proximal { finger: index } if index == finger => -levers[0],
                Unknown::Distal { finger: index } if index == finger => -levers[1],
                _ => 0.0,
            });
        }
        if !grip.backdrivable {
            motors.push((finger, alpha));
        }
    }
    for (finger, alpha) in motors {
        u.push(Row::Motor { finger }, |unknown| match unknown {
            Unknown::Proximal { finger: index } if index == finger => 1.0,
            Unknown::Distal { finger: index } if index == finger => 1.0 / alpha,
            _ => 0.0,
        });
    }
    if hand.palm {
        u.push(Row::Palm, |unknown| if unknown == Unknown::ObjectY { 1.0 } else { 0.0 });
    }
    Ok(u)
}

/// Parts of the drive that cannot be back-driven: one-sided constraints. A grasp that is closed under them stays closed
/// if the parts are blocked in both directions, because this only adds constraints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blocked {
    /// Each driven link is blocked separately: both motors, or both outputs of a differential. n_u = 2 in (1.19).
    Outputs,
    /// Only the input of a differential is blocked. Its rotation is the mean of the outputs, so that one finger may
    /// yield while the other follows. n_u = 1.
    Input,
}

/// U of (1.18) for a gripper in this posture, with these contacts of phalanges and palm. A table is not included,
/// because the gripper moves its object away from it. Joint limits are not included either, as in the analysis of one
/// finger.
///
/// The object is a disc, all of whose normals pass through its centre: its rotation does not appear in any row and is
/// not an unknown (d = 2). With rotation as an unknown, a disc would never be form-closed.
pub fn gripper_unilateral(
    configuration: &GraspConfiguration<'_>,
    active_contacts: &PerContact<bool>,
    blocked: Blocked,
) -> Result<Unilateral> {
    let outputs = unilateral(&configuration.hand(active_contacts)?)?;
    if blocked == Blocked::Outputs {
        return Ok(outputs);
    }
    let mut u = Unilateral::new(outputs.unknowns.clone(), outputs.scale.clone());
    let mut input = vec![0.0; outputs.unknowns.len()];
    for (index, &row) in outputs.rows.iter().enumerate() {
        if RowKind::from(row) == RowKind::Motor {
            input.iter_mut().zip(outputs.row(index)).for_each(|(sum, entry)| *sum += 0.5 * entry);
        } else {
            u.append(row, outputs.row(index));
        }
    }
    u.append(Row::Input, &input);
    Ok(u)
}
