//! `[lengths]`, `[material]` and `[initial]` of a finger.

use std::f64::consts::PI;

use super::lines;
use crate::gripper::Lengths;
use crate::scene::check::{Bound, POSITIVE};
use crate::scene::kinds::{Angle, AngularRate, Density, Length};
use crate::scene::{Initial, defaults};

pub const PHI22: Bound = Bound { allowed: |x| x > 0.0 && x < PI, text: "between 0 and 180 deg, both excluded" };

const GIVEN: f64 = f64::NAN;

lines! {
    /// The finger by its link lengths. Either this or [design].
    Lengths = Self {
        l11_m: defaults::L11_M, l12_m: GIVEN, l21_m: GIVEN, l22_m: GIVEN, t22_m: GIVEN, phi22_rad: GIVEN, half_width_m: GIVEN
    }, l;
    /// Driven link, between ground joint and coupler.
    "l11": Length = Some(&mut l.l11_m), allowed(POSITIVE);
    /// Coupler. Default: such that the finger is straight with l11 on the palm and l21 upright.
    "l12": Length = Some(&mut l.l12_m), allowed(POSITIVE);
    /// Proximal phalanx. Required.
    "l21": Length = Some(&mut l.l21_m), allowed(POSITIVE), needed("add the proximal phalanx: l21 = \"24 mm\"");
    /// Arm of the distal body, to the coupler. Required.
    "l22": Length = Some(&mut l.l22_m), allowed(POSITIVE), needed("add the arm of the distal body: l22 = \"7.5 mm\"");
    /// Distal phalanx. Required.
    "t22": Length = Some(&mut l.t22_m), allowed(POSITIVE), needed("add the distal phalanx: t22 = \"13 mm\"");
    /// Angle from the arm l22 to the distal phalanx. Required.
    "phi22": Angle = Some(&mut l.phi22_rad), allowed(PHI22),
        needed("add the angle of the distal phalanx: phi22 = \"120 deg\"");
}

/// What the links are made of.
#[derive(Clone, Copy, Debug)]
pub struct Material {
    pub density_kg_m3: f64,
    pub depth_m: f64,
}

lines! {
    /// Material and depth of the links: with their outlines, these give masses and inertias.
    Material = Self { density_kg_m3: defaults::DENSITY_KG_M3, depth_m: defaults::DEPTH_M }, m;
    "density": Density = Some(&mut m.density_kg_m3), allowed(POSITIVE);
    /// Extent of the links out of the plane.
    "depth": Length = Some(&mut m.depth_m), allowed(POSITIVE);
}

/// A start; not a number what is not given.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// How far before the contact; `None` where the angles say it.
    pub offset_rad: Option<f64>,
    pub joints: Initial,
}

lines! {
    /// Start of the simulation. Default: straight, 25° before the proximal phalanx touches the object, at rest.
    Start = Self {
        offset_rad: Some(defaults::OFFSET_DEG.to_radians()),
        joints: Initial { q11_rad: GIVEN, q21_rad: GIVEN, qd11_rad_s: 0.0, qd21_rad_s: 0.0 },
    }, s;
    /// Start straight, this far before the proximal phalanx touches the object.
    "offset": Angle = s.offset_rad.as_mut();
    /// Angle of the driven link from the palm; needs q21. Default: that of the straight configuration.
    "q11": Angle = Some(&mut s.joints.q11_rad);
    /// Angle of the proximal phalanx from the palm.
    "q21": Angle = Some(&mut s.joints.q21_rad);
    "qd11": AngularRate = Some(&mut s.joints.qd11_rad_s), said("0 rad/s");
    "qd21": AngularRate = Some(&mut s.joints.qd21_rad_s), said("0 rad/s");
}
