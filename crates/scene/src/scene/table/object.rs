//! `[object]`: what fingers grasp.

use super::shape::UNSAID;
use super::{lines, of};
use crate::scene::check::POSITIVE;
use crate::scene::kinds::{Angle, AngularRate, Choice, Flag, Inertia, Length, Mass, Pair, Speed, Words};
use crate::scene::words::{ONE_FINGER, SceneKind, TWO_FINGERS};
use crate::scene::{Disc, DiscMotion, defaults};
use crate::shape::{Placed, Shape};

/// Follows from something else unless it is given.
const FOLLOWS: f64 = f64::NAN;

/// The disc that fingers grasp, or none.
#[derive(Clone, Copy, Debug)]
pub struct Object {
    pub present: bool,
    /// By keys of its own.
    pub shape: Shape,
    pub centre_m: [f64; 2],
    pub angle_rad: f64,
    pub motion: GraspedMotion,
}

/// What moves it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GraspedMotion {
    Fixed,
    Free { mass_kg: f64, inertia_kg_m2: f64, velocity_m_s: [f64; 2], spin_rad_s: f64 },
}

impl Object {
    /// Keys that stand before those of its shape.
    pub const HEADING: [&str; 2] = ["present", "motion"];

    /// None; its shape means nothing.
    pub const NONE: Self =
        Self { present: false, shape: UNSAID, centre_m: [f64::NAN; 2], angle_rad: 0.0, motion: GraspedMotion::Fixed };

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

    /// Where it starts.
    pub fn placed(self) -> Placed {
        self.disc().placed()
    }

    /// Where it begins and ends above the palm.
    pub fn heights_m(self) -> [f64; 2] {
        let placed = self.placed();
        [-1.0, 1.0].map(|to| placed.furthest_m([0.0, to])[1])
    }

    /// As it would be said; nothing drives an object.
    pub fn of(disc: &Disc) -> Self {
        let motion = match disc.motion {
            DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), velocity_m_s, spin_rad_s } => {
                GraspedMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s }
            }
            _ => GraspedMotion::Fixed,
        };
        Self { present: true, shape: disc.shape, centre_m: disc.centre_m, angle_rad: disc.angle_rad, motion }
    }
}

impl Words for GraspedMotion {
    const WORDS: &'static [(&'static str, Self)] = &[
        (
            "free",
            GraspedMotion::Free { mass_kg: FOLLOWS, inertia_kg_m2: FOLLOWS, velocity_m_s: [0.0; 2], spin_rad_s: 0.0 },
        ),
        ("fixed", GraspedMotion::Fixed),
    ];
}

lines! {
    /// The disc to be grasped; it is fixed.
    Object = Self {
        present: true,
        shape: defaults::OBJECT,
        centre_m: [FOLLOWS; 2],
        angle_rad: 0.0,
        motion: GraspedMotion::Fixed,
    }, o, where {
        const DOCS: &'static [(SceneKind, &'static str)] = &[(SceneKind::Gripper, "The disc to be grasped.")];

        fn usual_in(kind: SceneKind) -> Self {
            match kind {
                SceneKind::Gripper => Self { centre_m: [0.0, FOLLOWS], motion: GraspedMotion::WORDS[0].1, ..Self::usual() },
                SceneKind::Finger | SceneKind::Bodies => Self::usual(),
            }
        }
    };
    /// Whether there is an object; false lets the finger swing freely.
    "present": Flag = Some(&mut o.present), of(ONE_FINGER);
    /// What moves it: "free": contact and gravity; "fixed": nothing.
    "motion": Choice<GraspedMotion> = Some(&mut o.motion), of(TWO_FINGERS);
    /// Default: (−base, radius), resting on the palm, by the base of [design] or [lengths].
    "centre": Pair<Length> = o.present.then_some(&mut o.centre_m), follows(),
        beside("present", "with present = false"), of(ONE_FINGER);
    /// Positioning error: how far its centre starts to the right of the palm's middle.
    "offset": Length = Some(&mut o.centre_m[0]), said("0 mm"), of(TWO_FINGERS);
    /// How far its centre starts above the palm. Default: its radius, so that it touches the palm.
    "height": Length = Some(&mut o.centre_m[1]), of(TWO_FINGERS);
    /// Its angle at the start.
    "angle": Angle = Some(&mut o.angle_rad), said("0 deg"), of(TWO_FINGERS);
    /// Default: homogeneous, of 1070 kg/m³ and 40 mm deep (53.784 g at a radius of 20 mm).
    "mass": Mass = of!(o.motion, GraspedMotion::Free, mass_kg), allowed(POSITIVE),
        beside("motion", "with motion = \"fixed\""), of(TWO_FINGERS);
    /// Moment of inertia about its centre. Default: of a homogeneous disc, mass × radius² / 2.
    "inertia": Inertia = of!(o.motion, GraspedMotion::Free, inertia_kg_m2), allowed(POSITIVE),
        beside("motion", "with motion = \"fixed\""), of(TWO_FINGERS);
    /// Velocity of its centre at the start.
    "velocity": Pair<Speed> = of!(o.motion, GraspedMotion::Free, velocity_m_s), beside("motion", "with motion = \"fixed\""), of(TWO_FINGERS);
    /// Angular rate at the start, counter-clockwise.
    "spin": AngularRate = of!(o.motion, GraspedMotion::Free, spin_rad_s), said("0 rad/s"),
        beside("motion", "with motion = \"fixed\""), of(TWO_FINGERS);
}
