//! `phalanx replay --recover`: the good part of a damaged log as a log of its own.

use std::io;
use std::path::Path;
use std::slice;

use super::interrupt::Interrupt;
use super::output::answer;
use super::own::Form;
use super::replay_args::{ReplayArgs, losses};
use super::replay_read::{Watch, bad_log, head};
use super::targets::{Kind, NONE, reserve};
use super::{Failure, Status};
use crate::files::replace;
use crate::log::{self, ReadError, Recovery};
use crate::report::replay::RecoveryReport;

/// Runs the command. The recovered log appears whole or not at all; an older log of its name is replaced, no other file.
pub(super) fn run(args: &ReplayArgs, target: &Path, interrupt: &Interrupt) -> Result<Status, Failure> {
    let path = &args.log;
    let mut source = log::open_log(path).map_err(|error| bad_log(path, &error))?;
    reserve(&[("the log", slice::from_ref(path))], &[("--recover", Some(target), Kind::File(Form::Log))], NONE)?;
    let source_name = path.file_name().and_then(|name| name.to_str()).unwrap_or("a log");
    let name = format!("the recovered log {}", target.display());
    let duration_s = head(path)?.metadata.get("duration_s").and_then(|text| text.parse().ok());
    let watch = Watch::new(duration_s, interrupt, &name);
    let check = |log_time_ns| watch.reached(log_time_ns);
    let mut outcome: Result<Recovery, ReadError> = Err(ReadError::NotMcap);
    let written = replace(target, |out| {
        outcome = log::recover(&mut source, source_name, out, &name, &check);
        // What is not whole is no file; the failure itself says why.
        outcome.as_ref().map_or(Err(io::ErrorKind::Other.into()), |_| Ok(()))
    });
    watch.done();
    let found = outcome.map_err(|error| bad_log(path, &error))?;
    written.map_err(|error| Failure::incomplete(format!("cannot write {name}: {error}")))?;
    let report = RecoveryReport::new(path.display().to_string(), target.display().to_string(), &found);
    answer(&report, args.json)?;
    // What was asked for is done, whatever was lost before.
    losses(path, &found.reading);
    Ok(Status::Done)
}
