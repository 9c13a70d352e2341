//! The finger as plain data: link lengths, mass properties, assembly mode.
//!
//! Notation of the thesis (Fig. 2.2): ground links `l11` (driven) and `l21` (proximal phalanx) turn about the origin,
//! `l12` is the coupler, `l22` the arm of the distal body and `t22` its phalanx, at `+φ22` from the arm.
//!
//! | file | job |
//! |---|---|
//! | `design` | the few free numbers of a design → link lengths (thesis B.2.2) |
//! | `posture` | loop closure and assembly mode (thesis (2.1)) |
//! | `grasp` | postures against an object: contact, start, final |
//! | `outline` | polygon outline of each body, and polygon moments |
//! | `mass` | mass, centre of mass and inertia of each body |
//! | `site`, `spring` | where a finger can meet something, what pulls it straight |

mod design;
mod grasp;
mod mass;
mod mass_error;
mod outline;
mod posture;
mod site;
mod spring;

pub use design::{
    Design, DesignError, HEIGHT_RATIO, ProximalLength, TIP_CONTACT_MIN_RAD, arm_length, disc, lengths, proximal_range,
};
pub use grasp::{
    FinalPosture, GraspError, ProximalContact, contact_angle_proximal, contact_proximal, final_posture, start_posture,
};
pub use mass::{BodyOverride, bodies, bodies_with, total_mass};
pub use mass_error::MassError;
pub use outline::{Outlines, PolygonMoments, link_outline, outlines, polygon_moments, tip_outline};
pub use posture::{Joints, Posture, PostureError, close, gamma, joint_a13, joints, posture_at, straight};
pub use site::Site;
pub use spring::{Placement, Spring, SpringKind};

/// Link lengths of one finger, in metres and radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lengths {
    /// Driven link, joint O to joint A12.
    pub l11_m: f64,
    /// Coupler, joint A12 to joint A13.
    pub l12_m: f64,
    /// Proximal phalanx, joint O to joint A22.
    pub l21_m: f64,
    /// Arm of the distal body, joint A22 to joint A13.
    pub l22_m: f64,
    /// Distal phalanx, joint A22 to its end, the tip.
    pub t22_m: f64,
    /// Angle from the arm l22 to the distal phalanx t22, counter-clockwise.
    pub phi22_rad: f64,
    /// Half width w of every link; each phalanx is a capsule of this radius.
    pub half_width_m: f64,
}

/// Mass properties of one rigid body in its own frame: origin at the preceding joint, x along the link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    pub mass_kg: f64,
    /// Centre of mass (a, b): along the link, and to its left.
    pub com_m: [f64; 2],
    /// Moment of inertia about the centre of mass.
    pub inertia_kg_m2: f64,
}

/// The four moving bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bodies {
    pub l11: Body,
    pub l12: Body,
    pub l21: Body,
    pub l22: Body,
}

/// Which of the two ways the loop is put together (γ of thesis (2.1)).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Assembly {
    /// The mode that contains the straight reference configuration.
    Reference,
    /// The mirror image of A13 about the line A12–A22.
    Other,
}

/// One finger: everything about it that does not move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finger {
    pub lengths: Lengths,
    pub bodies: Bodies,
    pub assembly: Assembly,
}
