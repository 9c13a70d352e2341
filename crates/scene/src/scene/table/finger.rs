//! `[design]`, `[lengths]`, `[material]`, `[bodies]` and `[initial]` of a finger, and what is said of it before all sections.

use std::f64::consts::{FRAC_PI_2, PI};

use super::lines;
use crate::gripper::{Assembly, BodyOverride, Design, HEIGHT_RATIO, Lengths, ProximalLength, TIP_CONTACT_MIN_RAD};
use crate::scene::check::{Bound, POSITIVE};
use crate::scene::kinds::{Angle, AngularRate, Choice, Density, Inertia, Length, Mass, Number, Pair, Time};
use crate::scene::words::FINGERS;
use crate::scene::{Initial, defaults};
use crate::sizing::{CLOSING_S, Rule};

const PHI22: Bound = Bound { allowed: |x| x > 0.0 && x < PI, text: "between 0 and 180 deg, both excluded" };

const FRACTION: Bound = Bound { allowed: |x| (0.0..=1.0).contains(&x), text: "from 0 to 1" };
const TIP_CONTACT: Bound = Bound { allowed: |x| x.abs() < FRAC_PI_2, text: "between -90 and 90 deg, both excluded" };

const GIVEN: f64 = f64::NAN;

/// What is said of a finger before all sections.
#[derive(Clone, Copy, Debug)]
pub struct Links {
    pub half_width_m: f64,
    pub assembly: Assembly,
    /// `None` where motor and spring are given.
    pub sizing: Option<Rule>,
    /// Means nothing without a sizing.
    pub closing_s: f64,
}

lines! {
    /// The links of a finger, and what it is sized for.
    Links = Self {
        half_width_m: defaults::HALF_WIDTH_M,
        assembly: Assembly::Reference,
        sizing: None,
        closing_s: CLOSING_S,
    }, k;
    /// Half width w of every link; a phalanx is a capsule of this radius.
    "half_width": Length = Some(&mut k.half_width_m), allowed(POSITIVE);
    /// Way the five-bar is put together: the mode of the straight configuration, or its mirror image.
    "assembly": Choice<Assembly> = Some(&mut k.assembly);
    /// Sizes motor and spring to the finger instead of [motor] torque and [spring] torque (or the stiffness of a torsional
    /// spring with a preload): the spring holds the finger straight on a test trajectory up to the object; the motor has the
    /// RMS torque of this "rigid" phase, or of the "whole" trajectory.
    "sizing": Choice<Rule> = k.sizing.as_mut(), put(|k, rule| k.sizing = Some(rule)), follows();
    /// Length of the test trajectory that `sizing` sizes for.
    "closing_time": Time = Some(&mut k.closing_s), allowed(POSITIVE);
}

lines! {
    /// The finger by the few free numbers of a design, made for the object. Either this or [lengths].
    Design = Self {
        base_m: GIVEN,
        l21: ProximalLength::Fraction(GIVEN),
        phi22_rad: GIVEN,
        arm_ratio: GIVEN,
        l11_m: defaults::L11_M,
        half_width_m: GIVEN,
        object_radius_m: GIVEN,
        height_ratio: HEIGHT_RATIO,
        tip_contact_min_rad: TIP_CONTACT_MIN_RAD,
    }, d;
    /// Distance along the palm from the ground joints to the object's centre. Required.
    "base": Length = Some(&mut d.base_m), allowed(POSITIVE),
        needed("add the distance to the object: base = \"15.5 mm\"");
    /// Proximal phalanx l21. Either this or l21_fraction.
    "l21": Length = match &mut d.l21 {
        ProximalLength::Length(l21_m) => Some(l21_m),
        ProximalLength::Fraction(_) => None,
    }, allowed(POSITIVE);
    /// Proximal phalanx as a fraction, 0 to 1, of the range of l21 that the base allows.
    "l21_fraction": Number = match &mut d.l21 {
        ProximalLength::Fraction(fraction) => Some(fraction),
        ProximalLength::Length(_) => None,
    }, allowed(FRACTION), needed("give the proximal phalanx: l21_fraction = 1.0, or a length l21 = \"24 mm\"");
    /// Angle from the arm l22 to the distal phalanx. Required.
    "phi22": Angle = Some(&mut d.phi22_rad), allowed(PHI22),
        needed("add the angle of the distal phalanx: phi22 = \"120 deg\"");
    /// l22 / l11. Required.
    "arm_ratio": Number = Some(&mut d.arm_ratio), allowed(POSITIVE), needed("add l22 / l11: arm_ratio = 0.5");
    /// Driven link.
    "l11": Length = Some(&mut d.l11_m), allowed(POSITIVE);
    /// Height of the closed finger over the object's diameter.
    "height_ratio": Number = Some(&mut d.height_ratio), allowed(POSITIVE);
    /// Smallest contact angle of the distal phalanx; sets the shortest l21.
    "tip_contact_min": Angle = Some(&mut d.tip_contact_min_rad), allowed(TIP_CONTACT);
}

