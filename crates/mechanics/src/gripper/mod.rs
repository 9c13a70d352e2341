//! The finger as plain data: link lengths, mass properties, assembly mode.
//!
//! Notation of the thesis (Fig. 2.2): ground links `l11` (driven) and `l21` (proximal phalanx) turn about the origin,
//! `l12` is the coupler, `l22` the arm of the distal body and `t22` its phalanx, at an angle of `+φ22` from the arm.
//!
//! | file | job |
//! |---|---|
//! | `design` | link lengths from the free parameters of a design (thesis B.2.2) |
//! | `posture` | loop closure and assembly mode (thesis (2.1)) |
//! | `grasp` | postures at an object: contact, start, final |
//! | `outline` | polygon outline of each body, and polygon moments |
//! | `mass` | mass, centre of mass and inertia of each body |
//! | `finger_contact`, `spring` | the contacts of a finger, and its return spring |

mod design;
mod finger_contact;
mod grasp;
mod mass;
mod mass_error;
mod outline;
mod posture;
mod spring;

pub use design::{
    Design, DesignError, HEIGHT_RATIO, ProximalLength, TIP_CONTACT_MIN_RAD, arm_length, disc, lengths, proximal_range,
};
pub use finger_contact::FingerContact;
pub use grasp::{
    FinalPosture, GraspError, ProximalContact, contact_angle_proximal, contact_proximal, final_posture, start_posture,
};
pub use mass::{BodyOverride, bodies, bodies_with_overrides, total_mass};
pub use mass_error::MassError;
pub use outline::{Outlines, PolygonMoments, link_outline, outlines, polygon_moments, tip_outline};
pub use posture::{
    Joints, Posture, PostureError, close_loop, gamma, joint_a13, joint_positions, posture_at, straight_posture,
};
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
    /// Centre of mass (a, b): along the link and to its left.
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

/// Assembly mode of the loop (γ of thesis (2.1)).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Assembly {
    /// The mode that contains the straight reference configuration.
    Reference,
    /// The mirror image of A13 about the line A12–A22.
    Other,
}

/// The constant data of one finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finger {
    pub lengths: Lengths,
    pub bodies: Bodies,
    pub assembly: Assembly,
}
