//! The sections of a finger.

use std::f64::consts::{FRAC_PI_2, PI};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{ContactSettings, FINGERS, LimitSettings, MotorSettings, SpringSettings};
use crate::gripper::{Assembly, Body, BodyOverride, Lengths};
use crate::scene::Initial;
use crate::scene::quantity::{
    Angle, AngularRate, Density, Inertia, Length, Mass, Plain, Positive, Quantity, Time, Word,
};
use crate::sizing::Rule;

/// Keys and sections of a finger; in a gripper they apply to both fingers, or to one within `[right]` and `[left]`.
#[derive(Clone, Debug, Default, Serialize, JsonSchema)]
pub struct FingerSettings {
    /// Half width w of every link; a phalanx is a capsule of this radius.
    #[schemars(extend("default" = "2.5 mm", "x-kinds" = FINGERS))]
    pub half_width: Option<Positive<Length>>,
    /// Assembly mode of the five-bar: "reference": that of the straight configuration; "other": its mirror image.
    #[schemars(extend("default" = "reference", "x-kinds" = FINGERS))]
    pub assembly: Option<Word<Assembly>>,
    /// Computes the torques of motor and spring (or the stiffness of a torsional spring with a preload), which must not
    /// be given then: the spring keeps the finger straight on a test trajectory up to the object; the motor has the RMS
    /// torque of this "rigid" phase, or of the "whole" trajectory.
    #[schemars(extend("x-kinds" = FINGERS))]
    pub sizing: Option<Word<Rule>>,
    /// Duration of the test trajectory of `sizing`.
    #[schemars(extend("default" = "10 ms", "x-kinds" = FINGERS))]
    pub closing_time: Option<Positive<Time>>,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub design: Option<DesignSettings>,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub lengths: Option<LengthSettings>,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub material: Option<MaterialSettings>,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub bodies: Option<BodiesSettings>,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub motor: Option<MotorSettings>,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub spring: Option<SpringSettings>,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub limit: Option<LimitSettings>,
    pub contact: Option<ContactSettings>,
    #[schemars(extend("x-kinds" = FINGERS))]
    pub initial: Option<InitialSettings>,
}

/// The finger by its design variables, adapted to the object. Alternative to [lengths].
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct DesignSettings {
    /// Distance along the palm from the ground joints to the object's centre. Required.
    #[schemars(extend("x-required" = "add the distance to the object: base = \"15.5 mm\""))]
    pub base: Option<Positive<Length>>,
    /// Length of the proximal phalanx l21. Alternative to l21_fraction.
    pub l21: Option<Positive<Length>>,
    /// Length of the proximal phalanx as a fraction, 0 to 1, of the range of l21 that the base allows.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0, "x-alternative" = "l21",
        "x-required" = "give the proximal phalanx: l21_fraction = 1.0, or a length l21 = \"24 mm\""))]
    pub l21_fraction: Option<Quantity<Plain>>,
    /// Angle from the arm l22 to the distal phalanx. Required.
    #[schemars(extend("x-exclusiveMinimum" = 0.0, "x-exclusiveMaximum" = PI,
        "x-required" = "add the angle of the distal phalanx: phi22 = \"120 deg\""))]
    pub phi22: Option<Quantity<Angle>>,
    /// Ratio l22 / l11. Required.
    #[schemars(extend("x-required" = "add l22 / l11: arm_ratio = 0.5"))]
    pub arm_ratio: Option<Positive<Plain>>,
    /// Length of the driven link l11.
    #[schemars(extend("default" = "15 mm"))]
    pub l11: Positive<Length>,
    /// Height of the closed finger divided by the object's diameter.
    #[schemars(extend("default" = crate::gripper::HEIGHT_RATIO))]
    pub height_ratio: Positive<Plain>,
    /// Smallest contact angle of the distal phalanx; determines the shortest l21.
    #[schemars(extend("default" = "5 deg", "x-exclusiveMinimum" = -FRAC_PI_2, "x-exclusiveMaximum" = FRAC_PI_2))]
    pub tip_contact_min: Quantity<Angle>,
}

