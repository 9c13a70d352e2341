//! A gripper and its object in one configuration, without assuming symmetry.

use super::{FingerGrip, Hand, PhalanxContact, Side, StaticsError};
use crate::fivebar::capsule::{Capsule, ClosestPoints, closest_points};
use crate::gripper::{Finger, Posture, close_loop, joint_positions};
use crate::numeric::plane::{Vector, add, scale};
use crate::shape::PlacedShape;

/// A gripper in one posture with its object, in the frame of the palm: origin at its centre, x along the palm, y out of
/// it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraspConfiguration<'a> {
    /// Right and left finger.
    pub fingers: [&'a Finger; 2],
    /// (q11, q21) of each finger; for the left finger, of its mirror image.
    pub angles_rad: [[f64; 2]; 2],
    /// Distance between the ground joints.
    pub palm_width_m: f64,
    pub object: PlacedShape,
}

/// The point of a surface of the hand nearest to the object, in the frame of the palm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// Point on the surface of phalanx or palm.
    pub point_m: [f64; 2],
    /// Unit normal into the object.
    pub normal: [f64; 2],
    /// Gap, negative in penetration.
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
    /// Maps the value of each contact.
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

/// A finger with both contacts active, and the gaps of its proximal and distal phalanx.
type GripWithGaps<'a> = (FingerGrip<'a>, [f64; 2]);

impl<'a> GraspConfiguration<'a> {
    /// Gaps between the surfaces, in m; negative in penetration. The active contacts are those within a tolerance:
    /// `gaps()?.map(|gap| gap <= tolerance)`.
    ///
    /// # Errors
    /// Returns an error if a loop does not close in this posture.
    pub fn gaps(&self) -> Result<PerContact<f64>, StaticsError> {
        let [(_, right), (_, left)] = self.grips_with_gaps()?;
        Ok(PerContact { phalanges: [right, left], palm: self.object.lowest_point_m()[1] })
    }

    /// Points of phalanges and palm nearest to the object, in contact or not.
    ///
    /// # Errors
    /// Returns an error if a loop does not close in this posture.
    pub fn contact_points(&self) -> Result<PerContact<ContactPoint>, StaticsError> {
        let contact_points = |side: Side| -> Result<[ContactPoint; 2], StaticsError> {
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

    /// Returns the hand with these active contacts. Normals are those of the closest points, regardless of the gap:
    /// contacts of a simulation penetrate by some micrometres.
    ///
    /// # Errors
    /// Returns an error if a loop does not close in this posture.
    pub fn hand(&self, active_contacts: &PerContact<bool>) -> Result<Hand<'a>, StaticsError> {
        let grips = self.grips_with_gaps()?.into_iter().zip(active_contacts.phalanges).map(
            |((grip, _), [proximal, distal])| FingerGrip {
                proximal: grip.proximal.filter(|_| proximal),
                distal: grip.distal.filter(|_| distal),
                ..grip
            },
        );
        Ok(Hand { fingers: grips.collect(), palm: active_contacts.palm })
    }

    fn grips_with_gaps(&self) -> Result<[GripWithGaps<'a>; 2], StaticsError> {
        Ok([self.grip_with_gaps(Side::Right)?, self.grip_with_gaps(Side::Left)?])
    }

    fn grip_with_gaps(&self, side: Side) -> Result<GripWithGaps<'a>, StaticsError> {
        let FingerGeometry { finger, posture, a22, phalanges: [proximal, distal], .. } = self.finger_geometry(side)?;
        let grip = FingerGrip {
            finger,
            posture,
            side,
            proximal: Some(PhalanxContact::proximal(proximal.foot, proximal.normal)),
            distal: Some(PhalanxContact::distal(distal.foot, distal.normal, a22)),
            backdrivable: false,
        };
        Ok((grip, [proximal.gap, distal.gap]))
    }

    /// Geometry of a finger in its own frame: the ground joint is the origin, and the object is to its left.
    pub(super) fn finger_geometry(&self, side: Side) -> Result<FingerGeometry<'a>, StaticsError> {
        let (finger, [q11, q21]) = (self.fingers[side as usize], self.angles_rad[side as usize]);
        let posture = close_loop(&finger.lengths, finger.assembly, q11, q21)?;
        let joints = joint_positions(&finger.lengths, &posture);
        let object = self.object.in_finger_frame(side.mirror(), 0.5 * self.palm_width_m);
        let w = finger.lengths.half_width_m;
        let phalanges = [([0.0; 2], joints.a22_m), (joints.a22_m, joints.tip_m)]
            .map(|(from, to)| closest_point(from, to, w, &object));
        Ok(FingerGeometry { finger, posture, a22: joints.a22_m, object, phalanges })
    }

    /// Transforms a point from the frame of a finger to the frame of the palm.
    pub(super) fn in_palm_frame(&self, side: Side, [x, y]: Vector<f64>) -> [f64; 2] {
        [side.mirror() * (x + 0.5 * self.palm_width_m), y]
    }
}

/// Geometry of a finger and the object, in the frame of the finger.
pub(super) struct FingerGeometry<'a> {
    pub finger: &'a Finger,
    pub posture: Posture,
    pub a22: Vector<f64>,
    pub object: PlacedShape,
    /// Closest points of the proximal and the distal phalanx.
    pub phalanges: [ClosestPoint; 2],
}

/// The point on the centre line of a phalanx nearest to the object, with the normal into the object.
#[derive(Clone, Copy)]
pub(super) struct ClosestPoint {
    pub foot: Vector<f64>,
    pub normal: Vector<f64>,
    pub gap: f64,
}

fn closest_point(from: Vector<f64>, to: Vector<f64>, half_width: f64, object: &PlacedShape) -> ClosestPoint {
    let ClosestPoints { foot, normal, gap, .. } = closest_points(&Capsule::between(from, to, half_width), object);
    ClosestPoint { foot, normal: scale(normal, -1.0), gap }
}
