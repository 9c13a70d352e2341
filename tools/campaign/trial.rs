//! One scene through all settings, and what is to be said of it.

use std::fmt;
use std::time::Instant;

use phalanx::check::check;
use phalanx::scene::Scene;
use phalanx::trace::Model;

use super::record::{PATIENCE, Run, Setting, difference, record, same_end};

/// What is asked: by how much the everyday preset and the engine may be off, in rad or m along the path.
pub const EVERYDAY: f64 = 1e-5;
pub const ENGINE: f64 = 1e-3;
pub const REFERENCE: f64 = 1e-7;
/// A scene is chaotic if this change of what drives it moves its path by more than that.
const PUSH: f64 = 1e-7;
const CHAOTIC: f64 = 1e-3;
/// A difference is the scene's own if it is within so many times what the push does.
const OWN: f64 = 10.0;
const OWN_ENGINE: f64 = 100.0;
/// The steps a reference may take: some 5 s on an idle core. Steps do not depend on what else a machine does.
const SLOW_STEPS: u64 = 800_000;

/// Errors of a scene against its reference, and what the push does to that.
#[derive(Clone, Debug)]
pub struct Trial {
    pub reference: Run,
    pub everyday: Run,
    pub engine: Option<Run>,
    pub push: f64,
    pub second: f64,
    pub error: f64,
    pub engine_error: f64,
    /// What the program says of its own runs.
    pub says: &'static str,
    pub engine_says: &'static str,
    pub verdicts: Vec<Verdict>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    Chaotic,
    ReferenceSlow,
    ReferenceFailed,
    ReferencesDisagree,
    EverydayWrong,
    EverydayFarOff,
    EverydayEndsElsewhere,
    EverydaySilent,
    EverydayFalseAlarm,
    EngineSilent,
    EngineFalseAlarm,
    EngineWrong,
    EngineBeyondTenth,
    EngineEndsElsewhere,
    Fails,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Verdict::Chaotic => "chaotic: a push of 1e-7 moves the reference by more than 1e-3",
            Verdict::ReferenceSlow => "reference takes more than 800,000 steps, some 5 s",
            Verdict::ReferenceFailed => "reference ends for another reason than a fold",
            Verdict::ReferencesDisagree => "two references differ by more than 1e-7",
            Verdict::EverydayWrong => "everyday preset wrong by more than 1e-5",
            Verdict::EverydayFarOff => "everyday preset wrong by more than 1e-3",
            Verdict::EverydayEndsElsewhere => "everyday preset ends in another way than the reference",
            Verdict::EverydaySilent => {
                "everyday preset wrong by more than 1e-5, or chaotic, and its check says it is sure"
            }
            Verdict::EverydayFalseAlarm => "everyday preset right, and its check says it is not",
            Verdict::EngineSilent => "engine wrong by more than 1e-4, or chaotic, and its check says it is sure",
            Verdict::EngineFalseAlarm => "engine right, and its check says it is not",
            Verdict::EngineWrong => "engine wrong by more than 1e-3",
            Verdict::EngineBeyondTenth => "engine wrong by more than 1e-4",
            Verdict::EngineEndsElsewhere => "engine ends early",
            Verdict::Fails => "everyday preset ends for another reason than a fold",
        })
    }
}

fn at_fold(run: &Run) -> bool {
    run.failure.as_ref().is_none_or(|reason| reason.contains("singular") || reason.contains("same centre"))
}

/// What the program says of its own run, and whether that is about its path: energies and restitution are not compared here.
fn ask(scene: &Scene, model: Model) -> (&'static str, bool) {
    let deadline = Instant::now() + PATIENCE;
    let go_on = || Instant::now() < deadline;
    let found = check(model, scene, &go_on);
    let name = found.verdict.name();
    (name, name == "chaotic" || name == "uncertain" && found.errors.path > found.bar)
}

/// Runs a scene in all settings.
pub fn trial(scene: &Scene, engine: bool) -> Trial {
    let reference = record(scene, Setting::Reference, 0.0);
    let everyday = record(scene, Setting::Default, 0.0);
    let slow = reference.steps > SLOW_STEPS;
    // A reference that has been stopped says nothing of what comes after.
    let pushed = record(scene, Setting::Reference, PUSH);
    let second_run = record(scene, Setting::Second, 0.0);
    let engine = engine.then(|| record(scene, Setting::Engine, 0.0));
    let push = difference(&reference, &pushed);
    let second = difference(&reference, &second_run);
    let error = difference(&reference, &everyday);
    let engine_error = engine.as_ref().map_or(0.0, |run| difference(&reference, run));
    let mut verdicts = Vec::new();
    let mut say = |when: bool, verdict: Verdict| {
        if when {
            verdicts.push(verdict);
        }
    };
    let chaotic = push > CHAOTIC || !same_end(&reference, &pushed);
    let beyond = |error: f64, bar: f64, own: f64| error > bar && error > own * push;
    say(chaotic, Verdict::Chaotic);
    say(slow, Verdict::ReferenceSlow);
    say(!at_fold(&reference), Verdict::ReferenceFailed);
    say(!at_fold(&everyday), Verdict::Fails);
    if !chaotic {
        say(beyond(second, REFERENCE, OWN) && !slow, Verdict::ReferencesDisagree);
        say(beyond(error, EVERYDAY, OWN), Verdict::EverydayWrong);
        say(beyond(error, 1e-3, OWN), Verdict::EverydayFarOff);
        say(!same_end(&reference, &everyday), Verdict::EverydayEndsElsewhere);
        if let Some(engine) = &engine {
            // The engine goes through a fold; until there it is held to the reference.
            say(beyond(engine_error, ENGINE, OWN_ENGINE), Verdict::EngineWrong);
            say(beyond(engine_error, 0.1 * ENGINE, OWN_ENGINE), Verdict::EngineBeyondTenth);
            say(engine.failure.is_some() && engine.end_s < 0.999 * reference.end_s, Verdict::EngineEndsElsewhere);
        }
    }
    let (says, alarmed) = ask(scene, Model::Analytic);
    let (engine_says, engine_alarmed) = engine.as_ref().map_or(("", false), |_| ask(scene, Model::Engine));
    let off = |error: f64, bar: f64, own: f64| chaotic || beyond(error, bar, own);
    say(off(error, EVERYDAY, OWN) && says == "sure", Verdict::EverydaySilent);
    say(!chaotic && error <= 0.5 * EVERYDAY && same_end(&reference, &everyday) && alarmed, Verdict::EverydayFalseAlarm);
    if let Some(engine) = &engine {
        say(off(engine_error, 0.1 * ENGINE, OWN_ENGINE) && engine_says == "sure", Verdict::EngineSilent);
        let right = engine_error <= 0.05 * ENGINE && same_end(&reference, engine);
        say(!chaotic && right && engine_alarmed, Verdict::EngineFalseAlarm);
    }
    Trial { says, engine_says, reference, everyday, engine, push, second, error, engine_error, verdicts }
}
