//! What a run is worth: an estimate of its error from a second, independent resolution, and whether its outcome depends on the last
//! digits of its input.
//!
//! A run of the analytic model is held to one by the other family of methods (Rodas5P against Radau IIA) at a hundredth of its
//! tolerance; a run of the engine to the analytic model itself, or where there is none of the scene (beyond a fold of the linkage, rapier's own
//! contact, more discs than it takes) to the engine at a tenth of its tolerance or a quarter of its step. What drives the scene is
//! changed by [`PUSH`] of itself to see what such a change does.
//!
//! | file | job |
//! |---|---|
//! | `path` | a run kept as its path on an even grid, and differences of two |
//! | `runs` | the runs that are compared |

mod path;
mod runs;

use path::Path;
pub use path::{Errors, LENGTH_M};
pub use runs::pushed;
use runs::{Way, is_comparable, run, words};

use crate::integrator::Reason;
use crate::scene::Scene;
use crate::trace::{Model, Sink};

/// Relative change of what drives a scene: motor torques, or velocities and gravity of discs.
pub const PUSH: f64 = 1e-7;
/// A run is chaotic if the push moves its path by more than this, rad (discs: m).
pub const CHAOTIC: f64 = 1e-3;
/// A run is uncertain if its error is estimated to be larger, rad (discs: m): of the analytic model, and of the engine.
pub const BAR: f64 = 1e-5;
pub const ENGINE_BAR: f64 = 1e-4;
/// Through more events than this of the analytic model its estimate is one draw of what they make of last digits: of 9,542 random scenes the
/// four that were off by more than the bar (1.1e-5 to 2.6e-5 rad) and sure of it had 2,769 to 7,436, and estimates of 1.9e-6 to 9.7e-6…
const MANY_EVENTS: u64 = 1000;
/// …so such runs are held to this bar.
const MANY_EVENTS_BAR: f64 = 1e-6;
/// Steps a run may have to be checked without being asked to: at a few microseconds each the check then takes some tenths of a second.
pub const MOST_STEPS: u64 = 20_000;

/// Steps that each run of a check may take for each of the run itself, and beside: a finer run follows what trembles for some 30,000
/// steps before it lets it be damped (`integrator::pace`), and a check that broke off there would say nothing.
const STEPS_PER_STEP: u64 = 10;
const BESIDE: u64 = 50_000;

/// What is to be said of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Two resolutions agree.
    Sure,
    /// They do not: the outcome depends on the tolerance.
    Uncertain,
    /// The outcome depends on the last digits of the input.
    Chaotic,
    /// There is nothing to compare with.
    Unknown,
}

impl Verdict {
    /// In results, logs and reports.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Sure => "sure",
            Verdict::Uncertain => "uncertain",
            Verdict::Chaotic => "chaotic",
            Verdict::Unknown => "unknown",
        }
    }
}

/// What a check found.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    pub verdict: Verdict,
    pub errors: Errors,
    /// Largest change of the path by a push, rad (discs: m).
    pub sensitivity: f64,
    /// The error from which on a run is uncertain.
    pub bar: f64,
    /// What the run was held to, in words.
    pub against: String,
    /// Why the verdict is what it is, where figures do not say it.
    pub reason: Option<String>,
}

/// Checks a run by one of the models, as the scene says, while `go_on` says so.
pub fn check(model: Model, scene: &Scene, go_on: &dyn Fn() -> bool) -> Check {
    check_heard(model, scene, [&mut (), &mut ()], go_on)
}

/// The same, whose finer runs others hear too: the one that the run is held to, and the one that is pushed. They have no energies and
/// peaks. What takes an engine where the analytic model does not get to the end is heard as well, behind what that said.
pub fn check_heard(
    model: Model,
    scene: &Scene,
    [held_to, pushed]: [&mut dyn Sink; 2],
    go_on: &dyn Fn() -> bool,
) -> Check {
    let way = Way { finer: false, push: 0.0, budget: u64::MAX, go_on };
    let own = run(scene, model, &way, &mut ());
    let budget = Way { budget: STEPS_PER_STEP * own.steps + BESIDE, ..way };
    let finer = Way { finer: true, ..budget };
    let analytic =
        (model == Model::Analytic || is_comparable(scene)).then(|| run(scene, Model::Analytic, &finer, held_to));
    // The analytic model speaks for the engine as far as it gets; beyond, the engine itself does.
    let as_far =
        if model == Model::Engine { analytic.as_ref().map_or(0.0, |path| path::difference(&own, path)) } else { 0.0 };
    let speaks = |path: &Path| model == Model::Analytic || path.failure.is_none() || own.failure.is_some();
    let (second, judge) = match analytic.filter(speaks) {
        Some(analytic) => (analytic, Model::Analytic),
        None => (run(scene, Model::Engine, &finer, held_to), Model::Engine),
    };
    let pushed = run(scene, judge, &Way { push: PUSH, ..finer }, pushed);
    let bar = match model {
        Model::Engine => ENGINE_BAR,
        Model::Analytic if own.events > MANY_EVENTS => MANY_EVENTS_BAR,
        Model::Analytic => BAR,
    };
    let mut errors = path::errors(&own, &second);
    errors.path = errors.path.max(as_far);
    let sensitivity = path::difference(&second, &pushed);
    let (verdict, reason) = verdict(&own, &second, &pushed, errors.path, sensitivity, bar);
    Check { verdict, errors, sensitivity, bar, against: words(scene, judge), reason }
}

fn verdict(
    run: &Path,
    second: &Path,
    pushed: &Path,
    error: f64,
    sensitivity: f64,
    bar: f64,
) -> (Verdict, Option<String>) {
    let unchecked = [second, pushed].into_iter().filter_map(|path| path.failure.as_ref());
    let early = |reason: &&Reason| matches!(reason, Reason::Budget(_) | Reason::SubstepBudget { .. } | Reason::Stopped);
    let unchecked = unchecked.filter(early);
    if let Some(reason) = unchecked.map(ToString::to_string).next() {
        return (Verdict::Unknown, Some(format!("the run that was to check it did not get to its end: {reason}")));
    }
    let ends = |path: &Path| path.failure.as_ref().map_or("completed".to_string(), ToString::to_string);
    if sensitivity > CHAOTIC || !path::end_alike(second, pushed) {
        return (Verdict::Chaotic, None);
    }
    if !path::end_alike(run, second) {
        let reason = format!("the run that checks it ends at {:.6} ms: {}", second.end_s * 1e3, ends(second));
        return (Verdict::Uncertain, Some(reason));
    }
    (if error > bar { Verdict::Uncertain } else { Verdict::Sure }, None)
}
