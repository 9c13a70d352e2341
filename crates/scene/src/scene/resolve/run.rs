//! How a scene is run: what its settings have to do with the rest of it.

use std::ops::Range;

use super::super::check::Checker;
use super::super::table::Table;
use super::super::table::keys::Keys;
use super::super::table::read;
use super::super::words::SceneKind;
use super::super::{Bounds, Construction, Engine, Integrator, LogRates, Response, Stepping, System, defaults};
use crate::units::{Dimension, format};

/// All settings of a run.
pub struct Run {
    pub integrator: Integrator,
    pub engine: Engine,
    pub bounds: Bounds,
    pub log: LogRates,
}

/// Judged even where the duration is wrong (`None`). rapier's friction is `mu_static`, that of the scene's contact, unless given.
pub fn run(c: &mut Checker<'_>, raw: &Keys<'_>, mu_static: Option<f64>, duration_s: Option<f64>) -> Run {
    let integrator = read(c, "integrator", &raw.inner("integrator"), Integrator::everyday(raw.kind));
    let engine = engine(c, &raw.inner("engine"), mu_static);
    let bounds = bounds(c, &raw.inner("validate"), duration_s);
    Run { integrator, engine, bounds, log: log(c, &raw.inner("log"), duration_s) }
}

/// The engine model.
fn engine(c: &mut Checker<'_>, raw: &Keys<'_>, mu_static: Option<f64>) -> Engine {
    let mut engine = read(c, "engine", raw, Engine::DEFAULT);
    if let (Response::Rapier { friction, .. }, Some(mu_static), None) =
        (&mut engine.response, mu_static, raw.get("friction"))
    {
        *friction = mu_static;
    }
    if engine.construction == Construction::Reduced && raw.kind != SceneKind::Finger {
        let (why, label) = match raw.kind {
            SceneKind::Bodies => ("a scene of discs has no joints to make coordinates of", "no joints"),
            _ => ("joint coordinates are for one finger, not for grippers", "one finger only"),
        };
        let what = if raw.kind == SceneKind::Bodies { "disc" } else { "body" };
        c.push(
            raw.span("construction"),
            format!("`engine.construction` is \"reduced\", but {why}"),
            label,
            format!("leave it out: every {what} moves freely in the engine"),
        );
    }
    engine
}

/// Links shorter than this, m, are stepped with a tolerance in proportion unless the scene gives one: by a step's tolerance of a link
/// a hundredth as long, angles would go wrong a hundred times as fast.
const SHORT_LINK_M: f64 = 2.5e-3;

/// Makes the default tolerance of the engine's steps suit the shortest link.
pub fn suit_links(engine: &mut Engine, raw: &Keys<'_>, system: &System) {
    let lengths = system.fingers.iter().map(|finger| finger.linkage.lengths);
    let links = lengths.flat_map(|of| [of.l11_m, of.l12_m, of.l21_m, of.l22_m]);
    let shortest_m = links.fold(SHORT_LINK_M, f64::min);
    if let (Stepping::Adaptive { tolerance_m, .. }, None) = (&mut engine.stepping, raw.get("tolerance")) {
        *tolerance_m *= shortest_m / SHORT_LINK_M;
    }
}

/// Bounds of the validation: only the end of the comparison needs the duration.
fn bounds(c: &mut Checker<'_>, raw: &Keys<'_>, duration_s: Option<f64>) -> Bounds {
    let usual = Bounds::over(raw.kind, duration_s.unwrap_or(defaults::DURATION_S));
    let bounds = read(c, "validate", raw, usual);
    judge_until(c, raw.span("until"), bounds.until_s, duration_s);
    bounds
}

/// End of the comparison.
fn judge_until(c: &mut Checker<'_>, span: Option<Range<usize>>, until_s: f64, duration_s: Option<f64>) {
    let Some(duration_s) = duration_s.filter(|duration_s| until_s > *duration_s) else { return };
    let (until, duration) = (format(until_s, Dimension::Time), format(duration_s, Dimension::Time));
    c.push(
        span,
        format!("`validate.until` is {until}, but must be at most the duration of {duration}"),
        "after the end",
        "lower it, raise `duration`, or leave it out: it is the duration then",
    );
}

/// What is logged, and whether a log takes it.
fn log(c: &mut Checker<'_>, raw: &Keys<'_>, duration_s: Option<f64>) -> LogRates {
    let rates = read(c, "log", raw, LogRates::usual());
    if let Some(excess) = duration_s.and_then(|duration_s| rates.excess(duration_s)) {
        let span = raw.span(if excess.pictures { "picture_rate" } else { "numeric_rate" });
        let help = format!("say `{}` in [log], or shorten the run", excess.remedy());
        c.push(span, excess.to_string(), "too many", help);
    }
    rates
}
