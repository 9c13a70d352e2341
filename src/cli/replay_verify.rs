//! `phalanx replay --verify`: the run of a log simulated again, and both compared message by message.

use std::fs::File;
use std::io::{BufReader, Seek};
use std::path::Path;
use std::time::Instant;

use super::interrupt::Interrupt;
use super::output::{answer, complain};
use super::replay_args::{ReplayArgs, defects};
use super::replay_read::{Listeners, Watch, attached, bad_log, head, read};
use super::simulate::{Broken, Checking, Finished, Limits, simulate};
use super::{Failure, Status};
use crate::log::{self, Beside, Expected, Lockstep, Reading, RunInfo, Settings, gaps, settings, stamp_ns};
use crate::report::replay::VerificationReport;
use crate::scene::Scene;
use crate::trace::SinkError;

/// What errors call the log of the new run.
const AGAIN: &str = "the log of the new run to a temporary file (the directory for these is that of TMPDIR)";

/// Runs the command.
pub(super) fn run(args: &ReplayArgs, interrupt: &Interrupt) -> Result<Status, Failure> {
    let path = &args.log;
    let (scene, settings) = again_from(path, &head(path)?)?;
    let mut listeners = Listeners::new(path, interrupt)?;
    let reading = read(path, &mut listeners)?;

    let start = Instant::now();
    let mut report = listeners.report(path.display().to_string(), &reading);
    let expected = expected(&reading, report.contradicts_itself);
    // A run that is known in part only is simulated only that far.
    let until_s =
        if expected.ends && expected.before_ns.is_none() { f64::INFINITY } else { reading.last_s.unwrap_or(0.0) };
    let file = simulate_again(&scene, &settings, &Limits { interrupt, until_s, checking: Checking::Never })?;
    let wall_s = start.elapsed().as_secs_f64();

    let watch = Watch::new(reading.last_s, interrupt, "the comparison of the whole log");
    let check = |log_time_ns| watch.reached(log_time_ns);
    let mut lockstep = Lockstep::new(BufReader::new(file), expected, &check).map_err(unreadable)?;
    let compared = log::read_any_file(path, &mut lockstep);
    watch.done();
    compared.map_err(|error| bad_log(path, &error))?;
    let found = lockstep.finish().map_err(unreadable)?;

    let contradiction = report.error.as_ref().filter(|_| report.contradicts_itself).map(|error| error.reason.as_str());
    let verification = VerificationReport::new(&found, &reading, contradiction, wall_s);
    let (same, complete) = (verification.same, verification.complete);
    let lines = verification.complaints(path);
    report.verification = Some(verification);
    answer(&report, args.json)?;
    let status = defects(path, &reading, &report);
    lines.iter().for_each(|line| complain(line));
    Ok(if same && complete { status } else { Status::CheckFailed })
}

/// The scene and the settings of a log.
fn again_from(path: &Path, head: &Reading) -> Result<(Scene, Settings), Failure> {
    let place = path.display();
    let found = settings(&head.metadata).map_err(|error| Failure::bad_input(format!("{place}: {error}")))?;
    let mut scene = match attached(head) {
        Some(Ok(scene)) => scene,
        Some(Err(error)) => {
            return Err(Failure::bad_input(format!(
                "{place}: the scene in the log cannot be read by this phalanx; use the one that wrote it ({}):\n{error}",
                head.metadata.get("phalanx_version").map_or("unknown version", String::as_str)
            )));
        }
        None => {
            return Err(Failure::bad_input(format!(
                "{place}: there is no scene in the log that could be simulated again: the part that held it is lost"
            )));
        }
    };
    if scene.kind() != head.kind() {
        return Err(Failure::bad_input(format!(
            "{place}: the scene in the log is of another kind than its metadata say; they do not belong together"
        )));
    }
    found.impose(&mut scene);
    Ok((scene, found))
}

/// What is to be compared of a log, by how it ended.
fn expected(reading: &Reading, contradicts_itself: bool) -> Expected {
    let stopped = reading.ended.as_ref().and_then(|ended| ended.stopped.as_deref());
    // When a signal came is nothing that a simulation knows.
    let interrupted = stopped.is_some_and(|reason| reason.starts_with("interrupted by "));
    // A log whose run is shorter than its settings is compared as far as it goes.
    Expected {
        before_ns: reading.last_s.filter(|_| interrupted || contradicts_itself).map(stamp_ns),
        ends: reading.ended.is_some(),
        gaps: reading.recovered.as_ref().map(gaps).unwrap_or_default(),
    }
}

/// Simulates into a temporary file, which is gone when it is closed.
fn simulate_again(scene: &Scene, settings: &Settings, limits: &Limits<'_>) -> Result<File, Failure> {
    let (model, scene_file) = (settings.model(), settings.scene_file.as_str());
    let failed = |error: SinkError| Failure::incomplete(format!("{error}; free some space there or set TMPDIR"));
    let file = tempfile::tempfile().map_err(|source| failed(SinkError { what: AGAIN.to_string(), source }))?;
    let info = RunInfo { scene, scene_file, model: model.name() };
    let writer = Beside::start(file, AGAIN, &info, None, || {}).map_err(failed)?;
    let log = ended(simulate(model, scene, Some(writer), limits, &mut ()));
    if let Some(signal) = limits.interrupt.signal() {
        return Err(Failure::incomplete(format!(
            "interrupted by {signal} while the run was simulated again: nothing has been compared"
        )));
    }
    let mut file = log.map_err(failed)?.ok_or_else(|| Failure::incomplete("the new run has left no log"))?;
    file.rewind().map_err(unreadable)?;
    Ok(file)
}

/// The log of a run. One that stopped is as good as one that was completed, unless its log could not be written.
fn ended(run: Finished<File>) -> Result<Option<File>, SinkError> {
    match run.result {
        Err(Broken { so_far: None, error }) => {
            Err(SinkError { what: AGAIN.to_string(), source: std::io::Error::other(error.reason) })
        }
        _ => run.log,
    }
}

fn unreadable(error: std::io::Error) -> Failure {
    Failure::incomplete(format!("cannot read {AGAIN}: {error}"))
}
