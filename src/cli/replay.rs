//! `phalanx replay`: what a log says of its run; whether simulating again gives the same; two logs side by side; samples as
//! a table; the good part of a damaged log.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::interrupt::Interrupt;
use super::output::answer;
use super::own::{Form, writable};
use super::replay_args::{ReplayArgs, defects, refuse_the_log};
use super::replay_read::{Listeners, read, tabulate};
use super::{Failure, Status, replay_against, replay_page, replay_recover, replay_verify};
use crate::files::replace;
use crate::log::Reading;

/// Runs the command.
pub fn run(args: &ReplayArgs) -> Result<Status, Failure> {
    let interrupt = Interrupt::listen()?;
    if args.verify {
        return replay_verify::run(args, &interrupt);
    }
    if let Some(target) = &args.recover {
        return replay_recover::run(args, target, &interrupt);
    }
    if let Some(other) = &args.against {
        return replay_against::run(args, other, &interrupt);
    }
    match (&args.csv, &args.html) {
        (Some(path), _) => csv(args, path, &interrupt),
        (None, Some(path)) => replay_page::run(args, path, &interrupt),
        (None, None) => {
            let mut listeners = Listeners::new(&args.log, &interrupt)?;
            let reading = read(&args.log, &mut listeners)?;
            summarise(args, &reading, &listeners)
        }
    }
}

/// Prints the summary, and says on stderr what of the log is lost.
fn summarise(args: &ReplayArgs, reading: &Reading, listeners: &Listeners<'_>) -> Result<Status, Failure> {
    let report = listeners.report(args.log.display().to_string(), reading);
    answer(&report, args.json)?;
    Ok(defects(&args.log, reading, &report))
}

/// Writes the samples, and the summary unless they go to where it would.
fn csv(args: &ReplayArgs, path: &Path, interrupt: &Interrupt) -> Result<Status, Failure> {
    let mut listeners = Listeners::new(&args.log, interrupt)?;
    if path == Path::new("-") {
        if args.json {
            return Err(Failure::bad_input(
                "--csv - and --json would both write to standard output; give --csv the name of a file, or leave out --json",
            ));
        }
        let mut out = BufWriter::new(io::stdout().lock());
        let Some(reading) = tabulate(&args.log, &mut listeners, &mut out)? else { return Ok(Status::Done) };
        return match out.flush() {
            // Whoever reads has seen enough (`| head`).
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                Err(Failure::incomplete(format!("cannot write to standard output: {error}")))
            }
            _ => {
                let report = listeners.report(args.log.display().to_string(), &reading);
                Ok(defects(&args.log, &reading, &report))
            }
        };
    }
    refuse_the_log(&args.log, path, "--csv")?;
    writable(path, Form::Samples)?;
    let mut outcome = Err(Failure::incomplete(format!("cannot write {}", path.display())));
    let written = replace(path, |out| {
        outcome = tabulate(&args.log, &mut listeners, out);
        // Half of what was asked for is no file; the failure itself says why.
        outcome.as_ref().map_or(Err(io::ErrorKind::Other.into()), |_| Ok(()))
    });
    match (outcome?, written) {
        (Some(reading), Ok(())) => summarise(args, &reading, &listeners),
        (_, Err(error)) => Err(Failure::incomplete(format!("cannot write {}: {error}", path.display()))),
        (None, Ok(())) => Ok(Status::Done),
    }
}
