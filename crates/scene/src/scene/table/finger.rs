//! `[design]`, `[lengths]`, `[material]`, `[bodies]` and `[initial]` of a finger, and its settings at the top level.

use std::f64::consts::{FRAC_PI_2, PI};

use super::settings;
use crate::gripper::{Assembly, BodyOverride, Design, HEIGHT_RATIO, Lengths, ProximalLength, TIP_CONTACT_MIN_RAD};
use crate::scene::check::{Bound, POSITIVE};
use crate::scene::keywords::FINGERS;
use crate::scene::value_kinds::{Angle, AngularRate, Choice, Density, Inertia, Length, Mass, Number, Pair, Time};
use crate::scene::{Initial, defaults};
use crate::sizing::{CLOSING_S, Rule};

const PHI22: Bound = Bound { allowed: |x| x > 0.0 && x < PI, text: "between 0 and 180 deg, both excluded" };

const FRACTION: Bound = Bound { allowed: |x| (0.0..=1.0).contains(&x), text: "from 0 to 1" };
const TIP_CONTACT: Bound = Bound { allowed: |x| x.abs() < FRAC_PI_2, text: "between -90 and 90 deg, both excluded" };

const UNSET: f64 = f64::NAN;

/// Settings of a finger at the top level.
#[derive(Clone, Copy, Debug)]
pub struct FingerSettings {
    pub half_width_m: f64,
    pub assembly: Assembly,
    /// Sizing of motor and spring; `None` if their torques are given.
    pub sizing: Option<Rule>,
    /// Duration of the test trajectory; unused without sizing.
    pub closing_s: f64,
}

settings! {
    /// The links of a finger and its sizing.
    FingerSettings = Self {
        half_width_m: defaults::HALF_WIDTH_M,
        assembly: Assembly::Reference,
        sizing: None,
        closing_s: CLOSING_S,
    }, k;
    /// Half width w of every link; a phalanx is a capsule of this radius.
    "half_width": Length = Some(&mut k.half_width_m), allowed(POSITIVE);
    /// Assembly mode of the five-bar: "reference": that of the straight configuration; "other": its mirror image.
    "assembly": Choice<Assembly> = Some(&mut k.assembly);
    /// Computes the torques of motor and spring (or the stiffness of a torsional spring with a preload), which must not
    /// be given then: the spring keeps the finger straight on a test trajectory up to the object; the motor has the RMS
    /// torque of this "rigid" phase, or of the "whole" trajectory.
    "sizing": Choice<Rule> = k.sizing.as_mut(), set_with(|k, rule| k.sizing = Some(rule)), derived();
    /// Duration of the test trajectory of `sizing`.
    "closing_time": Time = Some(&mut k.closing_s), allowed(POSITIVE);
}

settings! {
    /// The finger by its design variables, adapted to the object. Alternative to [lengths].
    Design = Self {
        base_m: UNSET,
        l21: ProximalLength::Fraction(UNSET),
        phi22_rad: UNSET,
        arm_ratio: UNSET,
        l11_m: defaults::L11_M,
        half_width_m: UNSET,
        object_radius_m: UNSET,
        height_ratio: HEIGHT_RATIO,
        tip_contact_min_rad: TIP_CONTACT_MIN_RAD,
    }, d;
    /// Distance along the palm from the ground joints to the object's centre. Required.
    "base": Length = Some(&mut d.base_m), allowed(POSITIVE),
        required("add the distance to the object: base = \"15.5 mm\"");
    /// Length of the proximal phalanx l21. Alternative to l21_fraction.
    "l21": Length = match &mut d.l21 {
        ProximalLength::Length(l21_m) => Some(l21_m),
        ProximalLength::Fraction(_) => None,
    }, allowed(POSITIVE);
    /// Length of the proximal phalanx as a fraction, 0 to 1, of the range of l21 that the base allows.
    "l21_fraction": Number = match &mut d.l21 {
        ProximalLength::Fraction(fraction) => Some(fraction),
        ProximalLength::Length(_) => None,
    }, allowed(FRACTION), required("give the proximal phalanx: l21_fraction = 1.0, or a length l21 = \"24 mm\"");
    /// Angle from the arm l22 to the distal phalanx. Required.
    "phi22": Angle = Some(&mut d.phi22_rad), allowed(PHI22),
        required("add the angle of the distal phalanx: phi22 = \"120 deg\"");
    /// Ratio l22 / l11. Required.
    "arm_ratio": Number = Some(&mut d.arm_ratio), allowed(POSITIVE), required("add l22 / l11: arm_ratio = 0.5");
    /// Length of the driven link l11.
    "l11": Length = Some(&mut d.l11_m), allowed(POSITIVE);
    /// Height of the closed finger divided by the object's diameter.
    "height_ratio": Number = Some(&mut d.height_ratio), allowed(POSITIVE);
    /// Smallest contact angle of the distal phalanx; determines the shortest l21.
    "tip_contact_min": Angle = Some(&mut d.tip_contact_min_rad), allowed(TIP_CONTACT);
}

/// A finger by its lengths, with the base, which is NaN if the position of the object is given instead.
#[derive(Clone, Copy, Debug)]
pub struct LengthSettings {
    pub links: Lengths,
    pub base_m: f64,
}

