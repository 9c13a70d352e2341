//! The hand that a posture of a gripper makes: both fingers where they are, the object where it is, no symmetry assumed.

use super::{Grip, Hand, Side, StaticsError, Touch};
use crate::fivebar::capsule::{Capsule, Nearest, nearest};
use crate::gripper::{Finger, Posture, close, joints};
use crate::numeric::plane::{Vector, add, scale};
use crate::shape::Placed;

/// A gripper in one posture. The frame is the palm's: origin in its middle, x along it, y out of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stance<'a> {
    /// Right and left.
    pub fingers: [&'a Finger; 2],
    /// (q11, q21) of each, of the left one those of its mirror image.
    pub angles_rad: [[f64; 2]; 2],
    /// Distance between the ground joints.
    pub palm_width_m: f64,
    pub object: Placed,
}

/// Where a surface of the hand is nearest to the object, in the palm's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetAt {
    /// On the surface of phalanx or palm.
    pub point_m: [f64; 2],
    /// Into the object.
    pub normal: [f64; 2],
    /// Negative in penetration.
    pub gap_m: f64,
}

/// Something of every contact that a hand can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PerContact<T> {
    /// Right and left; of each, proximal and distal.
    pub phalanges: [[T; 2]; 2],
    pub palm: T,
}

impl<T> PerContact<T> {
    pub fn map<S>(self, f: impl Fn(T) -> S) -> PerContact<S> {
        PerContact { phalanges: self.phalanges.map(|finger| finger.map(&f)), palm: f(self.palm) }
    }
}

impl<T: Copy> PerContact<T> {
    /// Of this and of something else of the same contacts.
    pub fn with<S: Copy, R>(self, other: PerContact<S>, f: impl Fn(T, S) -> R) -> PerContact<R> {
        let phalanx = |side: usize, site: usize| f(self.phalanges[side][site], other.phalanges[side][site]);
        PerContact {
            phalanges: [0, 1].map(|side| [0, 1].map(|site| phalanx(side, site))),
            palm: f(self.palm, other.palm),
        }
    }
}

/// A finger near the object: its grip if all of it touches, and the gaps of its phalanges, proximal and distal.
type Near<'a> = (Grip<'a>, [f64; 2]);

impl<'a> Stance<'a> {
    /// Distances between the surfaces, in m; negative in penetration. Those within a tolerance are the contacts:
    /// `gaps()?.map(|gap| gap <= tolerance)`.
    ///
    /// # Errors
    /// A posture in which a loop does not close.
    pub fn gaps(&self) -> Result<PerContact<f64>, StaticsError> {
        let [(_, right), (_, left)] = self.near()?;
        Ok(PerContact { phalanges: [right, left], palm: self.object.lowest_m()[1] })
    }

    /// Where phalanges and palm are nearest to the object, touching or not.
    ///
    /// # Errors
    /// A posture in which a loop does not close.
    pub fn met(&self) -> Result<PerContact<MetAt>, StaticsError> {
        let of = |side: Side| -> Result<[MetAt; 2], StaticsError> {
            let Reach { finger, phalanges, .. } = self.reach(side)?;
            Ok(phalanges.map(|Meeting { foot, normal: [nx, ny], gap }| MetAt {
                point_m: self.in_palm(side, add(foot, scale([nx, ny], finger.lengths.half_width_m))),
                normal: [side.mirror() * nx, ny],
                gap_m: gap,
            }))
        };
        let [x, gap_m] = self.object.lowest_m();
        let palm = MetAt { point_m: [x, 0.0], normal: [0.0, 1.0], gap_m };
        Ok(PerContact { phalanges: [of(Side::Right)?, of(Side::Left)?], palm })
    }

    /// The hand whose contacts are these. A phalanx that is said to touch does so with the normal that it has, at whatever gap: contacts
    /// of a simulation are some micrometres deep.
    ///
    /// # Errors
    /// A posture in which a loop does not close.
    pub fn hand(&self, touching: &PerContact<bool>) -> Result<Hand<'a>, StaticsError> {
        let grips = self.near()?.into_iter().zip(touching.phalanges).map(|((grip, _), [proximal, distal])| Grip {
            proximal: grip.proximal.filter(|_| proximal),
            distal: grip.distal.filter(|_| distal),
            ..grip
        });
        Ok(Hand { fingers: grips.collect(), palm: touching.palm })
    }

    fn near(&self) -> Result<[Near<'a>; 2], StaticsError> {
        Ok([self.finger(Side::Right)?, self.finger(Side::Left)?])
    }

    fn finger(&self, side: Side) -> Result<Near<'a>, StaticsError> {
        let Reach { finger, posture, a22, phalanges: [proximal, distal], .. } = self.reach(side)?;
        let grip = Grip {
            finger,
            posture,
            side,
            proximal: Some(Touch::proximal(proximal.foot, proximal.normal)),
            distal: Some(Touch::distal(distal.foot, distal.normal, a22)),
            backdrivable: false,
        };
        Ok((grip, [proximal.gap, distal.gap]))
    }

    /// A finger by the object, in its own frame: its ground joint is the origin, and the object is to its left.
    pub(super) fn reach(&self, side: Side) -> Result<Reach<'a>, StaticsError> {
        let (finger, [q11, q21]) = (self.fingers[side as usize], self.angles_rad[side as usize]);
        let posture = close(&finger.lengths, finger.assembly, q11, q21)?;
        let at = joints(&finger.lengths, &posture);
        let object = self.object.in_finger(side.mirror(), 0.5 * self.palm_width_m);
        let w = finger.lengths.half_width_m;
        let phalanges = [([0.0; 2], at.a22_m), (at.a22_m, at.tip_m)].map(|(from, to)| meet(from, to, w, &object));
        Ok(Reach { finger, posture, a22: at.a22_m, object, phalanges })
    }

    /// A point of a finger's frame as that of the palm has it.
    pub(super) fn in_palm(&self, side: Side, [x, y]: Vector<f64>) -> [f64; 2] {
        [side.mirror() * (x + 0.5 * self.palm_width_m), y]
    }
}

/// A finger by the object, in the finger's frame.
pub(super) struct Reach<'a> {
    pub finger: &'a Finger,
    pub posture: Posture,
    pub a22: Vector<f64>,
    pub object: Placed,
    /// Proximal and distal.
    pub phalanges: [Meeting; 2],
}

/// Where a phalanx is nearest to the object: on its centre line, with the normal into the object.
#[derive(Clone, Copy)]
pub(super) struct Meeting {
    pub foot: Vector<f64>,
    pub normal: Vector<f64>,
    pub gap: f64,
}

fn meet(from: Vector<f64>, to: Vector<f64>, half_width: f64, object: &Placed) -> Meeting {
    let Nearest { foot, normal, gap, .. } = nearest(&Capsule::between(from, to, half_width), object);
    Meeting { foot, normal: scale(normal, -1.0), gap }
}
