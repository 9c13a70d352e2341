//! Runs one scene with all settings and compares the results.

use std::time::Instant;

use phalanx::check::{check_run, run_and_record};
use phalanx::integrator::Reason;
use phalanx::scene::{Keyword, Scene, SceneError};
use phalanx::trace::{Cancellable, Model};

use super::record::{MAX_WALL_TIME, Run, Setting, difference, have_same_end, peak_difference, record};

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
/// Relative difference of peak forces that counts.
const MAX_PEAK_DIFFERENCE: f64 = 0.02;
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
    /// Verdicts of `check` on the runs of the program; empty if there is none.
    pub analytic_verdict: &'static str,
    pub engine_verdict: &'static str,
    /// Whether a contact is deeper than the roundings of its outlines.
    pub is_deep: bool,
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
    PresetPeakUnreported,
    PresetFalseAlarm,
    EngineErrorUnreported,
    EngineFalseAlarm,
    EngineInaccurate,
    EngineAboveTenth,
    EngineEndsEarly,
    ModelsDiffer,
    PresetFailed,
    Unbalanced,
}

impl Verdict {
    pub fn text(self) -> &'static str {
        match self {
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
            Verdict::PresetPeakUnreported => {
                "default run has a peak force with an error above 2 %, but its check reports \"sure\""
            }
            Verdict::PresetFalseAlarm => "default run is accurate, but its check reports an error",
            Verdict::EngineErrorUnreported => {
                "engine has an error above 1e-4 or is chaotic, but its check reports \"sure\""
            }
            Verdict::EngineFalseAlarm => "engine is accurate, but its check reports an error",
            Verdict::EngineInaccurate => "engine has an error above 1e-3",
            Verdict::EngineAboveTenth => "engine has an error above 1e-4",
            Verdict::EngineEndsEarly => "engine ends early",
            Verdict::ModelsDiffer => "engine has an error above 1e-4, which a tenth of its tolerance does not halve",
            Verdict::PresetFailed => "default run fails, but not at a fold",
            Verdict::Unbalanced => "a run creates energy, or loses it without a cause",
        }
    }
}

/// Whether the refusal of a scene names a problem, its message, its remedy and its line.
pub fn is_explained(error: &SceneError, file: &str) -> bool {
    let problems = error.problems();
    let has_texts = problems.iter().all(|problem| !problem.message.is_empty() && !problem.help.is_empty());
    let has_line =
        problems.iter().all(|problem| problem.span.is_none()) || error.to_string().contains(&format!("{file}:"));
    !problems.is_empty() && has_texts && has_line
}

fn is_mechanism(scene: &Scene) -> bool {
    scene.kind.keyword() == "mechanism"
}

/// Returns whether a run is complete or ends at a fold of the linkage; that of a mechanism may end at any obstacle that it
/// names.
fn ends_at_fold(scene: &Scene, run: &Run) -> bool {
    run.failure.as_ref().is_none_or(|reason| match reason {
        Reason::Obstacle(reason) => {
            is_mechanism(scene) || reason.contains("singular") || reason.contains("same centre")
        }
        _ => false,
    })
}

/// What `check` says about a run with the settings of the scene.
#[derive(Default)]
struct Checked {
    verdict: &'static str,
    /// Whether it reports an error of the path; energies and restitution are not compared.
    reports_error: bool,
    /// Smallest error of free bodies of a mechanism that it reports, in the unit of the path; else 0.
    free_bodies_bar: f64,
    is_deep: bool,
    is_unbalanced: bool,
}

