//! The engine model, and how far it may be from the analytic one.

use super::super::check::{Bound, Checker, NOT_NEGATIVE, POSITIVE};
use super::super::entry::{Entry, Section};
use super::super::kinds::Time;
use super::super::raw::{RawEngine, RawValidate};
use super::super::raw_bodies::RawBodiesValidate;
use super::super::words::{EngineLaw, StepSizes};
use super::super::{BodiesBounds, Bounds, Engine, Response, Stepping, defaults};
use crate::units::{Dimension, format};

const RESTITUTION: Bound = Bound { allowed: |x| (0.0..=1.0).contains(&x), text: "from 0 to 1" };

/// The engine model; rapier's friction is `mu_static`, that of the scene's contact, unless given.
pub fn engine(c: &mut Checker<'_>, raw: &Section<RawEngine>, mu_static: Option<f64>) -> Option<Engine> {
    let base = Engine::DEFAULT;
    let construction = c.or("engine.construction", &raw.construction, base.construction);
    let response = response(c, raw, mu_static);
    let stepping = stepping(c, raw);
    let usual = response.map_or(base.iterations, Engine::usual_iterations);
    let iterations = c.or("engine.iterations", &raw.iterations, usual);
    let max_steps = c.or("engine.max_steps", &raw.max_steps, base.max_steps);
    Some(Engine { construction, response: response?, stepping: stepping?, iterations, max_steps })
}

fn response(c: &mut Checker<'_>, raw: &RawEngine, mu_static: Option<f64>) -> Option<Response> {
    // An unknown law says nothing about the other keys.
    let law = match raw.law.is_given() {
        true => c.get("engine.law", &raw.law)?,
        false => EngineLaw::Scene,
    };
    match law {
        EngineLaw::Scene => {
            c.unused("engine.friction", &raw.friction, "without law = \"rapier\"");
            c.unused("engine.restitution", &raw.restitution, "without law = \"rapier\"");
            Some(Response::Laws)
        }
        EngineLaw::Rapier => {
            let friction = c.number("engine.friction", &raw.friction, NOT_NEGATIVE);
            let restitution = c.number_or("engine.restitution", &raw.restitution, RESTITUTION, 0.0);
            Some(Response::Rapier { friction: friction.or(mu_static)?, restitution })
        }
    }
}

fn stepping(c: &mut Checker<'_>, raw: &Section<RawEngine>) -> Option<Stepping> {
    // As with the law.
    let sizes = match raw.stepping.is_given() {
        true => c.get("engine.stepping", &raw.stepping)?,
        false => StepSizes::Adaptive,
    };
    match sizes {
        StepSizes::Adaptive => {
            c.unused("engine.step", &raw.step, "without stepping = \"fixed\"");
            let tolerance_m = c.number_or("engine.tolerance", &raw.tolerance, POSITIVE, defaults::ENGINE_TOLERANCE_M);
            let max_step_s = c.number_or("engine.max_step", &raw.max_step, POSITIVE, defaults::ENGINE_MAX_STEP_S);
            Some(Stepping::Adaptive { tolerance_m, max_step_s })
        }
        StepSizes::Fixed => {
            c.unused("engine.tolerance", &raw.tolerance, "with stepping = \"fixed\"");
            c.unused("engine.max_step", &raw.max_step, "with stepping = \"fixed\"");
            let help =
                "add the size of the steps: step = \"10 us\"; or leave it to the engine: stepping = \"adaptive\"";
            let step = c.required("engine.step", &raw.step, POSITIVE, raw, help);
            Some(Stepping::Fixed { step_s: step? })
        }
    }
}

/// Bounds of the validation, judged even where the duration is wrong (`None`): only the end of the comparison needs it.
pub fn bounds(c: &mut Checker<'_>, raw: &RawValidate, duration_s: Option<f64>) -> Bounds {
    let until_s = until(c, &raw.until, duration_s);
    let base = Bounds::over(until_s);
    Bounds {
        angle_rad: c.number_or("validate.angle", &raw.angle, POSITIVE, base.angle_rad),
        contact_time_s: c.number_or("validate.contact_time", &raw.contact_time, POSITIVE, base.contact_time_s),
        final_force: c.number_or("validate.final_force", &raw.final_force, POSITIVE, base.final_force),
        impulse: c.number_or("validate.impulse", &raw.impulse, POSITIVE, base.impulse),
        loop_gap_m: c.number_or("validate.loop_gap", &raw.loop_gap, POSITIVE, base.loop_gap_m),
        until_s,
    }
}

/// The same for a scene of discs.
pub fn bodies_bounds(c: &mut Checker<'_>, raw: &RawBodiesValidate, duration_s: Option<f64>) -> BodiesBounds {
    let until_s = until(c, &raw.until, duration_s);
    let base = BodiesBounds::over(until_s);
    BodiesBounds {
        position_m: c.number_or("validate.position", &raw.position, POSITIVE, base.position_m),
        contact_time_s: c.number_or("validate.contact_time", &raw.contact_time, POSITIVE, base.contact_time_s),
        impulse: c.number_or("validate.impulse", &raw.impulse, POSITIVE, base.impulse),
        peak_force: c.number_or("validate.peak_force", &raw.peak_force, POSITIVE, base.peak_force),
        until_s,
    }
}

/// End of the comparison.
fn until(c: &mut Checker<'_>, entry: &Entry<Time>, duration_s: Option<f64>) -> f64 {
    let until = c.number("validate.until", entry, POSITIVE);
    if let Some((until_s, duration_s)) = until.zip(duration_s)
        && until_s > duration_s
    {
        let (until, duration) = (format(until_s, Dimension::Time), format(duration_s, Dimension::Time));
        c.push(
            entry.span(),
            format!("`validate.until` is {until}, but must be at most the duration of {duration}"),
            "after the end",
            "lower it, raise `duration`, or leave it out: it is the duration then",
        );
    }
    until.or(duration_s).unwrap_or(defaults::DURATION_S)
}