/// A finger by its lengths, and where its object is: not a number where that is said otherwise.
#[derive(Clone, Copy, Debug)]
pub struct LengthKeys {
    pub links: Lengths,
    pub base_m: f64,
}

lines! {
    /// The finger by its link lengths. Either this or [design].
    LengthKeys = Self {
        links: Lengths {
            l11_m: defaults::L11_M, l12_m: GIVEN, l21_m: GIVEN, l22_m: GIVEN, t22_m: GIVEN, phi22_rad: GIVEN, half_width_m: GIVEN
        },
        base_m: GIVEN,
    }, l;
    /// Distance along the palm from the ground joints to the object's centre: places the object of one finger, and is half the palm's
    /// width of two. Either this, or `object.centre` and `palm_width`.
    "base": Length = Some(&mut l.base_m), allowed(POSITIVE);
    /// Driven link, between ground joint and coupler.
    "l11": Length = Some(&mut l.links.l11_m), allowed(POSITIVE);
    /// Coupler. Default: such that the finger is straight with l11 on the palm and l21 upright.
    "l12": Length = Some(&mut l.links.l12_m), allowed(POSITIVE);
    /// Proximal phalanx. Required.
    "l21": Length = Some(&mut l.links.l21_m), allowed(POSITIVE), needed("add the proximal phalanx: l21 = \"24 mm\"");
    /// Arm of the distal body, to the coupler. Required.
    "l22": Length = Some(&mut l.links.l22_m), allowed(POSITIVE), needed("add the arm of the distal body: l22 = \"7.5 mm\"");
    /// Distal phalanx. Required.
    "t22": Length = Some(&mut l.links.t22_m), allowed(POSITIVE), needed("add the distal phalanx: t22 = \"13 mm\"");
    /// Angle from the arm l22 to the distal phalanx. Required.
    "phi22": Angle = Some(&mut l.links.phi22_rad), allowed(PHI22),
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

/// Sections of bodies alone.
#[derive(Clone, Copy, Debug)]
pub struct Bodies;

impl Bodies {
    /// Bodies that may be given.
    pub const NAMES: [&str; 4] = ["l11", "l12", "l21", "l22"];
}

lines! {
    /// Mass properties that replace those from the outlines, body by body.
    Bodies = Self, _none, "l11" in FINGERS: BodyOverride, "l12" in FINGERS: BodyOverride,
        "l21" in FINGERS: BodyOverride, "l22" in FINGERS: BodyOverride;
}

lines! {
    /// One body. A mass given without inertia scales the inertia of the outline with it.
    BodyOverride = Self::default(), b;
    "mass": Mass = b.mass_kg.as_mut(), put(|b, mass_kg| b.mass_kg = Some(mass_kg)), allowed(POSITIVE);
    /// Centre of mass along the link and to its left, from the joint before it.
    "com": Pair<Length> = b.com_m.as_mut(), put(|b, com_m| b.com_m = Some(com_m));
    /// Moment of inertia about the centre of mass.
    "inertia": Inertia = b.inertia_kg_m2.as_mut(), put(|b, inertia_kg_m2| b.inertia_kg_m2 = Some(inertia_kg_m2)),
        allowed(POSITIVE);
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
