//! `[discs.NAME]` of a scene of discs.

use super::lines;
use crate::scene::check::POSITIVE;
use crate::scene::kinds::{Acceleration, AngularRate, Choice, Flag, Inertia, Length, Mass, Pair, Speed};
use crate::scene::words::Motion;
use crate::scene::{Disc, DiscMotion};

/// Not a number where something must be given, or follows from something else.
const GIVEN: f64 = f64::NAN;

/// A disc but for its [shape](super::shape); a motion has a meaning for some of its figures only.
#[derive(Clone, Copy, Debug)]
pub struct DiscKeys {
    pub centre_m: [f64; 2],
    pub motion: Motion,
    pub velocity_m_s: [f64; 2],
    pub acceleration_m_s2: [f64; 2],
    pub mass_kg: f64,
    pub rotates: bool,
    pub inertia_kg_m2: f64,
    pub spin_rad_s: f64,
}

const USUAL: DiscKeys = DiscKeys {
    centre_m: [GIVEN; 2],
    motion: Motion::Free,
    velocity_m_s: [0.0; 2],
    acceleration_m_s2: [0.0; 2],
    mass_kg: GIVEN,
    rotates: true,
    inertia_kg_m2: GIVEN,
    spin_rad_s: 0.0,
};

impl DiscKeys {
    pub fn of(disc: &Disc) -> Self {
        let whole = Self { centre_m: disc.centre_m, ..USUAL };
        match disc.motion {
            DiscMotion::Fixed => Self { motion: Motion::Fixed, ..whole },
            DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s } => {
                Self { motion: Motion::Driven, velocity_m_s, acceleration_m_s2, spin_rad_s, ..whole }
            }
            DiscMotion::Free { mass_kg, inertia_kg_m2: Some(inertia_kg_m2), velocity_m_s, spin_rad_s } => {
                Self { velocity_m_s, mass_kg, inertia_kg_m2, spin_rad_s, ..whole }
            }
            DiscMotion::Free { mass_kg, inertia_kg_m2: None, velocity_m_s, .. } => {
                Self { velocity_m_s, mass_kg, rotates: false, spin_rad_s: f64::NAN, ..whole }
            }
        }
    }

    fn is(&self, motion: Motion) -> bool {
        self.motion == motion
    }
}

lines! {
    /// A disc.
    DiscKeys = USUAL, d;
    /// Where its centre starts. Required.
    "centre": Pair<Length> = Some(&mut d.centre_m), follows(),
        needed("add where it starts: centre = [\"0 mm\", \"10 mm\"]");
    /// What moves it: "free": gravity and contact; "driven": `velocity`, `acceleration` and `spin`, whatever it meets;
    /// "fixed": nothing.
    "motion": Choice<Motion> = Some(&mut d.motion);
    /// Velocity of the centre at the start (motion = "free" or "driven").
    "velocity": Pair<Speed> = (!d.is(Motion::Fixed)).then_some(&mut d.velocity_m_s),
        beside("motion", "with motion = \"fixed\"");
    /// Constant acceleration of the centre (motion = "driven").
    "acceleration": Pair<Acceleration> = d.is(Motion::Driven).then_some(&mut d.acceleration_m_s2),
        beside("motion", "without motion = \"driven\"");
    /// Required with, and only with, motion = "free".
    "mass": Mass = d.is(Motion::Free).then_some(&mut d.mass_kg), allowed(POSITIVE),
        beside("motion", "without motion = \"free\""),
        needed("add its mass: mass = \"100 g\"; or drive it: motion = \"driven\" with velocity");
    /// Whether contact can turn it (motion = "free").
    "rotates": Flag = d.is(Motion::Free).then_some(&mut d.rotates), beside("motion", "without motion = \"free\"");
    /// Moment of inertia about the centre (motion = "free"). Default: of a homogeneous disc, mass × radius² / 2.
    "inertia": Inertia = d.is(Motion::Free).then_some(&mut d.inertia_kg_m2), allowed(POSITIVE),
        beside("motion", "without motion = \"free\"");
    /// Angular rate at the start, counter-clockwise (motion = "free" or "driven").
    "spin": AngularRate = (!d.is(Motion::Fixed)).then_some(&mut d.spin_rad_s), said("0 rad/s"),
        beside("motion", "with motion = \"fixed\"");
}
