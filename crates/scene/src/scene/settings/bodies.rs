//! The grasped object, discs, ground and table.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{FINGER, GRIPPER};
use crate::scene::keywords::Motion;
use crate::scene::quantity::{
    Acceleration, Angle, AngularRate, Inertia, Length, Mass, Positive, Quantity, Speed, Word,
};
use crate::scene::{Disc, DiscMotion};
use crate::shape::Shape;

fn radius<R>(shape: &Shape) -> Quantity<Length, R> {
    let Shape::Disc { radius_m } = shape;
    (*radius_m).into()
}

/// The object to be grasped, a fixed disc.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[schemars(extend("x-gripper" = { "description": "The object to be grasped, a disc." }))]
pub struct ObjectSettings {
    /// Whether there is an object; without one the finger moves freely.
    #[schemars(extend("x-kinds" = FINGER, "default" = true))]
    pub present: Option<bool>,
    /// "free": moves under gravity and contact forces; "fixed": does not move.
    #[schemars(extend("x-kinds" = GRIPPER, "default" = "free", "enum" = ["free", "fixed"]))]
    pub motion: Option<Word<Motion>>,
    #[schemars(extend("default" = "20 mm"))]
    pub radius: Option<Positive<Length>>,
    /// Position of the centre. Default: (−base, radius), resting on the palm, with the base of [design] or [lengths].
    #[schemars(extend("x-kinds" = FINGER, "x-with" = "present = true", "x-derived" = true))]
    pub centre: Option<[Quantity<Length>; 2]>,
    /// Positioning error: initial distance of the centre to the right of the middle of the palm.
    #[schemars(extend("x-kinds" = GRIPPER, "default" = "0 mm"))]
    pub offset: Option<Quantity<Length>>,
    /// Initial height of the centre above the palm. Default: the radius, so that the object touches the palm.
    #[schemars(extend("x-kinds" = GRIPPER))]
    pub height: Option<Quantity<Length>>,
    /// Initial angle.
    #[schemars(extend("x-kinds" = GRIPPER, "default" = "0 deg"))]
    pub angle: Option<Quantity<Angle>>,
    /// Mass. Default: that of a homogeneous disc with 1070 kg/m³ and a depth of 40 mm (53.784 g for a radius of 20 mm).
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "motion = free"))]
    pub mass: Option<Positive<Mass>>,
    /// Moment of inertia about the centre. Default: mass × radius² / 2 of a homogeneous disc.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "motion = free"))]
    pub inertia: Option<Positive<Inertia>>,
    /// Initial velocity of the centre.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "motion = free", "default" = ["0 m/s", "0 m/s"]))]
    pub velocity: Option<[Quantity<Speed>; 2]>,
    /// Initial angular rate, counter-clockwise.
    #[schemars(extend("x-kinds" = GRIPPER, "x-with" = "motion = free", "default" = "0 rad/s"))]
    pub spin: Option<Quantity<AngularRate>>,
}

impl From<Option<&Disc>> for ObjectSettings {
    /// Settings of a given disc; a driven disc becomes fixed, because an object cannot be driven.
    fn from(disc: Option<&Disc>) -> Self {
        let Some(disc) = disc else { return ObjectSettings { present: Some(false), ..Self::default() } };
        let Disc { shape, centre_m, angle_rad, .. } = disc;
        let mut settings = ObjectSettings {
            present: Some(true),
            motion: Some(Word(Motion::Fixed)),
            radius: Some(radius(shape)),
            centre: Some(centre_m.map(Quantity::from)),
            offset: Some(centre_m[0].into()),
            height: Some(centre_m[1].into()),
            angle: Some((*angle_rad).into()),
            ..Self::default()
        };
        if let DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), velocity_m_s, spin_rad_s } = disc.motion
        {
            settings.motion = Some(Word(Motion::Free));
            (settings.mass, settings.inertia) = (Some(mass_kg.into()), Some(inertia_kg_m2.into()));
            (settings.velocity, settings.spin) = (Some(velocity_m_s.map(Quantity::from)), Some(spin_rad_s.into()));
        }
        settings
    }
}

