//! The scene file as it is written. Doc comments become the descriptions of the JSON Schema; defaults stand beside them.

use schemars::JsonSchema;
use serde::Deserialize;

use super::entry::{Entry, Section};
use super::kinds::{
    Acceleration, Angle, AngularDamping, AngularRate, AngularStiffness, Choice, Density, Flag, Inertia, Length,
    LinearDamping, List, Mass, Number, Pair, Pressure, Speed, Text, Time, Torque,
};
use super::table::keys::Keys;
use super::words::{MotorProfile, SceneKind, SpringType};
use super::{Bounds, Engine, Integrator, Interpolation, LogRates, Placement};
use crate::gripper::Assembly;
use crate::sizing::Rule;

/// A scene: one gripper variant, the object it grasps, and how it is simulated. A scene says only what differs from the
/// defaults. Quantities are texts with a unit: "15 mm", "120 deg", "480 N*mm".
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
#[schemars(title = "scene of a finger")]
pub struct RawScene {
    /// Scene file that this one extends, seen from the directory of this one: whatever is not said here is as it is there, but for
    /// its name and description. A section that says its `type` or `profile` replaces the one there; [lengths] replaces [design].
    pub extends: Entry<Text>,
    /// Name in reports and logs. Default: the file's name without its extension.
    pub name: Entry<Text>,
    /// What the scene is for; not used by the simulation.
    pub description: Entry<Text>,
    /// Kind of scene: "finger" is one finger of two phalanges and one motor; "bodies", of which all keys are others, are
    /// discs and a half plane.
    #[schemars(extend("default" = "finger"))]
    pub kind: Entry<Choice<SceneKind>>,
    /// Simulated time.
    #[schemars(extend("default" = "20 ms"))]
    pub duration: Entry<Time>,
    /// Gravity as x along and y out of the palm; the gripper hangs upside down by default.
    #[schemars(extend("default" = ["0 m/s^2", "9.81 m/s^2"]))]
    pub gravity: Entry<Pair<Acceleration>>,
    /// Half width w of every link; a phalanx is a capsule of this radius.
    #[schemars(extend("default" = "2.5 mm"))]
    pub half_width: Entry<Length>,
    /// Way the five-bar is put together: the mode of the straight configuration, or its mirror image.
    #[schemars(extend("default" = "reference"))]
    pub assembly: Entry<Choice<Assembly>>,
    /// Whether the palm, the half plane y ≤ 0, is there.
    #[schemars(extend("default" = true))]
    pub palm: Entry<Flag>,
    /// Sizes motor and spring to the finger instead of [motor] torque and [spring] torque (or the stiffness of a torsional
    /// spring with a preload): the spring holds the finger straight on a test trajectory up to the object; the motor has the
    /// RMS torque of this "rigid" phase, or of the "whole" trajectory.
    pub sizing: Entry<Choice<Rule>>,
    /// Length of the test trajectory that `sizing` sizes for.
    #[schemars(extend("default" = "10 ms"))]
    pub closing_time: Entry<Time>,
    pub design: Section<RawDesign>,
    pub lengths: Section<RawLengths>,
    pub material: Section<RawMaterial>,
    pub bodies: Section<RawBodies>,
    pub object: Section<RawObject>,
    pub motor: Section<RawMotor>,
    pub spring: Section<RawSpring>,
    pub limit: Section<RawLimit>,
    pub contact: Section<RawContact>,
    pub initial: Section<RawInitial>,
    pub integrator: Section<Keys<Integrator>>,
    pub engine: Section<Keys<Engine>>,
    pub validate: Section<Keys<Bounds>>,
    pub log: Section<Keys<LogRates>>,
}

/// The finger by the few free numbers of a design, made for the object. Either this or [lengths].
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawDesign {
    /// Distance along the palm from the ground joints to the object's centre. Required.
    pub base: Entry<Length>,
    /// Proximal phalanx l21. Either this or l21_fraction.
    pub l21: Entry<Length>,
    /// Proximal phalanx as a fraction, 0 to 1, of the range of l21 that the base allows.
    pub l21_fraction: Entry<Number>,
    /// Angle from the arm l22 to the distal phalanx. Required.
    pub phi22: Entry<Angle>,
    /// l22 / l11. Required.
    pub arm_ratio: Entry<Number>,
    /// Driven link.
    #[schemars(extend("default" = "15 mm"))]
    pub l11: Entry<Length>,
    /// Height of the closed finger over the object's diameter.
    #[schemars(extend("default" = 0.9375))]
    pub height_ratio: Entry<Number>,
    /// Smallest contact angle of the distal phalanx; sets the shortest l21.
    #[schemars(extend("default" = "5 deg"))]
    pub tip_contact_min: Entry<Angle>,
}

