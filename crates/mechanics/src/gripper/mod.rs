//! The finger as plain data: link lengths, mass properties, assembly mode.
//!
//! Notation of the thesis (Fig. 2.2): ground links `l11` (driven) and `l21` (proximal phalanx) turn about the origin,
//! `l12` is the coupler, `l22` the arm of the distal body and `t22` its phalanx, at an angle of `+φ22` from the arm.

mod design;
mod mass;
mod posture;

pub use design::{Design, DesignError, HEIGHT_RATIO, ProximalLength, disc, lengths, proximal_range};
pub use mass::{
    BodyOverride, MassError, Outlines, PolygonMoments, bodies, bodies_with_overrides, link_outline, outlines,
    polygon_moments, tip_outline, total_mass,
};
pub use posture::{
    FinalPosture, GraspError, Joints, Posture, PostureError, close_loop, contact_angle_proximal, contact_proximal,
    final_posture, gamma, joint_a13, joint_positions, posture_at, start_posture, straight_posture,
};

/// Error for a number out of its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{name} is {value}, but {allowed}: give another value")]
pub struct NumberError {
    name: &'static str,
    value: f64,
    allowed: &'static str,
}

/// Checks that a number is finite and in its range, which `allowed` describes.
pub(crate) fn number(name: &'static str, value: f64, in_range: bool, allowed: &'static str) -> Result<(), NumberError> {
    if value.is_finite() && in_range { Ok(()) } else { Err(NumberError { name, value, allowed }) }
}

/// Checks that numbers are positive.
pub(crate) fn positive(numbers: &[(&'static str, f64)]) -> Result<(), NumberError> {
    numbers.iter().try_for_each(|(name, value)| number(name, *value, *value > 0.0, "must be a finite number above 0"))
}

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
    /// Centre of mass (a, b): a along the link, b to its left.
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

/// A unilateral contact of a finger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FingerContact {
    /// Proximal phalanx l21 against the object.
    Proximal,
    /// Distal phalanx t22 against the object.
    Distal,
    /// Joint limit q22 ≥ −φ22.
    Limit,
}

impl FingerContact {
    pub const ALL: [FingerContact; 3] = [FingerContact::Proximal, FingerContact::Distal, FingerContact::Limit];

    /// Name in JSON keys and log topics.
    pub fn name(self) -> &'static str {
        match self {
            FingerContact::Proximal => "proximal",
            FingerContact::Distal => "distal",
            FingerContact::Limit => "limit",
        }
    }
}

/// The spring that returns the finger to the straight configuration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    pub kind: SpringKind,
    pub placement: Placement,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpringKind {
    /// Constant torque k_s.
    Constant { torque_n_m: f64 },
    /// Torque c_s (q_p + Δq_s), with stiffness c_s, preload angle q_p, and Δq_s relative to the straight configuration.
    Torsional { stiffness_n_m_per_rad: f64, preload_rad: f64 },
}

/// Links between which the spring acts; each variant names the spring angle q_s (thesis §3.3.2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// q_s = q21 − q11.
    GroundLinks,
    /// q_s = q12.
    DrivenCoupler,
    /// q_s = q22 (default).
    Phalanges,
    /// q_s = q11 + q12 − (q21 + q22).
    CouplerDistal,
}

impl Placement {
    /// All placements in the order of the thesis, §3.3.2.3.
    pub const ALL: [Placement; 4] =
        [Placement::GroundLinks, Placement::DrivenCoupler, Placement::Phalanges, Placement::CouplerDistal];

    /// Name of the coordinate in scenes and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Placement::GroundLinks => "q21-q11",
            Placement::DrivenCoupler => "q12",
            Placement::Phalanges => "q22",
            Placement::CouplerDistal => "q11+q12-(q21+q22)",
        }
    }
}
