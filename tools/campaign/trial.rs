//! Runs one scene with all settings and compares the results.

use std::fmt;
use std::time::Instant;

use phalanx::check::check;
use phalanx::scene::Scene;
use phalanx::trace::Model;

use super::record::{MAX_WALL_TIME, Run, Setting, difference, have_same_end, record};

/// Largest accepted errors along the path, in rad or relative to the unit of the coordinate.
pub const MAX_PRESET_ERROR: f64 = 1e-5;
pub const MAX_ENGINE_ERROR: f64 = 1e-3;
pub const MAX_REFERENCE_DIFFERENCE: f64 = 1e-7;
/// A scene is chaotic if this relative change of its drives changes its path by more than [`CHAOTIC_DIFFERENCE`].
const PERTURBATION: f64 = 1e-7;
const CHAOTIC_DIFFERENCE: f64 = 1e-3;
/// A difference is attributed to the sensitivity of the scene if it is at most this multiple of the effect of the
/// perturbation.
const MAX_AMPLIFICATION: f64 = 10.0;
const MAX_ENGINE_AMPLIFICATION: f64 = 100.0;
/// Step limit of a reference run, some 5 s on an idle core. Unlike time, steps do not depend on the load of the machine.
const MAX_REFERENCE_STEPS: u64 = 800_000;

/// Errors of the runs of a scene against its reference.
#[derive(Clone, Debug)]
pub struct Trial {
    pub reference: Run,
    pub preset: Run,
    pub engine: Option<Run>,
    /// Effect of the perturbation on the reference.
    pub perturbation: f64,
    /// Difference between the two references.
    pub second: f64,
    pub error: f64,
    pub engine_error: f64,
    /// Verdicts of `check` on the runs of the program.
    pub analytic_verdict: &'static str,
    pub engine_verdict: &'static str,
    pub verdicts: Vec<Verdict>,
}

/// Finding about a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    Chaotic,
    ReferenceSlow,
    ReferenceFailed,
    ReferencesDisagree,
    PresetInaccurate,
    PresetVeryInaccurate,
    PresetEndsDifferently,
    PresetErrorUnreported,
    PresetFalseAlarm,
    EngineErrorUnreported,
    EngineFalseAlarm,
    EngineInaccurate,
    EngineAboveTenth,
    EngineEndsEarly,
    PresetFailed,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Verdict::Chaotic => "chaotic: a perturbation of 1e-7 changes the reference by more than 1e-3",
            Verdict::ReferenceSlow => "reference takes more than 800,000 steps, some 5 s",
            Verdict::ReferenceFailed => "reference fails, but not at a fold",
            Verdict::ReferencesDisagree => "two references differ by more than 1e-7",
            Verdict::PresetInaccurate => "default run has an error above 1e-5",
            Verdict::PresetVeryInaccurate => "default run has an error above 1e-3",
            Verdict::PresetEndsDifferently => "default run ends differently from the reference",
            Verdict::PresetErrorUnreported => {
                "default run has an error above 1e-5 or is chaotic, but its check reports \"sure\""
            }
            Verdict::PresetFalseAlarm => "default run is accurate, but its check reports an error",
            Verdict::EngineErrorUnreported => {
                "engine has an error above 1e-4 or is chaotic, but its check reports \"sure\""
            }
            Verdict::EngineFalseAlarm => "engine is accurate, but its check reports an error",
            Verdict::EngineInaccurate => "engine has an error above 1e-3",
            Verdict::EngineAboveTenth => "engine has an error above 1e-4",
            Verdict::EngineEndsEarly => "engine ends early",
            Verdict::PresetFailed => "default run fails, but not at a fold",
        })
    }
}

/// Returns whether a run is complete or ends at a fold of the linkage.
fn ends_at_fold(run: &Run) -> bool {
    run.failure.as_ref().is_none_or(|reason| reason.contains("singular") || reason.contains("same centre"))
}

/// Returns the verdict of `check`, and whether it reports an error of the path; energies and restitution are not compared.
fn run_check(scene: &Scene, model: Model) -> (&'static str, bool) {
    let deadline = Instant::now() + MAX_WALL_TIME;
    let keep_running = || Instant::now() < deadline;
    let report = check(model, scene, &keep_running);
    let name = report.verdict.name();
    (name, name == "chaotic" || name == "uncertain" && report.errors.path > report.max_path_error)
}

