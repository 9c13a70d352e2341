//! `phalanx validate`: the engine model against the analytic one, and speed against error.

use std::path::PathBuf;

use clap::Args;

use super::interrupt::Interrupt;
use super::output::print;
use super::progress::Count;
use super::validate_files::{directory, write};
use super::{Failure, Status};
use crate::report::{self, ValidationReport, validation_json, validation_text};
use crate::scene;
use crate::trace::RunError;
use crate::validate::{Progress, StudyError, validate};

/// Compare the engine with the analytic model, judge it by the scene's bounds, and weigh speed against error.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx validate scenes/experiment-95.toml\n  phalanx validate scenes/experiment-95.toml --out \
                  report\n  phalanx validate scenes/experiment-95.toml --quick --json > validation.json\n\nThe section \
                  [validate] of a scene sets its bounds. Exit status: 0 within bounds; 1 out of bounds; 2 bad input; 3 a \
                  simulation could not be completed."
)]
pub struct ValidateArgs {
    /// Scene file (TOML); `phalanx scene schema` describes it
    scene: PathBuf,

    /// Write everything there: reports, series of both models, pictures, both logs; the directory is made if need be, and
    /// an older file is replaced only when the new one is whole
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,

    /// Leave out the settings that take long: fixed steps below 1e-5 s and reduced coordinates
    #[arg(long)]
    quick: bool,
}

/// Runs the command.
pub fn run(args: &ValidateArgs) -> Result<Status, Failure> {
    let scene = scene::load(&args.scene)?;
    if let Some(out) = &args.out {
        directory(out)?;
    }
    let interrupt = Interrupt::listen()?;
    let mut count = Count::new();
    let mut reached = (0, 0);
    let mut tell = |Progress { done, total, next }: Progress| {
        reached = (done, total);
        count.show(done, total, next);
    };
    let result = validate(&scene, args.quick, &mut tell, &|| interrupt.signal().is_none());
    count.clear();
    let found = result.map_err(|error| match interrupt.signal().filter(|_| error.error.is_stop()) {
        Some(signal) => interrupted(signal, reached, args.out.is_some()),
        None => incomplete(error),
    })?;
    let mut report = ValidationReport::new(&scene, &found, args.quick);
    if let Some(out) = &args.out {
        write(out, &args.scene, &scene, &found, &mut report, &interrupt)?;
    }
    print(&match args.json {
        true => validation_json(&report),
        false => validation_text(&report),
    })?;
    Ok(if report.passed { Status::Done } else { Status::CheckFailed })
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
    let model = error.model.name();
    Failure::incomplete(match error.error {
        RunError::Simulation { failure, .. } => format!(
            "the {model} model stopped at {}: {}; there is nothing to compare (phalanx run --model {model} --log FILE.mcap \
             keeps the run up to there)",
            report::duration(failure.time_s),
            failure.reason
        ),
        RunError::Sink(error) => format!("the {model} model stopped: {error}"),
    })
}
