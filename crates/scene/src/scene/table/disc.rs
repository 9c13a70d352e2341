//! `[discs.NAME]` of a scene of discs.

use super::settings;
use crate::scene::check::POSITIVE;
use crate::scene::keywords::Motion;
use crate::scene::value_kinds::{Acceleration, AngularRate, Choice, Flag, Inertia, Length, Mass, Pair, Speed};
use crate::scene::{Disc, DiscMotion};

/// A value that is required, or derived from other settings.
const UNSET: f64 = f64::NAN;

/// Settings of a disc except its [shape](super::shape); some apply to one kind of motion only.
#[derive(Clone, Copy, Debug)]
pub struct DiscSettings {
    pub centre_m: [f64; 2],
    pub motion: Motion,
    pub velocity_m_s: [f64; 2],
    pub acceleration_m_s2: [f64; 2],
    pub mass_kg: f64,
    pub rotates: bool,
    pub inertia_kg_m2: f64,
    pub spin_rad_s: f64,
}

const DEFAULTS: DiscSettings = DiscSettings {
    centre_m: [UNSET; 2],
    motion: Motion::Free,
    velocity_m_s: [0.0; 2],
    acceleration_m_s2: [0.0; 2],
    mass_kg: UNSET,
    rotates: true,
    inertia_kg_m2: UNSET,
    spin_rad_s: 0.0,
};

impl DiscSettings {
    pub fn from_disc(disc: &Disc) -> Self {
        let base = Self { centre_m: disc.centre_m, ..DEFAULTS };
        match disc.motion {
            DiscMotion::Fixed => Self { motion: Motion::Fixed, ..base },
            DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s } => {
                Self { motion: Motion::Driven, velocity_m_s, acceleration_m_s2, spin_rad_s, ..base }
            }
            DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), velocity_m_s, spin_rad_s } => {
                Self { velocity_m_s, mass_kg, inertia_kg_m2, spin_rad_s, ..base }
            }
            DiscMotion::Free { mass_kg, inertia_kg_m2: None, velocity_m_s, .. } => {
                Self { velocity_m_s, mass_kg, rotates: false, spin_rad_s: f64::NAN, ..base }
            }
        }
    }

    fn has_motion(&self, motion: Motion) -> bool {
        self.motion == motion
    }
}

settings! {
    /// A disc.
    DiscSettings = DEFAULTS, d;
    /// Initial position of the centre. Required.
    "centre": Pair<Length> = Some(&mut d.centre_m), derived(),
        required("add the initial position: centre = [\"0 mm\", \"10 mm\"]");
    /// "free": moves under gravity and contact forces; "driven": moves with `velocity`, `acceleration` and `spin`, not
    /// affected by contacts; "fixed": does not move.
    "motion": Choice<Motion> = Some(&mut d.motion);
    /// Initial velocity of the centre (motion = "free" or "driven").
    "velocity": Pair<Speed> = (!d.has_motion(Motion::Fixed)).then_some(&mut d.velocity_m_s),
        depends_on("motion", "with motion = \"fixed\"");
    /// Constant acceleration of the centre (motion = "driven").
    "acceleration": Pair<Acceleration> = d.has_motion(Motion::Driven).then_some(&mut d.acceleration_m_s2),
        depends_on("motion", "without motion = \"driven\"");
    /// Mass. Required with motion = "free", not allowed otherwise.
    "mass": Mass = d.has_motion(Motion::Free).then_some(&mut d.mass_kg), allowed(POSITIVE),
        depends_on("motion", "without motion = \"free\""),
        required("add the mass: mass = \"100 g\"; or drive the disc: motion = \"driven\" with velocity");
    /// Whether contact forces can rotate it (motion = "free").
    "rotates": Flag = d.has_motion(Motion::Free).then_some(&mut d.rotates), depends_on("motion", "without motion = \"free\"");
    /// Moment of inertia about the centre (motion = "free"). Default: mass × radius² / 2 of a homogeneous disc.
    "inertia": Inertia = d.has_motion(Motion::Free).then_some(&mut d.inertia_kg_m2), allowed(POSITIVE),
        depends_on("motion", "without motion = \"free\"");
    /// Initial angular rate, counter-clockwise (motion = "free" or "driven").
    "spin": AngularRate = (!d.has_motion(Motion::Fixed)).then_some(&mut d.spin_rad_s), default_text("0 rad/s"),
        depends_on("motion", "with motion = \"fixed\"");
}
