//! `[engine]`: construction, contact law and stepping of the engine model.

use super::{settings, variant_field};
use crate::scene::check::{Bound, NOT_NEGATIVE, POSITIVE};
use crate::scene::table::integrator::MAX_STEPS;
use crate::scene::value_kinds::{Choice, Count, Keyword, Length, Number, SweepCount, Time};

/// Settings of the engine model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Engine {
    pub construction: Construction,
    pub response: Response,
    pub stepping: Stepping,
    /// Sweeps of rapier's projected Gauss–Seidel solver over the joints, per step.
    pub iterations: u32,
    /// Step budget; a run that needs more steps ends with an error, and its log is kept.
    pub max_steps: u64,
}

/// Coordinates of the engine model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Construction {
    /// Three coordinates per body; every joint is a constraint between two bodies. Second-order accurate.
    Maximal,
    /// Joint coordinates of a tree of bodies; one constraint closes the loop. First-order accurate.
    Reduced,
}

/// Contact forces of the engine model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Response {
    /// The scene's contact laws, applied through the engine's contact-force hook.
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
    /// Steps in which no joint deviates by more than `tolerance_m` from its circular path; shorter around impacts.
    Adaptive {
        tolerance_m: f64,
        max_step_s: f64,
    },
}

pub const ENGINE_MAX_STEP_S: f64 = 6e-5;

const ADAPTIVE: Stepping = Stepping::Adaptive { tolerance_m: 1e-7, max_step_s: ENGINE_MAX_STEP_S };
/// The scene must set the step.
const FIXED: Stepping = Stepping::Fixed { step_s: f64::NAN };
/// The default friction is that of the contact.
const RAPIER: Response = Response::Rapier { friction: f64::NAN, restitution: 0.0 };

impl Keyword for Construction {
    const KEYWORDS: &'static [(&'static str, Self)] =
        &[("maximal", Construction::Maximal), ("reduced", Construction::Reduced)];
}

impl Keyword for Response {
    const KEYWORDS: &'static [(&'static str, Self)] = &[("scene", Response::Laws), ("rapier", RAPIER)];
}

impl Keyword for Stepping {
    const KEYWORDS: &'static [(&'static str, Self)] = &[("adaptive", ADAPTIVE), ("fixed", FIXED)];
}

impl Engine {
    pub const DEFAULT: Self = Self {
        construction: Construction::Maximal,
        response: Response::Laws,
        stepping: ADAPTIVE,
        iterations: Self::default_iterations(Response::Laws),
        max_steps: MAX_STEPS,
    };

    /// Whether contacts follow the laws of the scene, as in the analytic model.
    pub fn uses_laws(&self) -> bool {
        self.response == Response::Laws
    }

    /// Default number of joint sweeps. With the contact laws of the scene, the engine passes the joint reactions to
    /// rapier, and the sweeps only confirm them; with rapier's contact, the sweeps must propagate the impulses through
    /// the linkage.
    pub const fn default_iterations(response: Response) -> u32 {
        match response {
            Response::Laws => 2,
            Response::Rapier { .. } => 50,
        }
    }
}

const RESTITUTION: Bound = Bound { allowed: |x| (0.0..=1.0).contains(&x), text: "from 0 to 1" };

settings! {
    /// Construction, contact law and stepping of the engine model.
    Engine = Self::DEFAULT, e;
    /// "maximal": every body moves freely, and every joint is a constraint; "reduced": a tree of joints in joint
    /// coordinates, closed by one constraint (for a single finger only).
    "construction": Choice<Construction> = Some(&mut e.construction);
    /// Contact law: "scene": the laws of [contact]; "rapier": rapier's own rigid contact.
    "law": Choice<Response> = Some(&mut e.response),
        set_with(|e, response| (e.response, e.iterations) = (response, Self::default_iterations(response)));
    /// Coefficient of rapier's Coulomb friction (law = "rapier"). Default: mu_static of the contact (of the proximal
    /// contact of a finger).
    "friction": Number = variant_field!(e.response, Response::Rapier, friction),
        allowed(NOT_NEGATIVE), depends_on("law", "without law = \"rapier\"");
    /// Coefficient of rapier's Newton restitution, 0 to 1 (law = "rapier").
    "restitution": Number = variant_field!(e.response, Response::Rapier, restitution),
        allowed(RESTITUTION), depends_on("law", "without law = \"rapier\"");
    /// "adaptive": steps limited by `tolerance`, shorter around impacts; "fixed": all steps of size `step`.
    "stepping": Choice<Stepping> = Some(&mut e.stepping);
    /// Step size. Required with stepping = "fixed", not allowed otherwise.
    "step": Time = variant_field!(e.stepping, Stepping::Fixed, step_s),
        allowed(POSITIVE), depends_on("stepping", "without stepping = \"fixed\""),
        required("add the step size: step = \"10 us\"; or use stepping = \"adaptive\"");
    /// Largest deviation of a joint from its circular path in one step, in which bodies move along straight lines
    /// (stepping = "adaptive"). The default is proportionally smaller if the shortest link is shorter than 2.5 mm.
    "tolerance": Length = variant_field!(e.stepping, Stepping::Adaptive, tolerance_m),
        allowed(POSITIVE), depends_on("stepping", "with stepping = \"fixed\""), default_text("1e-4 mm");
    /// Longest step (stepping = "adaptive").
    "max_step": Time = variant_field!(e.stepping, Stepping::Adaptive, max_step_s),
        allowed(POSITIVE), depends_on("stepping", "with stepping = \"fixed\"");
    /// Sweeps of rapier's joint solver in every step. Default: 2, or 50 with law = "rapier".
    "iterations": SweepCount = Some(&mut e.iterations), derived();
    /// Maximum number of steps of a run.
    "max_steps": Count = Some(&mut e.max_steps);
}