settings! {
    /// The finger by its link lengths. Alternative to [design].
    LengthSettings = Self {
        links: Lengths {
            l11_m: defaults::L11_M, l12_m: UNSET, l21_m: UNSET, l22_m: UNSET, t22_m: UNSET, phi22_rad: UNSET, half_width_m: UNSET
        },
        base_m: UNSET,
    }, l;
    /// Distance along the palm from the ground joints to the object's centre: the position of the object of one finger,
    /// half the palm width of a gripper. Alternative to `object.centre` and `palm_width`.
    "base": Length = Some(&mut l.base_m), allowed(POSITIVE);
    /// Length of the driven link, between ground joint and coupler.
    "l11": Length = Some(&mut l.links.l11_m), allowed(POSITIVE);
    /// Length of the coupler. Default: such that the finger is straight with l11 along the palm and l21 perpendicular
    /// to it.
    "l12": Length = Some(&mut l.links.l12_m), allowed(POSITIVE);
    /// Length of the proximal phalanx. Required.
    "l21": Length = Some(&mut l.links.l21_m), allowed(POSITIVE), required("add the proximal phalanx: l21 = \"24 mm\"");
    /// Length of the arm of the distal body, to the coupler. Required.
    "l22": Length = Some(&mut l.links.l22_m), allowed(POSITIVE), required("add the arm of the distal body: l22 = \"7.5 mm\"");
    /// Length of the distal phalanx. Required.
    "t22": Length = Some(&mut l.links.t22_m), allowed(POSITIVE), required("add the distal phalanx: t22 = \"13 mm\"");
    /// Angle from the arm l22 to the distal phalanx. Required.
    "phi22": Angle = Some(&mut l.links.phi22_rad), allowed(PHI22),
        required("add the angle of the distal phalanx: phi22 = \"120 deg\"");
}

/// Material and depth of the links.
#[derive(Clone, Copy, Debug)]
pub struct MaterialSettings {
    pub density_kg_m3: f64,
    pub depth_m: f64,
}

settings! {
    /// Density and depth of the links, which determine masses and inertias together with the outlines.
    MaterialSettings = Self { density_kg_m3: defaults::DENSITY_KG_M3, depth_m: defaults::DEPTH_M }, m;
    "density": Density = Some(&mut m.density_kg_m3), allowed(POSITIVE);
    /// Extent of the links out of the plane.
    "depth": Length = Some(&mut m.depth_m), allowed(POSITIVE);
}

/// The section `[bodies]`, which contains one section per body.
#[derive(Clone, Copy, Debug)]
pub struct BodySettings;

impl BodySettings {
    /// Names of the bodies.
    pub const NAMES: [&str; 4] = ["l11", "l12", "l21", "l22"];
}

settings! {
    /// Mass properties of single bodies that replace those from the outlines.
    BodySettings = Self, _none, "l11" in FINGERS: BodyOverride, "l12" in FINGERS: BodyOverride,
        "l21" in FINGERS: BodyOverride, "l22" in FINGERS: BodyOverride;
}

settings! {
    /// Mass properties of one body. If only the mass is given, the inertia from the outline is scaled with it.
    BodyOverride = Self::default(), b;
    "mass": Mass = b.mass_kg.as_mut(), set_with(|b, mass_kg| b.mass_kg = Some(mass_kg)), allowed(POSITIVE);
    /// Centre of mass relative to the preceding joint: along the link, and to its left.
    "com": Pair<Length> = b.com_m.as_mut(), set_with(|b, com_m| b.com_m = Some(com_m));
    /// Moment of inertia about the centre of mass.
    "inertia": Inertia = b.inertia_kg_m2.as_mut(), set_with(|b, inertia_kg_m2| b.inertia_kg_m2 = Some(inertia_kg_m2)),
        allowed(POSITIVE);
}

/// Initial configuration; NaN for values that are not given.
#[derive(Clone, Copy, Debug)]
pub struct InitialSettings {
    /// Angle before the proximal contact; `None` if the joint angles are given.
    pub offset_rad: Option<f64>,
    pub joints: Initial,
}

settings! {
    /// Initial configuration. Default: straight, 25° before the contact of the proximal phalanx with the object, at
    /// rest.
    InitialSettings = Self {
        offset_rad: Some(defaults::OFFSET_DEG.to_radians()),
        joints: Initial { q11_rad: UNSET, q21_rad: UNSET, qd11_rad_s: 0.0, qd21_rad_s: 0.0 },
    }, s;
    /// Angle before the contact of the proximal phalanx with the object, from which the finger starts straight.
    "offset": Angle = s.offset_rad.as_mut();
    /// Angle of the driven link from the palm; requires q21. Default: that of the straight configuration.
    "q11": Angle = Some(&mut s.joints.q11_rad);
    /// Angle of the proximal phalanx from the palm.
    "q21": Angle = Some(&mut s.joints.q21_rad);
    "qd11": AngularRate = Some(&mut s.joints.qd11_rad_s), default_text("0 rad/s");
    "qd21": AngularRate = Some(&mut s.joints.qd21_rad_s), default_text("0 rad/s");
}
