//! `phalanx replay --verify`: simulates the run of a log again and compares both runs sample by sample.

use std::path::Path;
use std::time::Instant;

use super::interrupt::Interrupt;
use super::output::{print_diagnostic, print_result};
use super::replay_read::{ReplayArgs, SummarySink, print_defects, read_failure, read_head, scene_in_log};
use super::simulate::{CheckPolicy, RunLimits, simulate};
use super::{Failure, Status};
use crate::log::{
    ComparisonOptions, LogComparison, LogFile, LogSummary, RunInfo, Settings, open_log, read_file, settings, stamp_ns,
};
use crate::report::replay::VerificationReport;
use crate::scene::Scene;

/// Runs `phalanx replay --verify`.
pub(super) fn run(args: &ReplayArgs, interrupt: &Interrupt) -> Result<Status, Failure> {
    let path = &args.log;
    let to_failure = |error| read_failure(path, &error);
    let (scene, settings) = load_scene_and_settings(path, &read_head(path)?)?;
    let mut summary_sink = SummarySink::new(path, interrupt)?;
    let summary = read_file(path, &mut summary_sink).map_err(to_failure);
    summary_sink.clear_progress();
    let summary = summary?;

    let start = Instant::now();
    let mut report = summary_sink.report(path, &summary);
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
    let new_end = match run.report.error {
        None => "completed".to_string(),
        Some(error) if run.has_failed_sink => return Err(Failure::incomplete(error.reason)),
        Some(error) => error.reason,
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

/// Returns the scene and the settings of a log.
fn load_scene_and_settings(path: &Path, head: &LogSummary) -> Result<(Scene, Settings), Failure> {
    let shown_path = path.display();
    let logged_settings =
        settings(&head.metadata).map_err(|error| Failure::bad_input(format!("{shown_path}: {error}")))?;
    let mut scene = match scene_in_log(head) {
        Some(Ok(scene)) => scene,
        Some(Err(error)) => {
            return Err(Failure::bad_input(format!(
                "{shown_path}: the scene in the log cannot be read by this version of phalanx; use the version that wrote it ({}):\n{error}",
                head.metadata.get("phalanx_version").map_or("unknown version", String::as_str)
            )));
        }
        None => {
            return Err(Failure::bad_input(format!(
                "{shown_path}: the run cannot be simulated again, because the part of the log with its scene is lost"
            )));
        }
    };
    if scene.kind() != head.kind() {
        return Err(Failure::bad_input(format!(
            "{shown_path}: the kind of the scene in the log differs from the kind in its metadata; use an unmodified log"
        )));
    }
    logged_settings.apply_to(&mut scene);
    Ok((scene, logged_settings))
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
