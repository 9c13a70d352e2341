//! How a scene is run: what its settings have to do with the rest of it.

use std::ops::Range;

use super::super::check::Checker;
use super::super::table::Table;
use super::super::table::keys::Keys;
use super::super::table::read;
use super::super::words::SceneKind;
use super::super::{
    Bounds, Construction, Engine, Integrator, LogRates, Response, Stepping, System, Thresholds, defaults,
};
use super::system;
use crate::units::{Dimension, format};

/// All settings of a run.
pub struct Run {
    pub integrator: Integrator,
    pub engine: Engine,
    pub bounds: Bounds,
    pub thresholds: Thresholds,
    pub log: LogRates,
}

/// Checks the settings even where the duration or the system is invalid (`None`). rapier's friction is that of the scene's contact unless
/// given.
pub fn run(c: &mut Checker<'_>, raw: &Keys<'_>, system: Option<&System>, duration_s: Option<f64>) -> Run {
    let mu_static = system.and_then(system::mu_static);
    let integrator = read(c, "integrator", &raw.inner("integrator"), Integrator::everyday(raw.kind));
    let mut engine = engine(c, &raw.inner("engine"), mu_static);
    if let Some(system) = system {
        suit_links(&mut engine, &raw.inner("engine"), system);
    }
    let bounds = bounds(c, &raw.inner("validate"), duration_s);
    let thresholds = thresholds(c, &raw.inner("criteria"), system, duration_s);
    Run { integrator, engine, bounds, thresholds, log: log(c, &raw.inner("log"), duration_s) }
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
fn suit_links(engine: &mut Engine, raw: &Keys<'_>, system: &System) {
    let shortest_m = SHORT_LINK_M.min(system.shortest_link_m());
    if let (Stepping::Adaptive { tolerance_m, .. }, None) = (&mut engine.stepping, raw.get("tolerance")) {
        *tolerance_m *= shortest_m / SHORT_LINK_M;
    }
}

/// Bounds of the validation: only the end of the comparison needs the duration.
fn bounds(c: &mut Checker<'_>, raw: &Keys<'_>, duration_s: Option<f64>) -> Bounds {
    let usual = Bounds::over(raw.kind, duration_s.unwrap_or(defaults::DURATION_S));
    let bounds = read(c, "validate", raw, usual);
    let help = "lower it, raise `duration`, or leave it out: it is the duration then";
    within_duration(c, (raw.span("until"), "validate.until"), bounds.until_s, duration_s, help);
    bounds
}

/// Thresholds of the grasp criteria, of a gripper.
fn thresholds(c: &mut Checker<'_>, raw: &Keys<'_>, system: Option<&System>, duration_s: Option<f64>) -> Thresholds {
    let motor_force_n = system.map_or(0.0, System::motor_force_n);
    let usual = match raw.kind {
        SceneKind::Gripper => Thresholds::of(duration_s.unwrap_or(defaults::DURATION_S), motor_force_n),
        SceneKind::Finger | SceneKind::Bodies => Thresholds::NONE,
    };
    let thresholds = read(c, "criteria", raw, usual);
    let help = "lower it, raise `duration`, or leave it out";
    within_duration(c, (raw.span("loss_time"), "criteria.loss_time"), thresholds.loss_time_s, duration_s, help);
    within_duration(c, (raw.span("held_time"), "criteria.held_time"), thresholds.held_time_s, duration_s, help);
    thresholds
}

/// Reports a time that is longer than the run.
fn within_duration(
    c: &mut Checker<'_>,
    (span, key): (Option<Range<usize>>, &str),
    time_s: f64,
    duration_s: Option<f64>,
    help: &str,
) {
    let Some(duration_s) = duration_s.filter(|duration_s| time_s > *duration_s) else { return };
    let (time, duration) = (format(time_s, Dimension::Time), format(duration_s, Dimension::Time));
    c.push(span, format!("`{key}` is {time}, but must be at most the duration of {duration}"), "after the end", help);
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
