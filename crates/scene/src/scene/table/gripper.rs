//! `[object]`, `[table]` and `[differential]` of a gripper.

use super::{lines, of};
use crate::scene::check::{NOT_NEGATIVE, POSITIVE};
use crate::scene::kinds::{Angle, AngularRate, Choice, Flag, Inertia, Length, Mass, Pair, Speed, Words};
use crate::scene::{Disc, DiscMotion, defaults};

/// Follows from something else unless it is given.
const FOLLOWS: f64 = f64::NAN;

/// The disc that a gripper grasps.
#[derive(Clone, Copy, Debug)]
pub struct Grasped {
    pub radius_m: f64,
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

impl Grasped {
    pub fn disc(self) -> Disc {
        let Self { radius_m, centre_m, angle_rad, motion } = self;
        let motion = match motion {
            GraspedMotion::Fixed => DiscMotion::Fixed,
            GraspedMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s } => {
                DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), velocity_m_s, spin_rad_s }
            }
        };
        Disc { name: Disc::OBJECT.to_string(), radius_m, centre_m, angle_rad, motion }
    }

    /// As it would be said; nothing drives an object.
    pub fn of(disc: &Disc) -> Self {
        let motion = match disc.motion {
            DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), velocity_m_s, spin_rad_s } => {
                GraspedMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s }
            }
            _ => GraspedMotion::Fixed,
        };
        Self { radius_m: disc.radius_m, centre_m: disc.centre_m, angle_rad: disc.angle_rad, motion }
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
    /// The disc to be grasped.
    Grasped = Self {
        radius_m: defaults::OBJECT_RADIUS_M,
        centre_m: [0.0, FOLLOWS],
        angle_rad: 0.0,
        motion: GraspedMotion::WORDS[0].1,
    }, o;
    /// What moves it: "free": contact and gravity; "fixed": nothing.
    "motion": Choice<GraspedMotion> = Some(&mut o.motion);
    "radius": Length = Some(&mut o.radius_m), allowed(POSITIVE);
    /// Positioning error: how far its centre starts to the right of the palm's middle.
    "offset": Length = Some(&mut o.centre_m[0]), said("0 mm");
    /// How far its centre starts above the palm. Default: its radius, so that it touches the palm.
    "height": Length = Some(&mut o.centre_m[1]);
    /// Its angle at the start.
    "angle": Angle = Some(&mut o.angle_rad), said("0 deg");
    /// Default: homogeneous, of 1070 kg/m³ and 40 mm deep (53.784 g at a radius of 20 mm).
    "mass": Mass = of!(o.motion, GraspedMotion::Free, mass_kg), allowed(POSITIVE),
        beside("motion", "with motion = \"fixed\"");
    /// Moment of inertia about its centre. Default: of a homogeneous disc, mass × radius² / 2.
    "inertia": Inertia = of!(o.motion, GraspedMotion::Free, inertia_kg_m2), allowed(POSITIVE),
        beside("motion", "with motion = \"fixed\"");
    /// Velocity of its centre at the start.
    "velocity": Pair<Speed> = of!(o.motion, GraspedMotion::Free, velocity_m_s), beside("motion", "with motion = \"fixed\"");
    /// Angular rate at the start, counter-clockwise.
    "spin": AngularRate = of!(o.motion, GraspedMotion::Free, spin_rad_s), said("0 rad/s"),
        beside("motion", "with motion = \"fixed\"");
}

/// A table or none.
#[derive(Clone, Copy, Debug)]
pub struct Support {
    pub present: bool,
    pub level_m: f64,
}

lines! {
    /// A table on which the object lies with its side away from the palm: everything above a level is solid and fixed. The section
    /// alone puts one there.
    Support = Self { present: true, level_m: FOLLOWS }, t;
    /// Whether it is there.
    "present": Flag = Some(&mut t.present);
    /// Height of its surface above the palm. Default: the object's diameter, so that a centred object touches it.
    "level": Length = t.present.then_some(&mut t.level_m), beside("present", "with present = false");
}

/// One input for both fingers, or two motors.
#[derive(Clone, Copy, Debug)]
pub struct Seesaw {
    pub present: bool,
    pub input_inertia_kg_m2: f64,
    pub seesaw_inertia_kg_m2: f64,
}

impl Seesaw {
    fn part(&mut self) -> Option<&mut Self> {
        self.present.then_some(self)
    }
}

lines! {
    /// A differential (seesaw): [motor] is its input then, and each finger gets half of that torque. The section alone puts one there.
    Seesaw = Self { present: true, input_inertia_kg_m2: 0.0, seesaw_inertia_kg_m2: 0.0 }, d;
    /// Whether it is there.
    "present": Flag = Some(&mut d.present);
    /// Inertia that turns with the input, by the mean of both driven links; that of [motor] comes on top.
    "input_inertia": Inertia = d.part().map(|d| &mut d.input_inertia_kg_m2), allowed(NOT_NEGATIVE), said("0 kg*m^2"),
        beside("present", "with present = false");
    /// Inertia of the seesaw, which turns by half the difference of both driven links.
    "seesaw_inertia": Inertia = d.part().map(|d| &mut d.seesaw_inertia_kg_m2), allowed(NOT_NEGATIVE), said("0 kg*m^2"),
        beside("present", "with present = false");
}
