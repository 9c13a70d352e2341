//! Fingers, discs and contacts, and what of them does not change in time.

use super::laws::Laws;
use crate::analytic::SiteState;
use crate::analytic::finger::FingerModel;
use crate::fivebar::carried::Carried;
use crate::gripper::Site;
use crate::law::{Bristle, FrictionLaw, NormalLaw};
use crate::scene::{Disc, DiscMotion, Side};
use crate::shape::Shape;

/// A finger, and its contacts among all.
#[derive(Clone, Debug)]
pub struct FingerPart {
    pub side: Side,
    pub model: FingerModel,
    pub carried: Carried,
    pub contacts: Vec<usize>,
}

/// A disc: inverses are 0 where it is fixed or driven, and that of the inertia also where it does not turn.
#[derive(Clone, Copy, Debug)]
pub struct DiscPart {
    /// The first of its three coordinates; beyond all of them where it is fixed.
    pub first: usize,
    pub shape: Shape,
    /// Of kinetic and gravity energy: 0 where it does not move by itself.
    pub mass: f64,
    pub inertia: f64,
    pub inverse_mass: f64,
    pub inverse_inertia: f64,
    /// Where a fixed one is.
    pub pose: [f64; 3],
    /// Of one that moves as told.
    pub driven: Option<[f64; 2]>,
}

/// A half plane that only discs meet: `normal` points to them, and `offset` is its distance from the origin against that.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    pub normal: [f64; 2],
    pub offset: f64,
}

/// What meets what: fingers and discs by their indices.
#[derive(Clone, Copy, Debug)]
pub enum Meet {
    Phalanx {
        finger: usize,
        site: Site,
        disc: usize,
    },
    Stop {
        finger: usize,
    },
    Discs {
        disc: usize,
        other: usize,
    },
    Plane {
        disc: usize,
        plane: Plane,
    },
    /// On a table that is at rest in the world while the frame is not.
    PassingPlane {
        disc: usize,
        plane: Plane,
    },
}

/// A contact with its laws.
#[derive(Clone, Copy, Debug)]
pub struct Joined {
    pub meet: Meet,
    pub normal: NormalLaw,
    pub friction: Option<FrictionLaw>,
    /// Where the memory of its bristle is, if it has one.
    pub memory: Option<usize>,
}

impl DiscPart {
    pub fn new(disc: &Disc, first: usize) -> Self {
        let ([x, y], angle) = (disc.centre_m, disc.angle_rad);
        let fixed = Self {
            first,
            shape: disc.shape,
            mass: 0.0,
            inertia: 0.0,
            inverse_mass: 0.0,
            inverse_inertia: 0.0,
            pose: [x, y, angle],
            driven: None,
        };
        match disc.motion {
            DiscMotion::Fixed => fixed,
            DiscMotion::Driven { acceleration_m_s2, .. } => Self { driven: Some(acceleration_m_s2), ..fixed },
            DiscMotion::Free { mass_kg, inertia_kg_m2, .. } => Self {
                mass: mass_kg,
                inertia: inertia_kg_m2.unwrap_or(0.0),
                inverse_mass: mass_kg.recip(),
                inverse_inertia: inertia_kg_m2.map_or(0.0, f64::recip),
                ..fixed
            },
        }
    }
}

impl Plane {
    /// One whose solid is below it, or above where `up` is negative.
    pub fn at(level_m: f64, up: f64) -> Self {
        Self { normal: [0.0, up], offset: level_m }
    }
}

impl Joined {
    pub fn new(meet: Meet, law: (NormalLaw, Option<FrictionLaw>)) -> Self {
        Self { meet, normal: law.0, friction: law.1, memory: None }
    }

    /// Its laws, where it presses.
    #[inline(always)]
    pub fn laws(&self, state: SiteState) -> Option<Laws<'_>> {
        state.presses().then_some(Laws { normal: &self.normal, friction: self.friction.as_ref(), state })
    }

    /// What holds in it.
    pub fn bristle(&self) -> Option<Bristle> {
        self.friction.and_then(|friction| friction.bristle)
    }
}
