//! What a run is worth: an estimate of its error from a second, independent resolution, and whether its outcome depends on the last
//! digits of its input.
//!
//! A run of the analytic model is compared with one by the other family of methods (Rodas5P against Radau IIA) at a hundredth of its
//! tolerance; a run of the engine with the analytic model itself, or where there is none of the scene (beyond a fold of the linkage, rapier's
//! own contact, more discs than it takes) with the engine at a tenth of its tolerance and steps of at most a quarter. A comparison of two runs
//! of one method that took the same steps to the same digits says nothing. What drives the scene is changed by [`PUSH`] of itself to see
//! what such a change does.
//!
//! Compared are the path, the energies and works, and the restitution of discs.
//!
//! | file | job |
//! |---|---|
//! | `path` | a run kept as its path on an even grid, and differences of two |
//! | `runs` | the runs that are compared |
//! | `scale` | sizes of the scene and of its motion, of which bars are parts |
//! | `verdict` | what is said of a run, and why |

mod path;
mod runs;
mod scale;
mod verdict;

pub use path::Errors;
use path::Path;
pub use runs::pushed;
use runs::{Way, is_comparable, run, words};
pub use scale::{CHAOTIC, MOTION_PART, length_m, units};
pub use verdict::Verdict;
use verdict::{Compared, verdict};

use crate::scene::Scene;
use crate::trace::{Model, Sink};

/// Relative change of what drives a scene: motor torques, or velocities and gravity of discs.
pub const PUSH: f64 = 1e-7;
/// The radius of the usual object: the length by which comparisons of both models measure centres beside angles.
pub const LENGTH_M: f64 = 0.02;
/// A run is uncertain if the error of its path is estimated to be larger, of the analytic model and of the engine: in rad, for a gripper's
/// object in its radii, for discs alone in 20 radii of the smallest that moves; and at most [`MOTION_PART`] of the largest displacement.
pub const BAR: f64 = 1e-5;
pub const ENGINE_BAR: f64 = 1e-4;
/// The same for energies and works, as parts of the energy exchanged in the run. Of 560 random fingers, grippers and discs (analytic
/// model) and 570 (engine) the largest errors of paths that are right were 3e-4 and 6e-3, bar one of the engine with 1.3e-2.
pub const ENERGY_BAR: f64 = 1e-3;
pub const ENGINE_ENERGY_BAR: f64 = 1e-2;
/// The same for the restitution of discs that meet at the largest speed of a run.
pub const RESTITUTION_BAR: f64 = 1e-3;
pub const ENGINE_RESTITUTION_BAR: f64 = 1e-2;
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

/// What a check found.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    pub verdict: Verdict,
    pub errors: Errors,
    /// Largest change of the path by a push, rad (discs: m).
    pub sensitivity: f64,
    /// The error of the path from which on a run is uncertain, rad (discs: m), and what it is a part of.
    pub bar: f64,
    pub bar_of: String,
    /// The largest displacement along the path, where the bar is a part of that because it is small.
    pub motion: Option<f64>,
    /// The error of energies from which on a run is uncertain, as a part of the energy exchanged.
    pub energy_bar: f64,
    /// What the run was compared with, in words.
    pub against: String,
    /// Why the verdict is what it is, where figures do not say it.
    pub reason: Option<String>,
}

impl Check {
    /// Of a run with nothing to compare: errors are unknown.
    fn unknown(model: Model, reason: String) -> Self {
        let errors = Errors { path: f64::INFINITY, energy: f64::INFINITY, ..Errors::default() };
        let (bar, energy_bar) = bars(model, 0);
        Check {
            verdict: Verdict::Unknown,
            errors,
            sensitivity: f64::INFINITY,
            bar,
            bar_of: String::new(),
            motion: None,
            energy_bar,
            against: String::new(),
            reason: Some(reason),
        }
    }

    /// Of a run that was not completed: it has no verdict.
    pub fn not_completed(model: Model, time_s: f64, reason: &str) -> Self {
        Self::unknown(model, format!("the run ended at {:.6} ms because: {reason}", time_s * 1e3))
    }
}

/// Bars of the path and of energies.
fn bars(model: Model, events: u64) -> (f64, f64) {
    match model {
        Model::Engine => (ENGINE_BAR, ENGINE_ENERGY_BAR),
        Model::Analytic if events > MANY_EVENTS => (MANY_EVENTS_BAR, ENERGY_BAR),
        Model::Analytic => (BAR, ENERGY_BAR),
    }
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
    let way = Way { finer: false, push: 0.0, span_s: scene.duration_s, energies: true, budget: u64::MAX, go_on };
    let own = run(scene, model, &way, &mut ());
    if let Some(reason) = &own.failure {
        return Check::not_completed(model, own.end_s, &reason.to_string());
    }
    // An object that leaves the gripper after a microsecond is compared along that microsecond.
    let span_s = if own.ejected { own.end_s } else { scene.duration_s };
    let own = if span_s < scene.duration_s { run(scene, model, &Way { span_s, ..way }, &mut ()) } else { own };
    let finer = Way { finer: true, span_s, budget: STEPS_PER_STEP * own.steps + BESIDE, ..way };
    let analytic =
        (model == Model::Analytic || is_comparable(scene)).then(|| run(scene, Model::Analytic, &finer, held_to));
    // The analytic model speaks for the engine as far as it gets; beyond, the engine itself does.
    let as_far =
        if model == Model::Engine { analytic.as_ref().map_or(0.0, |path| path::difference(&own, path)) } else { 0.0 };
    let speaks = |path: &Path| model == Model::Analytic || path.failure.is_none();
    let (second, judge) = match analytic.filter(speaks) {
        Some(analytic) => (analytic, Model::Analytic),
        None => (run(scene, Model::Engine, &finer, held_to), Model::Engine),
    };
    let pushed = run(scene, judge, &Way { push: PUSH, energies: false, ..finer }, pushed);
    let (ordinary, energy_bar) = bars(model, own.events);
    let bar = scale::bar(&scene.system, &own, ordinary);
    let mut errors = path::errors(&own, &second);
    errors.path = errors.path.max(as_far);
    let sensitivity = path::difference(&second, &pushed);
    let (verdict, reason) = verdict(&Compared {
        run: &own,
        second: &second,
        pushed: &pushed,
        errors: &errors,
        sensitivity,
        chaotic: bar.chaotic,
        bar: bar.error,
        energy_bar,
        restitution_bar: if model == Model::Engine { ENGINE_RESTITUTION_BAR } else { RESTITUTION_BAR },
        gap_bar_m: ENGINE_BAR * scene.system.shortest_link_m(),
        // The analytic model is checked by another method, the engine by the analytic model or by itself.
        same_method: judge == Model::Engine,
    });
    if verdict == Verdict::Unknown {
        return Check { against: words(scene, judge), ..Check::unknown(model, reason.unwrap_or_default()) };
    }
    let scale::Bar { error: bar, of: bar_of, motion, .. } = bar;
    Check { verdict, errors, sensitivity, bar, bar_of, motion, energy_bar, against: words(scene, judge), reason }
}