/// The finger by its link lengths. Alternative to [design].
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct LengthSettings {
    /// Distance along the palm from the ground joints to the object's centre: the position of the object of one finger,
    /// half the palm width of a gripper. Alternative to `object.centre` and `palm_width`.
    pub base: Option<Positive<Length>>,
    /// Length of the driven link, between ground joint and coupler.
    #[schemars(extend("default" = "15 mm"))]
    pub l11: Positive<Length>,
    /// Length of the coupler. Default: such that the finger is straight with l11 along the palm and l21 perpendicular
    /// to it.
    pub l12: Option<Positive<Length>>,
    /// Length of the proximal phalanx. Required.
    #[schemars(extend("x-required" = "add the proximal phalanx: l21 = \"24 mm\""))]
    pub l21: Option<Positive<Length>>,
    /// Length of the arm of the distal body, to the coupler. Required.
    #[schemars(extend("x-required" = "add the arm of the distal body: l22 = \"7.5 mm\""))]
    pub l22: Option<Positive<Length>>,
    /// Length of the distal phalanx. Required.
    #[schemars(extend("x-required" = "add the distal phalanx: t22 = \"13 mm\""))]
    pub t22: Option<Positive<Length>>,
    /// Angle from the arm l22 to the distal phalanx. Required.
    #[schemars(extend("x-exclusiveMinimum" = 0.0, "x-exclusiveMaximum" = PI,
        "x-required" = "add the angle of the distal phalanx: phi22 = \"120 deg\""))]
    pub phi22: Option<Quantity<Angle>>,
}

impl From<&Lengths> for LengthSettings {
    fn from(lengths: &Lengths) -> Self {
        let Lengths { l11_m, l12_m, l21_m, l22_m, t22_m, phi22_rad, .. } = *lengths;
        let [l12, l21, l22, t22] = [l12_m, l21_m, l22_m, t22_m].map(|length_m| Some(length_m.into()));
        LengthSettings { base: None, l11: l11_m.into(), l12, l21, l22, t22, phi22: Some(phi22_rad.into()) }
    }
}

/// Density and depth of the links, which determine masses and inertias together with the outlines.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct MaterialSettings {
    #[schemars(extend("default" = "1070 kg/m^3"))]
    pub density: Positive<Density>,
    /// Extent of the links out of the plane.
    #[schemars(extend("default" = "40 mm"))]
    pub depth: Positive<Length>,
}

/// Mass properties of single bodies that replace those from the outlines.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct BodiesSettings {
    pub l11: BodySettings,
    pub l12: BodySettings,
    pub l21: BodySettings,
    pub l22: BodySettings,
}

/// Mass properties of one body. If only the mass is given, the inertia from the outline is scaled with it.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct BodySettings {
    pub mass: Option<Positive<Mass>>,
    /// Centre of mass relative to the preceding joint: along the link, and to its left.
    pub com: Option<[Quantity<Length>; 2]>,
    /// Moment of inertia about the centre of mass.
    pub inertia: Option<Positive<Inertia>>,
}

impl From<BodySettings> for BodyOverride {
    fn from(body: BodySettings) -> Self {
        BodyOverride {
            mass_kg: body.mass.map(|mass| *mass),
            com_m: body.com.map(|com| com.map(|coordinate| *coordinate)),
            inertia_kg_m2: body.inertia.map(|inertia| *inertia),
        }
    }
}

impl From<&Body> for BodySettings {
    fn from(body: &Body) -> Self {
        BodySettings {
            mass: Some(body.mass_kg.into()),
            com: Some(body.com_m.map(Quantity::from)),
            inertia: Some(body.inertia_kg_m2.into()),
        }
    }
}

/// Initial configuration. Default: straight, 25° before the contact of the proximal phalanx with the object, at
/// rest.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct InitialSettings {
    /// Angle before the contact of the proximal phalanx with the object, from which the finger starts straight.
    #[schemars(extend("default" = "25 deg"))]
    pub offset: Option<Quantity<Angle>>,
    /// Angle of the driven link from the palm; requires q21. Default: that of the straight configuration.
    pub q11: Option<Quantity<Angle>>,
    /// Angle of the proximal phalanx from the palm.
    pub q21: Option<Quantity<Angle>>,
    #[schemars(extend("default" = "0 rad/s"))]
    pub qd11: Quantity<AngularRate>,
    #[schemars(extend("default" = "0 rad/s"))]
    pub qd21: Quantity<AngularRate>,
}

impl From<Initial> for InitialSettings {
    fn from(initial: Initial) -> Self {
        InitialSettings {
            offset: None,
            q11: Some(initial.q11_rad.into()),
            q21: Some(initial.q21_rad.into()),
            qd11: initial.qd11_rad_s.into(),
            qd21: initial.qd21_rad_s.into(),
        }
    }
}
