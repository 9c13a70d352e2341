//! `[engine]`: how the engine model is built and stepped.

use super::{lines, of};
use crate::scene::check::{Bound, NOT_NEGATIVE, POSITIVE};
use crate::scene::kinds::{Choice, Count, Length, Number, Sweeps, Time, Words};
use crate::scene::table::integrator::MAX_STEPS;

/// How the engine model is built and stepped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Engine {
    pub construction: Construction,
    pub response: Response,
    pub stepping: Stepping,
    /// Sweeps of rapier's projected Gauss–Seidel solver over the joints, per step.
    pub iterations: u32,
    /// Step budget; a run that needs more ends with an error and keeps its log.
    pub max_steps: u64,
}

/// Coordinates of the engine model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Construction {
    /// Every body moves freely, every joint is a constraint between two of them: second order.
    Maximal,
    /// A tree of joints in its own coordinates, closed by one constraint: first order.
    Reduced,
}

/// What answers when bodies of the engine model touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Response {
    /// The scene's contact laws, through the contact-force hook.
    Laws,
    /// rapier's own rigid contact, with its Coulomb friction and Newton restitution.
    Rapier { friction: f64, restitution: f64 },
}

/// Step sizes of the engine model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stepping {
    Fixed {
        step_s: f64,
    },
    /// Steps in which no joint strays further than `tolerance_m` from its arc; shorter around impacts.
    Adaptive {
        tolerance_m: f64,
        max_step_s: f64,
    },
}

pub const ENGINE_MAX_STEP_S: f64 = 6e-5;

const ADAPTIVE: Stepping = Stepping::Adaptive { tolerance_m: 1e-7, max_step_s: ENGINE_MAX_STEP_S };
/// How long is for the scene to say.
const FIXED: Stepping = Stepping::Fixed { step_s: f64::NAN };
/// Its friction is that of the contact.
const RAPIER: Response = Response::Rapier { friction: f64::NAN, restitution: 0.0 };

impl Words for Construction {
    const WORDS: &'static [(&'static str, Self)] =
        &[("maximal", Construction::Maximal), ("reduced", Construction::Reduced)];
}

impl Words for Response {
    const WORDS: &'static [(&'static str, Self)] = &[("scene", Response::Laws), ("rapier", RAPIER)];
}

impl Words for Stepping {
    const WORDS: &'static [(&'static str, Self)] = &[("adaptive", ADAPTIVE), ("fixed", FIXED)];
}

impl Engine {
    pub const DEFAULT: Self = Self {
        construction: Construction::Maximal,
        response: Response::Laws,
        stepping: ADAPTIVE,
        iterations: Self::usual_iterations(Response::Laws),
        max_steps: MAX_STEPS,
    };

    /// Whether it answers contact by the scene's laws, as the analytic model does.
    pub fn uses_laws(&self) -> bool {
        self.response == Response::Laws
    }

    /// Joint sweeps unless the scene says otherwise. With the contact laws the engine hands rapier the reactions, and the sweeps
    /// only confirm them; of rapier's own contact they must carry the impulses through the linkage.
    pub const fn usual_iterations(response: Response) -> u32 {
        match response {
            Response::Laws => 2,
            Response::Rapier { .. } => 50,
        }
    }
}

const RESTITUTION: Bound = Bound { allowed: |x| (0.0..=1.0).contains(&x), text: "from 0 to 1" };

lines! {
    /// How the engine model is built and stepped.
    Engine = Self::DEFAULT, e;
    /// "maximal": every body moves freely, every joint is a constraint; "reduced": a tree of joints in its own
    /// coordinates, closed by one constraint (a scene of discs has no joints: "maximal" only).
    "construction": Choice<Construction> = Some(&mut e.construction);
    /// What answers when bodies touch: "scene": the laws of [contact]; "rapier": rapier's own rigid contact.
    "law": Choice<Response> = Some(&mut e.response),
        put(|e, response| (e.response, e.iterations) = (response, Self::usual_iterations(response)));
    /// Coefficient of rapier's Coulomb friction (law = "rapier"). Default: mu_static of the contact (of the
    /// proximal one of a finger).
    "friction": Number = of!(e.response, Response::Rapier, friction),
        allowed(NOT_NEGATIVE), beside("law", "without law = \"rapier\"");
    /// Coefficient of rapier's Newton restitution, 0 to 1 (law = "rapier").
    "restitution": Number = of!(e.response, Response::Rapier, restitution),
        allowed(RESTITUTION), beside("law", "without law = \"rapier\"");
    /// "adaptive": steps as long as the joints allow, shorter around impacts; "fixed": all of size `step`.
    "stepping": Choice<Stepping> = Some(&mut e.stepping);
    /// Size of every step. Required with, and only with, stepping = "fixed".
    "step": Time = of!(e.stepping, Stepping::Fixed, step_s),
        allowed(POSITIVE), beside("stepping", "without stepping = \"fixed\""),
        needed("add the size of the steps: step = \"10 us\"; or leave it to the engine: stepping = \"adaptive\"");
    /// How far a joint may stray from its arc in one step, because bodies move straight on (stepping = "adaptive").
    /// The default is smaller in proportion where the shortest link is shorter than 2.5 mm.
    "tolerance": Length = of!(e.stepping, Stepping::Adaptive, tolerance_m),
        allowed(POSITIVE), beside("stepping", "with stepping = \"fixed\""), said("1e-4 mm");
    /// Longest step (stepping = "adaptive").
    "max_step": Time = of!(e.stepping, Stepping::Adaptive, max_step_s),
        allowed(POSITIVE), beside("stepping", "with stepping = \"fixed\"");
    /// Sweeps of rapier's joint solver in every step. Default: 2, or 50 with law = "rapier".
    "iterations": Sweeps = Some(&mut e.iterations), follows();
    /// Steps after which a run is given up.
    "max_steps": Count = Some(&mut e.max_steps);
}
