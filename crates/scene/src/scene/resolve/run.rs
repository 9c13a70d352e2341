//! Settings of the run, and their relations to the rest of the scene.

use std::ops::Range;

use super::super::check::Checker;
use super::super::keywords::SceneKind;
use super::super::table::SettingsSection;
use super::super::table::input::SectionInput;
use super::super::table::read;
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

/// Resolves the settings of the run. `system` and `duration_s` are `None` if they are invalid. The default friction of
/// rapier's contact is the static friction of the scene's contact law.
pub fn run(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    system: Option<&System>,
    duration_s: Option<f64>,
) -> Run {
    let mu_static = system.and_then(system::mu_static);
    let integrator =
        read(checker, "integrator", &input.subsection("integrator"), Integrator::engineering_for(input.kind));
    let mut engine = engine(checker, &input.subsection("engine"), mu_static);
    if let Some(system) = system {
        adapt_tolerance(&mut engine, &input.subsection("engine"), system);
    }
    let bounds = bounds(checker, &input.subsection("validate"), duration_s);
    let thresholds = thresholds(checker, &input.subsection("criteria"), system, duration_s);
    Run { integrator, engine, bounds, thresholds, log: log(checker, &input.subsection("log"), duration_s) }
}

/// Resolves the settings of the engine model.
fn engine(checker: &mut Checker<'_>, input: &SectionInput<'_>, mu_static: Option<f64>) -> Engine {
    let mut engine = read(checker, "engine", input, Engine::DEFAULT);
    if let (Response::Rapier { friction, .. }, Some(mu_static), None) =
        (&mut engine.response, mu_static, input.get("friction"))
    {
        *friction = mu_static;
    }
    if engine.construction == Construction::Reduced && input.kind != SceneKind::Finger {
        let (reason, label) = match input.kind {
            SceneKind::Bodies => ("a scene of discs has no joints", "no joints"),
            _ => ("joint coordinates are supported for one finger only", "one finger only"),
        };
        let what = if input.kind == SceneKind::Bodies { "disc" } else { "body" };
        checker.push(
            input.span("construction"),
            format!("`engine.construction` is \"reduced\", but {reason}"),
            label,
            format!("remove it: every {what} then has its own coordinates"),
        );
    }
    engine
}

/// For links shorter than this, m, the default tolerance of steps is proportional to their length: the error of angles
/// is the tolerance divided by the length.
const SHORT_LINK_M: f64 = 2.5e-3;

/// Adapts the default tolerance of the engine's steps to the shortest link.
fn adapt_tolerance(engine: &mut Engine, input: &SectionInput<'_>, system: &System) {
    let shortest_m = SHORT_LINK_M.min(system.shortest_link_m());
    if let (Stepping::Adaptive { tolerance_m, .. }, None) = (&mut engine.stepping, input.get("tolerance")) {
        *tolerance_m *= shortest_m / SHORT_LINK_M;
    }
}

/// Resolves the tolerances of the validation; only the end of the comparison depends on the duration.
fn bounds(checker: &mut Checker<'_>, input: &SectionInput<'_>, duration_s: Option<f64>) -> Bounds {
    let defaults = Bounds::defaults_for_run(input.kind, duration_s.unwrap_or(defaults::DURATION_S));
    let bounds = read(checker, "validate", input, defaults);
    let help = "lower it, raise `duration`, or remove it (default: the duration)";
    within_duration(checker, (input.span("until"), "validate.until"), bounds.until_s, duration_s, help);
    bounds
}

/// Resolves the thresholds of the grasp criteria of a gripper.
fn thresholds(
    checker: &mut Checker<'_>,
    input: &SectionInput<'_>,
    system: Option<&System>,
    duration_s: Option<f64>,
) -> Thresholds {
    let motor_force_n = system.map_or(0.0, System::motor_force_n);
    let defaults = match input.kind {
        SceneKind::Gripper => Thresholds::defaults_for_run(duration_s.unwrap_or(defaults::DURATION_S), motor_force_n),
        SceneKind::Finger | SceneKind::Bodies => Thresholds::NONE,
    };
    let thresholds = read(checker, "criteria", input, defaults);
    let help = "lower it, raise `duration`, or remove it";
    within_duration(checker, (input.span("loss_time"), "criteria.loss_time"), thresholds.loss_time_s, duration_s, help);
    within_duration(checker, (input.span("held_time"), "criteria.held_time"), thresholds.held_time_s, duration_s, help);
    thresholds
}

/// Reports a time that is longer than the run.
fn within_duration(
    checker: &mut Checker<'_>,
    (span, key): (Option<Range<usize>>, &str),
    time_s: f64,
    duration_s: Option<f64>,
    help: &str,
) {
    let Some(duration_s) = duration_s.filter(|duration_s| time_s > *duration_s) else { return };
    let (time, duration) = (format(time_s, Dimension::Time), format(duration_s, Dimension::Time));
    checker.push(
        span,
        format!("`{key}` is {time}, but must be at most the duration of {duration}"),
        "after the end",
        help,
    );
}

/// Resolves the rates of the log and checks their limits.
fn log(checker: &mut Checker<'_>, input: &SectionInput<'_>, duration_s: Option<f64>) -> LogRates {
    let rates = read(checker, "log", input, LogRates::defaults());
    if let Some(excess) = duration_s.and_then(|duration_s| rates.excess(duration_s)) {
        let span = input.span(if excess.pictures { "picture_rate" } else { "numeric_rate" });
        let help = format!("write `{}` in [log], or shorten the run", excess.suggestion());
        checker.push(span, excess.to_string(), "too many", help);
    }
    rates
}