/// The finger by its link lengths. Either this or [design].
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawLengths {
    /// Driven link, between ground joint and coupler.
    #[schemars(extend("default" = "15 mm"))]
    pub l11: Entry<Length>,
    /// Coupler. Default: such that the finger is straight with l11 on the palm and l21 upright.
    pub l12: Entry<Length>,
    /// Proximal phalanx. Required.
    pub l21: Entry<Length>,
    /// Arm of the distal body, to the coupler. Required.
    pub l22: Entry<Length>,
    /// Distal phalanx. Required.
    pub t22: Entry<Length>,
    /// Angle from the arm l22 to the distal phalanx. Required.
    pub phi22: Entry<Angle>,
}

/// Material and depth of the links: with their outlines, these give masses and inertias.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawMaterial {
    #[schemars(extend("default" = "1070 kg/m^3"))]
    pub density: Entry<Density>,
    /// Extent of the links out of the plane.
    #[schemars(extend("default" = "40 mm"))]
    pub depth: Entry<Length>,
}

/// Mass properties that replace those from the outlines, body by body.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawBodies {
    pub l11: Section<RawBody>,
    pub l12: Section<RawBody>,
    pub l21: Section<RawBody>,
    pub l22: Section<RawBody>,
}

/// One body. A mass given without inertia scales the inertia of the outline with it.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawBody {
    pub mass: Entry<Mass>,
    /// Centre of mass along the link and to its left, from the joint before it.
    pub com: Entry<Pair<Length>>,
    /// Moment of inertia about the centre of mass.
    pub inertia: Entry<Inertia>,
}

/// The disc to be grasped; it is fixed.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawObject {
    /// Whether there is an object; false lets the finger swing freely.
    #[schemars(extend("default" = true))]
    pub present: Entry<Flag>,
    #[schemars(extend("default" = "20 mm"))]
    pub radius: Entry<Length>,
    /// Default with [design]: (−base, radius), resting on the palm. Required with [lengths].
    pub centre: Entry<Pair<Length>>,
}

/// Torque of the motor on the driven link; counter-clockwise (closing) is positive.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawMotor {
    /// How the torque goes over time: "constant"; "ramp": rises smoothly over `rise`; "half-sine": one pulse;
    /// "reversal": changes sign at `reverse_at`; "table": `times` and `torques`.
    #[schemars(extend("default" = "constant"))]
    pub profile: Entry<Choice<MotorProfile>>,
    /// Full torque. Required, except with profile = "table" or `sizing`.
    pub torque: Entry<Torque>,
    /// Time of the smooth rise from 0 (profile = "ramp").
    pub rise: Entry<Time>,
    /// Length of the pulse, after which the torque is 0 (profile = "half-sine").
    pub pulse: Entry<Time>,
    /// When the torque changes sign (profile = "reversal").
    pub reverse_at: Entry<Time>,
    /// Times of the table, increasing; the first torque holds before, the last one after (profile = "table").
    pub times: Entry<List<Time>>,
    /// Torques of the table, one for each time (profile = "table").
    pub torques: Entry<List<Torque>>,
    /// Between the times of the table: "linear", or "step", where each torque holds until the next time.
    #[schemars(extend("default" = "linear"))]
    pub interpolation: Entry<Choice<Interpolation>>,
}

/// The spring that pulls the finger straight.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawSpring {
    /// "constant": a constant torque; "torsional": stiffness × (preload + deflection); "none".
    #[serde(rename = "type")]
    #[schemars(extend("default" = "constant"))]
    pub kind: Entry<Choice<SpringType>>,
    /// Joint angle the spring acts on.
    #[schemars(extend("default" = "q22"))]
    pub placement: Entry<Choice<Placement>>,
    /// Torque of the constant spring. Required with type = "constant", except with `sizing`.
    pub torque: Entry<Torque>,
    /// Stiffness of the torsional spring. Required with type = "torsional", except with `sizing`.
    pub stiffness: Entry<AngularStiffness>,
    /// Deflection of the torsional spring in the straight configuration.
    #[schemars(extend("default" = "0 deg"))]
    pub preload: Entry<Angle>,
}

