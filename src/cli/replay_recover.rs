//! `phalanx replay --recover`: writes the readable part of a damaged log as a new log.

use std::io;
use std::path::Path;
use std::slice;

use super::interrupt::Interrupt;
use super::output::print_result;
use super::replay_args::{ReplayArgs, print_losses};
use super::replay_read::{ReadMonitor, read_failure, read_head};
use super::targets::{FileKind, NO_DIRECTORY, TargetKind, reserve};
use super::{Failure, Status};
use crate::files::replace_file;
use crate::log::{self, ReadError, Recovery};
use crate::report::replay::RecoveryReport;

/// Runs the command. The recovered log is written atomically and replaces only an existing log.
pub(super) fn run(args: &ReplayArgs, target: &Path, interrupt: &Interrupt) -> Result<Status, Failure> {
    let path = &args.log;
    let mut source = log::open_log(path).map_err(|error| read_failure(path, &error))?;
    reserve(
        &[("the log", slice::from_ref(path))],
        &[("--recover", Some(target), TargetKind::File(FileKind::Log))],
        NO_DIRECTORY,
    )?;
    let source_name = path.file_name().and_then(|name| name.to_str()).unwrap_or("a log");
    let name = format!("the recovered log {}", target.display());
    let duration_s = read_head(path)?.metadata.get("duration_s").and_then(|text| text.parse().ok());
    let monitor = ReadMonitor::new(duration_s, interrupt, &name);
    let check = |log_time_ns| monitor.update(log_time_ns);
    let mut outcome: Result<Recovery, ReadError> = Err(ReadError::NotMcap);
    let written = replace_file(target, |out| {
        outcome = log::recover(&mut source, source_name, out, &name, &check);
        // Any error discards the incomplete file; `outcome` holds the actual error.
        outcome.as_ref().map_or(Err(io::ErrorKind::Other.into()), |_| Ok(()))
    });
    monitor.clear_progress();
    let recovery = outcome.map_err(|error| read_failure(path, &error))?;
    written.map_err(|error| Failure::incomplete(format!("cannot write {name}: {error}")))?;
    let report = RecoveryReport::new(path.display().to_string(), target.display().to_string(), &recovery);
    print_result(&report, args.json)?;
    // The recovery succeeded, so losses do not change the exit status.
    print_losses(path, &recovery.reading);
    Ok(Status::Done)
}