/// Runs a scene with all settings.
pub fn run_trial(scene: &Scene, engine: bool) -> Trial {
    let reference = record(scene, Setting::Reference, 0.0);
    let preset = record(scene, Setting::Default, 0.0);
    let is_slow = reference.steps > MAX_REFERENCE_STEPS;
    let perturbed = record(scene, Setting::Reference, PERTURBATION);
    let second_run = record(scene, Setting::SecondMethod, 0.0);
    let engine = engine.then(|| record(scene, Setting::Engine, 0.0));
    let perturbation = difference(&reference, &perturbed);
    let second = difference(&reference, &second_run);
    let error = difference(&reference, &preset);
    let engine_error = engine.as_ref().map_or(0.0, |run| difference(&reference, run));
    let mut verdicts = Vec::new();
    let mut add_if = |condition: bool, verdict: Verdict| {
        if condition {
            verdicts.push(verdict);
        }
    };
    let is_chaotic = perturbation > CHAOTIC_DIFFERENCE || !have_same_end(&reference, &perturbed);
    let exceeds = |error: f64, limit: f64, amplification: f64| error > limit && error > amplification * perturbation;
    add_if(is_chaotic, Verdict::Chaotic);
    add_if(is_slow, Verdict::ReferenceSlow);
    add_if(!ends_at_fold(&reference), Verdict::ReferenceFailed);
    add_if(!ends_at_fold(&preset), Verdict::PresetFailed);
    if !is_chaotic {
        add_if(exceeds(second, MAX_REFERENCE_DIFFERENCE, MAX_AMPLIFICATION) && !is_slow, Verdict::ReferencesDisagree);
        add_if(exceeds(error, MAX_PRESET_ERROR, MAX_AMPLIFICATION), Verdict::PresetInaccurate);
        add_if(exceeds(error, 1e-3, MAX_AMPLIFICATION), Verdict::PresetVeryInaccurate);
        add_if(!have_same_end(&reference, &preset), Verdict::PresetEndsDifferently);
        if let Some(engine) = &engine {
            // The engine continues past a fold; it is compared with the reference up to there.
            add_if(exceeds(engine_error, MAX_ENGINE_ERROR, MAX_ENGINE_AMPLIFICATION), Verdict::EngineInaccurate);
            add_if(exceeds(engine_error, 0.1 * MAX_ENGINE_ERROR, MAX_ENGINE_AMPLIFICATION), Verdict::EngineAboveTenth);
            add_if(engine.failure.is_some() && engine.end_s < 0.999 * reference.end_s, Verdict::EngineEndsEarly);
        }
    }
    let (analytic_verdict, reports_error) = run_check(scene, Model::Analytic);
    let (engine_verdict, engine_reports_error) =
        engine.as_ref().map_or(("", false), |_| run_check(scene, Model::Engine));
    let is_inaccurate = |error: f64, limit: f64, amplification: f64| is_chaotic || exceeds(error, limit, amplification);
    add_if(
        is_inaccurate(error, MAX_PRESET_ERROR, MAX_AMPLIFICATION) && analytic_verdict == "sure",
        Verdict::PresetErrorUnreported,
    );
    add_if(
        !is_chaotic && error <= 0.5 * MAX_PRESET_ERROR && have_same_end(&reference, &preset) && reports_error,
        Verdict::PresetFalseAlarm,
    );
    if let Some(engine) = &engine {
        add_if(
            is_inaccurate(engine_error, 0.1 * MAX_ENGINE_ERROR, MAX_ENGINE_AMPLIFICATION) && engine_verdict == "sure",
            Verdict::EngineErrorUnreported,
        );
        let is_accurate = engine_error <= 0.05 * MAX_ENGINE_ERROR && have_same_end(&reference, engine);
        add_if(!is_chaotic && is_accurate && engine_reports_error, Verdict::EngineFalseAlarm);
    }
    Trial {
        analytic_verdict,
        engine_verdict,
        reference,
        preset,
        engine,
        perturbation,
        second,
        error,
        engine_error,
        verdicts,
    }
}
