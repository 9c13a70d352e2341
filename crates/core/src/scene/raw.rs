//! The scene file as it is written. Doc comments become the descriptions of the JSON Schema; defaults stand beside them.

use schemars::JsonSchema;
use serde::Deserialize;

use super::entry::{Entry, Section};
use super::kinds::{Acceleration, Angle, Choice, Flag, Inertia, Length, Mass, Number, Pair, Text, Time};
use super::table::drive::{Motor, Springs};
use super::table::finger::{Material, Start};
use super::table::keys::Keys;
use super::table::law::{Contact, Limit};
use super::words::SceneKind;
use super::{Bounds, Engine, Integrator, LogRates};
use crate::gripper::{Assembly, Lengths};
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
    pub lengths: Section<Keys<Lengths>>,
    pub material: Section<Keys<Material>>,
    pub bodies: Section<RawBodies>,
    pub object: Section<RawObject>,
    pub motor: Section<Keys<Motor>>,
    pub spring: Section<Keys<Springs>>,
    pub limit: Section<Keys<Limit>>,
    pub contact: Section<Keys<Contact>>,
    pub initial: Section<Keys<Start>>,
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