/// The stop that keeps the distal phalanx from bending backwards: q22 ≥ −phi22. A contact law on the angle.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawLimit {
    #[schemars(extend("default" = true))]
    pub enabled: Entry<Flag>,
    /// Stiffness k in N·m/rad^e, a plain number because its unit depends on the exponent e.
    #[schemars(extend("default" = 1e11))]
    pub stiffness_si: Entry<Number>,
    /// Exponent e, at least 1; give it together with stiffness_si.
    #[schemars(extend("default" = 2.2))]
    pub exponent: Entry<Number>,
    /// Damping c_max, fully engaged beyond the transition.
    #[schemars(extend("default" = "1e9 N*m*s/rad"))]
    pub damping: Entry<AngularDamping>,
    /// Penetration over which the damper engages.
    #[schemars(extend("default" = "1e-5 rad"))]
    pub transition: Entry<Angle>,
}

/// Laws of both contacts with the object; [contact.proximal] and [contact.distal] replace single keys for one of them.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawContact {
    /// Stiffness k in N/m^e, a plain number because its unit depends on the exponent e; 0 leaves the damper alone.
    #[schemars(extend("default" = 1e8))]
    pub stiffness_si: Entry<Number>,
    /// Exponent e, at least 1; give it together with stiffness_si.
    #[schemars(extend("default" = 2.2))]
    pub exponent: Entry<Number>,
    /// Damping c_max, fully engaged beyond the transition; 0 leaves the spring alone.
    #[schemars(extend("default" = "1e6 N*s/m"))]
    pub damping: Entry<LinearDamping>,
    /// Penetration over which the damper engages.
    #[schemars(extend("default" = "10 um"))]
    pub transition: Entry<Length>,
    pub materials: Section<RawMaterials>,
    pub friction: Section<RawFriction>,
    pub proximal: Section<RawSide>,
    pub distal: Section<RawSide>,
}

/// Law of one contact where it differs from [contact].
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawSide {
    /// Stiffness k in N/m^e.
    pub stiffness_si: Entry<Number>,
    /// Exponent e, at least 1; give it together with stiffness_si.
    pub exponent: Entry<Number>,
    /// Damping c_max.
    pub damping: Entry<LinearDamping>,
    /// Penetration over which the damper engages.
    pub transition: Entry<Length>,
    pub materials: Section<RawMaterials>,
    pub friction: Section<RawFriction>,
}

/// Materials and radii of the two surfaces instead of stiffness and exponent: Hertz, k = 4/3 E* √R and e = 3/2.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawMaterials {
    pub object: Section<RawElastic>,
    pub phalanx: Section<RawElastic>,
}

/// One surface of a Hertz contact.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawElastic {
    /// Young's modulus. Required.
    pub modulus: Entry<Pressure>,
    /// Poisson's ratio, above −1 and up to 0.5. Required.
    pub poisson: Entry<Number>,
    /// Radius of curvature. Default: the object's radius; a phalanx is flat.
    pub radius: Entry<Length>,
}

/// Regularised Coulomb friction; left out, the contact is frictionless.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawFriction {
    /// Static coefficient, reached at v_static; 0 is frictionless.
    #[schemars(extend("default" = 0.0))]
    pub mu_static: Entry<Number>,
    /// Dynamic coefficient, beyond v_dynamic. Default: 0.7 mu_static.
    pub mu_dynamic: Entry<Number>,
    #[schemars(extend("default" = "0.1 m/s"))]
    pub v_static: Entry<Speed>,
    #[schemars(extend("default" = "0.2 m/s"))]
    pub v_dynamic: Entry<Speed>,
}

/// Start of the simulation. Default: straight, 25° before the proximal phalanx touches the object, at rest.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RawInitial {
    /// Start straight, this far before the proximal phalanx touches the object.
    #[schemars(extend("default" = "25 deg"))]
    pub offset: Entry<Angle>,
    /// Angle of the driven link from the palm; needs q21. Default: that of the straight configuration.
    pub q11: Entry<Angle>,
    /// Angle of the proximal phalanx from the palm.
    pub q21: Entry<Angle>,
    #[schemars(extend("default" = "0 rad/s"))]
    pub qd11: Entry<AngularRate>,
    #[schemars(extend("default" = "0 rad/s"))]
    pub qd21: Entry<AngularRate>,
}
