//! `phalanx replay`: summarises a log, verifies it by simulating again, compares two logs, and exports samples as a
//! table.

use std::path::Path;
use std::slice;
use std::time::Instant;

use super::output::{FileKind, NO_DIRECTORY, print_diagnostic, print_result, reserve, save};
use super::progress::Interrupt;
use super::replay_read::{LogReader, ReplayArgs, print_defects, read_failure};
use super::simulate::{CheckPolicy, RunLimits, SampleTable, csv_file, simulate};
use super::{Failure, Status, replay_against};
use crate::format::ToReport;
use crate::log::{
    ComparisonOptions, LogComparison, LogFile, LogSummary, RunInfo, Settings, open_log, settings, stamp_ns,
};
use crate::page::{Page, render_page};
use crate::report::replay::{VerificationReport, scene_in_log};
use crate::scene::Scene;
use crate::trace::RunError;

pub(super) fn run(args: &ReplayArgs) -> Result<Status, Failure> {
    let interrupt = Interrupt::listen()?;
    match &args.against {
        _ if args.verify => verify_log(args, &interrupt),
        Some(other) => replay_against::run(args, other, &interrupt),
        None => replay_log(args, &interrupt),
    }
}

/// Reads the log once for its summary, its table and its page. The summary is omitted if the table goes to standard
/// output.
fn replay_log(args: &ReplayArgs, interrupt: &Interrupt) -> Result<Status, Failure> {
    let path = &args.log;
    let csv = csv_file(args.csv.as_deref(), args.json)?;
    let mut reader = LogReader::new(path, interrupt)?;
    if args.plot.is_some() {
        reader.record_page()?;
    }
    let targets = [("--csv", csv, FileKind::Table), ("--plot", args.plot.as_deref(), FileKind::Page)];
    reserve(&[("the log", slice::from_ref(path))], &targets, NO_DIRECTORY)?;
    reader.table = args.csv.as_deref().map(SampleTable::create).transpose()?;
    let result = reader.read();
    // An error of the table ends the reading, too.
    let table = reader.table.take().filter(|table| result.is_ok() || table.has_failed());
    if !table.map_or(Ok(true), SampleTable::finish)? {
        return Ok(Status::Done);
    }
    result?;
    let mut report = reader.report();
    report.csv = csv.map(|csv| csv.display().to_string());
    if let Some(target) = &args.plot {
        reader.ensure_drawable()?;
        let (title, description) = reader.name_and_description();
        let playback = reader.into_playback(report.model.as_deref().unwrap_or("run"), report.report())?;
        let playback = playback.with_grasp(report.played_grasp());
        save(target, &render_page(&Page { title, description, runs: vec![playback], ..Page::default() }))?;
        report.page = Some(target.display().to_string());
    }
    if csv.is_some() || args.csv.is_none() {
        print_result(&report, args.json)?;
    }
    Ok(print_defects(path, &report))
}

/// Simulates the run of a log again and compares both runs sample by sample.
fn verify_log(args: &ReplayArgs, interrupt: &Interrupt) -> Result<Status, Failure> {
    let path = &args.log;
    let to_failure = |error| read_failure(path, &error);
    let mut reader = LogReader::new(path, interrupt)?;
    let (scene, settings) = load_scene_and_settings(path, &reader.summary)?;
    reader.read()?;
    let start = Instant::now();
    let mut report = reader.report();
    let summary = reader.summary;
    let options = comparison_options(&summary, report.is_inconsistent);
    // An incomplete log is simulated only up to its last sample.
    let until_s =
        if options.has_run_end && options.before_ns.is_none() { f64::INFINITY } else { summary.last_s.unwrap_or(0.0) };
    let model = settings.model();
    let info = RunInfo { scene: &scene, scene_file: &settings.scene_file, model: model.name() };
    let mut comparison = LogComparison::new(open_log(path).map_err(to_failure)?, &info, options).map_err(to_failure)?;
    let limits = RunLimits { interrupt, until_s, check_policy: CheckPolicy::Never };
    let run = simulate::<LogFile>(model, &scene, None, &limits, &mut comparison);
    if let Some(signal) = interrupt.signal() {
        return Err(Failure::incomplete(format!(
            "interrupted by {signal} while the run was simulated again; nothing was compared"
        )));
    }
    let new_end = match (run.stopped, run.result) {
        (None, _) => "completed".to_string(),
        (Some((_, reason)), Err(RunError::Sink(_))) => return Err(Failure::incomplete(reason)),
        (Some((_, reason)), _) => reason,
    };
    let wall_s = start.elapsed().as_secs_f64();
    let log_end = summary.run_end.as_ref().map(|end| end.stopped.clone().unwrap_or_else(|| "completed".to_string()));
    let found = comparison.finish(log_end, new_end).map_err(to_failure)?;

    let inconsistency = report.error.as_ref().filter(|_| report.is_inconsistent).map(|error| error.reason.as_str());
    let verification = VerificationReport::new(found, &summary, inconsistency, wall_s);
    let (is_identical, is_complete) = (verification.is_identical, verification.is_complete);
    let messages = verification.error_messages(path);
    report.verification = Some(verification);
    print_result(&report, args.json)?;
    let status = print_defects(path, &report);
    messages.iter().for_each(|message| print_diagnostic(message));
    Ok(if is_identical && is_complete { status } else { Status::CheckFailed })
}

fn load_scene_and_settings(path: &Path, head: &LogSummary) -> Result<(Scene, Settings), Failure> {
    let bad_input = |reason: String| Failure::bad_input(format!("{}: {reason}", path.display()));
    let logged_settings = settings(&head.metadata).map_err(|error| bad_input(error.to_string()))?;
    let unusable = match scene_in_log(head) {
        Some(Ok(mut scene)) if scene.finger_count() == head.finger_count() => {
            logged_settings.apply_to(&mut scene);
            return Ok((scene, logged_settings));
        }
        Some(Ok(_)) => {
            "the kind of the scene in the log differs from the kind in its metadata; use an unmodified log".to_string()
        }
        Some(Err(error)) => format!(
            "the scene in the log cannot be read by this version of phalanx; use the version that wrote it ({}):\n{error}",
            head.metadata.get("phalanx_version").map_or("unknown version", String::as_str)
        ),
        None => "the run cannot be simulated again, because the part of the log with its scene is lost".to_string(),
    };
    Err(bad_input(unusable))
}

/// Returns which part of a log to compare, according to how its run ended.
fn comparison_options(summary: &LogSummary, is_inconsistent: bool) -> ComparisonOptions {
    let stopped = summary.run_end.as_ref().and_then(|ended| ended.stopped.as_deref());
    // A simulation cannot reproduce the time of a signal.
    let interrupted = stopped.is_some_and(|reason| reason.starts_with("interrupted by "));
    // A log that is shorter than its settings require is compared up to its last sample.
    ComparisonOptions {
        before_ns: summary.last_s.filter(|_| interrupted || is_inconsistent).map(stamp_ns),
        has_run_end: summary.run_end.is_some(),
    }
}
