//! `[object]`: the object that fingers grasp.

use super::shape::UNSET_SHAPE;
use super::{settings, variant_field};
use crate::scene::check::POSITIVE;
use crate::scene::keywords::{ONE_FINGER, SceneKind, TWO_FINGERS};
use crate::scene::value_kinds::{Angle, AngularRate, Choice, Flag, Inertia, Keyword, Length, Mass, Pair, Speed};
use crate::scene::{Disc, DiscMotion, defaults};
use crate::shape::{PlacedShape, Shape};

/// A value that is derived from other settings unless it is given.
const UNSET: f64 = f64::NAN;

/// Settings of the grasped object, which may be absent.
#[derive(Clone, Copy, Debug)]
pub struct ObjectSettings {
    pub present: bool,
    /// Read from the keys of [shapes](super::shape).
    pub shape: Shape,
    pub centre_m: [f64; 2],
    pub angle_rad: f64,
    pub motion: GraspedMotion,
}

/// Motion of the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GraspedMotion {
    Fixed,
    Free { mass_kg: f64, inertia_kg_m2: f64, velocity_m_s: [f64; 2], spin_rad_s: f64 },
}

impl ObjectSettings {
    /// Keys that precede those of the shape.
    pub const HEADING: [&str; 2] = ["present", "motion"];

    /// No object; the shape is unused.
    pub const NONE: Self = Self {
        present: false,
        shape: UNSET_SHAPE,
        centre_m: [f64::NAN; 2],
        angle_rad: 0.0,
        motion: GraspedMotion::Fixed,
    };

    pub fn disc(self) -> Disc {
        let Self { shape, centre_m, angle_rad, motion, .. } = self;
        let motion = match motion {
            GraspedMotion::Fixed => DiscMotion::Fixed,
            GraspedMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s } => {
                DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), velocity_m_s, spin_rad_s }
            }
        };
        Disc { name: Disc::OBJECT.to_string(), shape, centre_m, angle_rad, motion }
    }

    /// Shape and initial pose.
    pub fn placed(self) -> PlacedShape {
        self.disc().placed()
    }

    /// Lowest and highest coordinate y.
    pub fn heights_m(self) -> [f64; 2] {
        let placed = self.placed();
        [-1.0, 1.0].map(|to| placed.furthest_point_m([0.0, to])[1])
    }

    /// Settings of a given disc; a driven disc becomes fixed, because an object cannot be driven.
    pub fn from_disc(disc: &Disc) -> Self {
        let motion = match disc.motion {
            DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), velocity_m_s, spin_rad_s } => {
                GraspedMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s }
            }
            _ => GraspedMotion::Fixed,
        };
        Self { present: true, shape: disc.shape, centre_m: disc.centre_m, angle_rad: disc.angle_rad, motion }
    }
}

impl Keyword for GraspedMotion {
    const KEYWORDS: &'static [(&'static str, Self)] = &[
        ("free", GraspedMotion::Free { mass_kg: UNSET, inertia_kg_m2: UNSET, velocity_m_s: [0.0; 2], spin_rad_s: 0.0 }),
        ("fixed", GraspedMotion::Fixed),
    ];
}

settings! {
    /// The object to be grasped, a fixed disc.
    ObjectSettings = Self {
        present: true,
        shape: defaults::OBJECT,
        centre_m: [UNSET; 2],
        angle_rad: 0.0,
        motion: GraspedMotion::Fixed,
    }, o, where {
        const DOC_OVERRIDES: &'static [(SceneKind, &'static str)] = &[(SceneKind::Gripper, "The object to be grasped, a disc.")];

        fn defaults_for(kind: SceneKind) -> Self {
            match kind {
                SceneKind::Gripper => Self { centre_m: [0.0, UNSET], motion: GraspedMotion::KEYWORDS[0].1, ..Self::defaults() },
                SceneKind::Finger | SceneKind::Bodies => Self::defaults(),
            }
        }
    };
    /// Whether there is an object; without one the finger moves freely.
    "present": Flag = Some(&mut o.present), only_in(ONE_FINGER);
    /// "free": moves under gravity and contact forces; "fixed": does not move.
    "motion": Choice<GraspedMotion> = Some(&mut o.motion), only_in(TWO_FINGERS);
    /// Position of the centre. Default: (−base, radius), resting on the palm, with the base of [design] or [lengths].
    "centre": Pair<Length> = o.present.then_some(&mut o.centre_m), derived(),
        depends_on("present", "with present = false"), only_in(ONE_FINGER);
    /// Positioning error: initial distance of the centre to the right of the middle of the palm.
    "offset": Length = Some(&mut o.centre_m[0]), default_text("0 mm"), only_in(TWO_FINGERS);
    /// Initial height of the centre above the palm. Default: the radius, so that the object touches the palm.
    "height": Length = Some(&mut o.centre_m[1]), only_in(TWO_FINGERS);
    /// Initial angle.
    "angle": Angle = Some(&mut o.angle_rad), default_text("0 deg"), only_in(TWO_FINGERS);
    /// Mass. Default: that of a homogeneous disc with 1070 kg/m³ and a depth of 40 mm (53.784 g for a radius of 20 mm).
    "mass": Mass = variant_field!(o.motion, GraspedMotion::Free, mass_kg), allowed(POSITIVE),
        depends_on("motion", "with motion = \"fixed\""), only_in(TWO_FINGERS);
    /// Moment of inertia about the centre. Default: mass × radius² / 2 of a homogeneous disc.
    "inertia": Inertia = variant_field!(o.motion, GraspedMotion::Free, inertia_kg_m2), allowed(POSITIVE),
        depends_on("motion", "with motion = \"fixed\""), only_in(TWO_FINGERS);
    /// Initial velocity of the centre.
    "velocity": Pair<Speed> = variant_field!(o.motion, GraspedMotion::Free, velocity_m_s), depends_on("motion", "with motion = \"fixed\""), only_in(TWO_FINGERS);
    /// Initial angular rate, counter-clockwise.
    "spin": AngularRate = variant_field!(o.motion, GraspedMotion::Free, spin_rad_s), default_text("0 rad/s"),
        depends_on("motion", "with motion = \"fixed\""), only_in(TWO_FINGERS);
}
