//! `phalanx validate`: the engine model against the analytic one, and speed against error.

use super::interrupt::Interrupt;
use super::output::{print, show};
use super::progress::Count;
use super::set::files as scene_files;
use super::targets::reserve;
use super::validate_args::ValidateArgs;
use super::validate_files::{files, write};
use super::{Failure, Status};
use crate::integrator;
use crate::report::validation::ValidationReport;
use crate::scene::Scene;
use crate::trace::{Model, RunError};
use crate::validate::{Climb, Progress, StudyError, Validation, climb, refuse_too_fine, validate};
use crate::wording::{Report, Reported, duration};

/// Runs the command.
pub fn run(args: &ValidateArgs) -> Result<Status, Failure> {
    let scene = args.set.load_any(&args.scene)?;
    let scene = &scene;
    let folder =
        reserve(&[("the scene", &scene_files(&args.scene))], &[], ("--out", args.out.as_deref(), files(scene)))?;
    let interrupt = Interrupt::listen()?;
    let mut found = watched(scene, args, &interrupt)?;
    let mut report = ValidationReport::new(scene, &found, None);
    // The verdict comes first, whatever follows takes.
    if !args.json {
        show(&report.of_verdict())?;
    }
    if let Some(plan) = args.climb() {
        climbed(&mut found, scene, (args, plan), &interrupt)?;
        report = ValidationReport::new(scene, &found, Some(plan));
    }
    if let Some(folder) = folder {
        folder.fill(|out| write(out, args, scene, &found, &mut report, &interrupt))?;
    }
    match (args.json, report.of_ladder()) {
        (true, _) => print(&report.json())?,
        (false, Some(ladder)) => show(&Report::from("\n").and(ladder))?,
        (false, None) => {}
    }
    Ok(if report.passed { Status::Done } else { Status::CheckFailed })
}

/// The verdict; it ends at a signal.
fn watched(scene: &Scene, args: &ValidateArgs, interrupt: &Interrupt) -> Result<Validation, Failure> {
    refuse_too_fine(scene).map_err(Failure::bad_input)?;
    let mut count = Count::new();
    count.show(0, 1, "verdict");
    let result = validate(scene, &|| interrupt.signal().is_none());
    count.clear();
    result.map_err(|error| match interrupt.signal().filter(|_| error.error.is_stop()) {
        Some(signal) => interrupted(signal, "before its verdict", args.out.is_some()),
        None => incomplete(error),
    })
}

/// The ladder, its progress shown; it ends at a signal.
fn climbed(
    found: &mut Validation,
    scene: &Scene,
    (args, plan): (&ValidateArgs, Climb),
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let mut count = Count::new();
    let mut reached = (0, 0);
    let mut tell = |Progress { done, total, next }: Progress| {
        reached = (done, total);
        count.show(done, total, next);
    };
    let result = climb(found, scene, plan, &mut tell, &|| interrupt.signal().is_none());
    count.clear();
    result.map_err(|error| match interrupt.signal().filter(|_| error.error.is_stop()) {
        Some(signal) => {
            let (done, total) = reached;
            interrupted(signal, &format!("after {done} of {total} settings of its ladder"), args.out.is_some())
        }
        None => incomplete(error),
    })
}

/// A signal came.
fn interrupted(signal: &str, when: &str, out: bool) -> Failure {
    let files = if out { "; no file was written, and older ones are as they were" } else { "" };
    Failure::incomplete(format!("the validation was interrupted by {signal} {when}{files}"))
}

/// One of the two runs that must complete did not.
fn incomplete(error: StudyError) -> Failure {
    match error.error {
        RunError::Simulation { failure, .. } => stopped(error.model, &failure),
        RunError::Sink(sink) => Failure::incomplete(format!("the {} model stopped: {sink}", error.model.name())),
    }
}

/// A model that cannot go through the scene.
fn stopped(model: Model, failure: &integrator::Failure) -> Failure {
    let model = model.name();
    Failure::incomplete(format!(
        "the {model} model stopped at {}: {}; there is nothing to compare (phalanx run --model {model} --log FILE.mcap \
         keeps the run up to there)",
        duration(failure.time_s),
        failure.reason
    ))
}