fn run_check(scene: &Scene, model: Model) -> Checked {
    let deadline = Instant::now() + MAX_WALL_TIME;
    let keep_running = &|| Instant::now() < deadline;
    let (_, path) = run_and_record(model, scene, &mut Cancellable { sink: &mut (), keep_running });
    let is_deep = path.deep_contact.is_some();
    let is_unbalanced = path.audit.is_some_and(|audit| audit.violation().is_some());
    let report = check_run(model, scene, path, keep_running);
    let verdict = report.verdict.name();
    let reports_error = verdict == "chaotic" || verdict == "uncertain" && report.errors.path > report.max_path_error;
    let free_bodies_bar = if is_mechanism(scene) && !scene.has_joints() { report.max_path_error } else { 0.0 };
    Checked { verdict, reports_error, free_bodies_bar, is_deep, is_unbalanced }
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
    let checked = run_check(scene, Model::Analytic);
    let engine_checked = engine.as_ref().map_or_else(Checked::default, |_| run_check(scene, Model::Engine));
    let max_preset_error = MAX_PRESET_ERROR.max(checked.free_bodies_bar);
    let max_engine_error = (0.1 * MAX_ENGINE_ERROR).max(engine_checked.free_bodies_bar);
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
    add_if(!ends_at_fold(scene, &reference), Verdict::ReferenceFailed);
    add_if(!ends_at_fold(scene, &preset), Verdict::PresetFailed);
    if !is_chaotic {
        add_if(exceeds(second, MAX_REFERENCE_DIFFERENCE, MAX_AMPLIFICATION) && !is_slow, Verdict::ReferencesDisagree);
        add_if(exceeds(error, max_preset_error, MAX_AMPLIFICATION), Verdict::PresetInaccurate);
        add_if(exceeds(error, 1e-3, MAX_AMPLIFICATION), Verdict::PresetVeryInaccurate);
        add_if(!have_same_end(&reference, &preset), Verdict::PresetEndsDifferently);
        if let Some(engine) = &engine {
            // The engine continues past a fold; it is compared with the reference up to there.
            add_if(exceeds(engine_error, MAX_ENGINE_ERROR, MAX_ENGINE_AMPLIFICATION), Verdict::EngineInaccurate);
            let is_above_tenth = exceeds(engine_error, max_engine_error, MAX_ENGINE_AMPLIFICATION);
            add_if(is_above_tenth, Verdict::EngineAboveTenth);
            if is_above_tenth {
                let finer = record(scene, Setting::EngineTolerance(0.1), 0.0);
                add_if(difference(&reference, &finer) > 0.5 * engine_error, Verdict::ModelsDiffer);
            }
            add_if(engine.failure.is_some() && engine.end_s < 0.999 * reference.end_s, Verdict::EngineEndsEarly);
        }
    }
    let is_inaccurate = |error: f64, limit: f64, amplification: f64| is_chaotic || exceeds(error, limit, amplification);
    add_if(
        is_inaccurate(error, max_preset_error, MAX_AMPLIFICATION) && checked.verdict == "sure",
        Verdict::PresetErrorUnreported,
    );
    let has_other_peak = checked.verdict == "sure" && peak_difference(&preset, &reference) > MAX_PEAK_DIFFERENCE;
    add_if(has_other_peak, Verdict::PresetPeakUnreported);
    add_if(checked.is_unbalanced || engine_checked.is_unbalanced, Verdict::Unbalanced);
    add_if(
        !is_chaotic && error <= 0.5 * MAX_PRESET_ERROR && have_same_end(&reference, &preset) && checked.reports_error,
        Verdict::PresetFalseAlarm,
    );
    if let Some(engine) = &engine {
        add_if(
            is_inaccurate(engine_error, max_engine_error, MAX_ENGINE_AMPLIFICATION) && engine_checked.verdict == "sure",
            Verdict::EngineErrorUnreported,
        );
        let is_accurate = engine_error <= 0.05 * MAX_ENGINE_ERROR && have_same_end(&reference, engine);
        add_if(!is_chaotic && is_accurate && engine_checked.reports_error, Verdict::EngineFalseAlarm);
    }
    Trial {
        analytic_verdict: checked.verdict,
        engine_verdict: engine_checked.verdict,
        is_deep: checked.is_deep,
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
