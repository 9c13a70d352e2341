//! `phalanx validate`: compares the engine model with the analytic model, and speed with error.

use super::interrupt::{self, Interrupt};
use super::output::{print, print_report};
use super::progress::RunCounter;
use super::set::source_files;
use super::targets::reserve;
use super::validate_args::ValidateArgs;
use super::validate_files::{files, write};
use super::{Failure, Status};
use crate::format::{Report, ToReport, format_duration};
use crate::integrator;
use crate::report::validation::ValidationReport;
use crate::scene::Scene;
use crate::trace::{Model, RunError};
use crate::validate::{LadderOptions, Progress, Validation, ValidationError, check_sample_count, run_ladder, validate};

/// Runs `phalanx validate`.
pub fn run(args: &ValidateArgs) -> Result<Status, Failure> {
    let scene = args.set.load_any(&args.scene)?;
    let scene = &scene;
    let directory =
        reserve(&[("the scene", &source_files(&args.scene))], &[], ("--out", args.out.as_deref(), files(scene)))?;
    let interrupt = Interrupt::listen()?;
    let mut validation = run_validation(scene, args, &interrupt)?;
    let mut report = ValidationReport::new(scene, &validation, None);
    // The verdict is printed first, because the ladder takes longer.
    if !args.json {
        print_report(&report.verdict_report())?;
    }
    if let Some(options) = args.ladder_options() {
        run_ladder_with_progress(&mut validation, scene, (args, options), &interrupt)?;
        report = ValidationReport::new(scene, &validation, Some(options));
    }
    if let Some(directory) = directory {
        directory.write_with(|out| write(out, args, scene, &validation, &mut report, &interrupt))?;
    }
    match (args.json, report.ladder_report()) {
        (true, _) => print(&report.json())?,
        (false, Some(ladder)) => print_report(&Report::from("\n").with(ladder))?,
        (false, None) => {}
    }
    Ok(if report.passed { Status::Done } else { Status::CheckFailed })
}

/// Computes the verdict; stops at a signal.
fn run_validation(scene: &Scene, args: &ValidateArgs, interrupt: &Interrupt) -> Result<Validation, Failure> {
    check_sample_count(scene).map_err(Failure::bad_input)?;
    let mut counter = RunCounter::new();
    counter.update(0, 1, "verdict");
    let result = validate(scene, &|| interrupt.signal().is_none());
    counter.clear();
    result.map_err(|error| match interrupt.signal().filter(|_| error.error.is_stop()) {
        Some(signal) => interrupted(signal, "before its verdict", args.out.is_some()),
        None => run_failure(error),
    })
}

/// Runs the ladder and shows its progress; stops at a signal.
fn run_ladder_with_progress(
    validation: &mut Validation,
    scene: &Scene,
    (args, options): (&ValidateArgs, LadderOptions),
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let mut counter = RunCounter::new();
    let mut done_and_total = (0, 0);
    let mut report_progress = |Progress { done, total, next }: Progress| {
        done_and_total = (done, total);
        counter.update(done, total, next);
    };
    let result = run_ladder(validation, scene, options, &mut report_progress, &|| interrupt.signal().is_none());
    counter.clear();
    result.map_err(|error| match interrupt.signal().filter(|_| error.error.is_stop()) {
        Some(signal) => {
            let (done, total) = done_and_total;
            interrupted(signal, &format!("after {done} of {total} settings of its ladder"), args.out.is_some())
        }
        None => run_failure(error),
    })
}

/// Failure of a validation that a signal interrupted.
fn interrupted(signal: &str, when: &str, has_out: bool) -> Failure {
    let files = if has_out { interrupt::NO_FILE_WRITTEN } else { "" };
    Failure::incomplete(format!("the validation was interrupted by {signal} {when}{files}"))
}

/// Failure of one of the two runs that a validation compares.
fn run_failure(error: ValidationError) -> Failure {
    match error.error {
        RunError::Simulation { failure, .. } => simulation_failure(error.model, &failure),
        RunError::Sink(sink) => Failure::incomplete(format!("the {} model stopped: {sink}", error.model.name())),
    }
}

/// Failure of a model that cannot complete the scene.
fn simulation_failure(model: Model, failure: &integrator::Failure) -> Failure {
    let model = model.name();
    Failure::incomplete(format!(
        "the {model} model stopped at {}: {}; there is nothing to compare (phalanx run --model {model} --log FILE.mcap \
         keeps the run up to that time)",
        format_duration(failure.time_s),
        failure.reason
    ))
}