/// A disc.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct DiscSettings {
    #[schemars(extend("x-required" = "add its size: radius = \"10 mm\""))]
    pub radius: Option<Positive<Length>>,
    /// Initial position of the centre. Required.
    #[schemars(extend("x-required" = "add the initial position: centre = [\"0 mm\", \"10 mm\"]"))]
    pub centre: Option<[Quantity<Length>; 2]>,
    /// "free": moves under gravity and contact forces; "driven": moves with `velocity`, `acceleration` and `spin`, not
    /// affected by contacts; "fixed": does not move.
    #[schemars(extend("default" = "free"))]
    pub motion: Word<Motion>,
    /// Initial velocity of the centre (motion = "free" or "driven").
    #[schemars(extend("x-with" = "motion = free|driven", "default" = ["0 m/s", "0 m/s"]))]
    pub velocity: [Quantity<Speed>; 2],
    /// Constant acceleration of the centre (motion = "driven").
    #[schemars(extend("x-with" = "motion = driven", "default" = ["0 m/s^2", "0 m/s^2"]))]
    pub acceleration: [Quantity<Acceleration>; 2],
    /// Mass. Required with motion = "free", not allowed otherwise.
    #[schemars(extend("x-with" = "motion = free",
        "x-required" = "add the mass: mass = \"100 g\"; or drive the disc: motion = \"driven\" with velocity"))]
    pub mass: Option<Positive<Mass>>,
    /// Whether contact forces can rotate it (motion = "free").
    #[schemars(extend("x-with" = "motion = free", "default" = true))]
    pub rotates: bool,
    /// Moment of inertia about the centre (motion = "free"). Default: mass × radius² / 2 of a homogeneous disc.
    #[schemars(extend("x-with" = "motion = free"))]
    pub inertia: Option<Positive<Inertia>>,
    /// Initial angular rate, counter-clockwise (motion = "free" or "driven").
    #[schemars(extend("x-with" = "motion = free|driven", "default" = "0 rad/s"))]
    pub spin: Option<Quantity<AngularRate>>,
}

impl From<&Disc> for DiscSettings {
    fn from(disc: &Disc) -> Self {
        let mut settings = DiscSettings {
            radius: Some(radius(&disc.shape)),
            centre: Some(disc.centre_m.map(Quantity::from)),
            motion: Word(Motion::Fixed),
            ..Self::default()
        };
        match disc.motion {
            DiscMotion::Fixed => {}
            DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s } => {
                (settings.motion, settings.spin) = (Word(Motion::Driven), Some(spin_rad_s.into()));
                settings.velocity = velocity_m_s.map(Quantity::from);
                settings.acceleration = acceleration_m_s2.map(Quantity::from);
            }
            DiscMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s } => {
                (settings.motion, settings.mass) = (Word(Motion::Free), Some(mass_kg.into()));
                settings.velocity = velocity_m_s.map(Quantity::from);
                (settings.rotates, settings.inertia) = (inertia_kg_m2.is_some(), inertia_kg_m2.map(Quantity::from));
                settings.spin = inertia_kg_m2.map(|_| spin_rad_s.into());
            }
        }
        settings
    }
}

/// A solid, fixed half plane below a level. An empty section suffices to add it.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct HalfPlaneSettings {
    /// Height y of the surface.
    #[schemars(extend("default" = "0 mm"))]
    pub level: Quantity<Length>,
}

/// A table that supports the object on the side away from the palm: a solid, fixed half plane above a level. An
/// empty section suffices to add it.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct TableSettings {
    /// Whether there is a table.
    #[schemars(extend("default" = true))]
    pub present: bool,
    /// Height of the surface above the palm. Default: the top of the object, so that the object touches the table.
    #[schemars(extend("x-with" = "present = true"))]
    pub level: Option<Quantity<Length>>,
}
