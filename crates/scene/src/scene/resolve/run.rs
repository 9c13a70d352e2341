//! How a scene is run: what its settings have to do with the rest of it.

use std::ops::Range;

use super::super::check::Checker;
use super::super::entry::Section;
use super::super::table::Table;
use super::super::table::bounds::Said;
use super::super::table::keys::Keys;
use super::super::table::read;
use super::super::{Bounds, Engine, LogRates, Response, defaults};
use crate::units::{Dimension, format};

/// The engine model; rapier's friction is `mu_static`, that of the scene's contact, unless given.
pub fn engine(c: &mut Checker<'_>, raw: &Section<Keys<Engine>>, mu_static: Option<f64>) -> Engine {
    let mut engine = read(c, "engine", raw, Engine::DEFAULT);
    if let (Response::Rapier { friction, .. }, Some(mu_static), None) =
        (&mut engine.response, mu_static, raw.get("friction"))
    {
        *friction = mu_static;
    }
    engine
}

/// Bounds of the validation, judged even where the duration is wrong (`None`): only the end of the comparison needs it.
pub fn bounds<T: Said>(c: &mut Checker<'_>, raw: &Section<Keys<T>>, duration_s: Option<f64>) -> Bounds {
    let usual = Bounds::over(T::KIND, duration_s.unwrap_or(defaults::DURATION_S));
    let bounds = read(c, "validate", raw, T::from(usual)).bounds();
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
pub fn log(c: &mut Checker<'_>, raw: &Section<Keys<LogRates>>, duration_s: Option<f64>) -> LogRates {
    let rates = read(c, "log", raw, LogRates::usual());
    if let Some(excess) = duration_s.and_then(|duration_s| rates.excess(duration_s)) {
        let span = raw.span(if excess.pictures { "picture_rate" } else { "numeric_rate" });
        let help = format!("say `{}` in [log], or shorten the run", excess.remedy());
        c.push(span, excess.to_string(), "too many", help);
    }
    rates
}
