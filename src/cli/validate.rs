//! `phalanx validate`: the engine model against the analytic one, and speed against error.

use super::folder::Folder;
use super::interrupt::Interrupt;
use super::output::answer;
use super::progress::Count;
use super::validate_args::ValidateArgs;
use super::validate_files::{files, write};
use super::{Failure, Status};
use crate::integrator;
use crate::report::validation::ValidationReport;
use crate::scene::Scene;
use crate::trace::{Model, RunError};
use crate::validate::{Progress, StudyError, Validation, refuse_too_fine, validate};
use crate::wording::duration;

/// Runs the command.
pub fn run(args: &ValidateArgs) -> Result<Status, Failure> {
    let scene = args.set.load_any(&args.scene)?;
    let scene = &scene;
    let folder = args.out.as_deref().map(|out| Folder::open(out, files(scene))).transpose()?;
    let interrupt = Interrupt::listen()?;
    let found = watched(scene, args, &interrupt)?;
    let mut report = ValidationReport::new(scene, &found, args.quick);
    if let Some(folder) = folder {
        folder.fill(|out| write(out, args, scene, &found, &mut report, &interrupt))?;
    }
    answer(&report, args.json)?;
    Ok(if report.passed { Status::Done } else { Status::CheckFailed })
}

/// The validation itself, its progress shown; it ends at a signal.
fn watched(scene: &Scene, args: &ValidateArgs, interrupt: &Interrupt) -> Result<Validation, Failure> {
    refuse_too_fine(scene).map_err(Failure::bad_input)?;
    let mut count = Count::new();
    let mut reached = (0, 0);
    let mut tell = |Progress { done, total, next }: Progress| {
        reached = (done, total);
        count.show(done, total, next);
    };
    let result = validate(scene, args.quick, &mut tell, &|| interrupt.signal().is_none());
    count.clear();
    result.map_err(|error| match interrupt.signal().filter(|_| error.error.is_stop()) {
        Some(signal) => interrupted(signal, reached, args.out.is_some()),
        None => incomplete(error),
    })
}

/// A signal came while settings were being compared.
fn interrupted(signal: &str, (done, total): (usize, usize), out: bool) -> Failure {
    let files = if out { "; no file was written, and older ones are as they were" } else { "" };
    Failure::incomplete(format!(
        "the validation was interrupted by {signal} after {done} of {total} parts: there is no verdict{files}"
    ))
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
