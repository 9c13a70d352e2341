//! Simulation of a scene with log, criteria and energy audit. `phalanx run`, `validate --out`, `replay --verify` and
//! [`run_to`](super::run_to) share this code, so all their logs have the same content.

use std::io::Write;
use std::time::Instant;

use foxglove::messages::log::Level;

use super::metadata::{CHECK_NAME, check_entries};
use super::threaded::ThreadedWriter;
use phalanx_core::check::Check;
use phalanx_core::criteria::{
    Criteria, GraspCriteria, LinkOverlap, Rebound, RunCriteria, RunCriteriaTracker, fate_reason,
};
use phalanx_core::invariants::EnergyAudit;
use phalanx_core::scene::Scene;
use phalanx_core::trace::{Decimated, Event, Model, Outcome, RunError, Sample, Sink, SinkError, run};

/// A finished run and its log, which is still open.
pub struct FinishedRun<W: Write + Send + 'static> {
    pub result: Result<Outcome, RunError>,
    /// Criteria of a completed run of a single finger that can grasp its object.
    pub criteria: Option<Criteria>,
    /// Grasp criteria, only for a gripper.
    pub grasp: Option<GraspCriteria>,
    /// Rebounds, one per pair of discs; empty for scenes with a finger.
    pub rebounds: Vec<Rebound>,
    /// Reasons to doubt the results, as sentences; also written to the log.
    pub warnings: Vec<String>,
    /// Time of the latest sample.
    pub last_s: f64,
    pub wall_s: f64,
    pub log: OpenLog<W>,
}

/// A log that lacks its final lines.
pub struct OpenLog<W: Write + Send + 'static> {
    log: Option<ThreadedWriter<W>>,
    /// Result of writing the last sample.
    last_sample: Result<(), SinkError>,
    last_s: f64,
    /// Final line about the grasp.
    verdict: Option<String>,
    warnings: Vec<String>,
}

/// Simulates a scene. `extra_sink` receives the same samples and events as the log and can stop the run.
pub fn simulate<W: Write + Send + 'static>(
    model: Model,
    scene: &Scene,
    log: Option<ThreadedWriter<W>>,
    extra_sink: &mut impl Sink,
) -> FinishedRun<W> {
    let audit = EnergyAudit::new(model, scene);
    let sinks =
        RunSinks { log, criteria_tracker: RunCriteriaTracker::for_scene(scene), audit, last_s: 0.0, extra_sink };
    let mut decimated = Decimated::new(scene.log.numeric_hz, sinks);
    let start = Instant::now();
    let result = run(model, scene, &mut decimated);
    let wall_s = start.elapsed().as_secs_f64();
    let last_sample = decimated.end();
    let RunSinks { log, criteria_tracker, audit, last_s, .. } = decimated.sink;
    let RunCriteria { criteria, grasp, rebounds, overlaps } = criteria_tracker.finish(result.is_ok());
    let fate_sentence = |criteria: &GraspCriteria| {
        format!("{}: {}", criteria.fate.name(), fate_reason(criteria, scene.thresholds.held_time_s))
    };
    let verdict = criteria
        .as_ref()
        .map(Criteria::verdict)
        .or_else(|| grasp.as_ref().filter(|_| result.is_ok()).map(fate_sentence));
    let energy_warning = audit.violation().map(|breach| breach.to_string());
    let warnings: Vec<String> = energy_warning.into_iter().chain(overlaps.iter().map(LinkOverlap::sentence)).collect();
    let log = OpenLog { log, last_sample, last_s, verdict, warnings: warnings.clone() };
    FinishedRun { result, criteria, grasp, rebounds, warnings, last_s, wall_s, log }
}

impl<W: Write + Send + 'static> OpenLog<W> {
    /// Writes how the run ended and finishes the log. `stopped`: time and reason if the run ended early.
    pub fn close(self, stopped: Option<(f64, &str)>, check: Option<&Check>) -> Result<Option<W>, SinkError> {
        let Some(mut log) = self.log else { return Ok(None) };
        self.last_sample?;
        if let Some(verdict) = &self.verdict {
            log.note(self.last_s, Level::Info, "grasp", verdict)?;
        }
        for warning in &self.warnings {
            log.note(self.last_s, Level::Warning, "run", warning)?;
        }
        match stopped {
            None => log.note(self.last_s, Level::Info, "run", "completed")?,
            Some((time_s, reason)) => log.note(time_s, Level::Error, "run", &format!("stopped: {reason}"))?,
        }
        // Last, because a metadata record ends the chunk.
        if let Some(check) = check {
            log.record(CHECK_NAME, check_entries(check))?;
        }
        log.finish().map(Some)
    }
}

/// All sinks of a run.
struct RunSinks<'a, W: Write + Send + 'static, A> {
    log: Option<ThreadedWriter<W>>,
    criteria_tracker: RunCriteriaTracker,
    audit: EnergyAudit,
    /// Time of the latest sample.
    last_s: f64,
    extra_sink: &'a mut A,
}

impl<W: Write + Send + 'static, A: Sink> Sink for RunSinks<'_, W, A> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.last_s = sample.time_s;
        self.criteria_tracker.sample(sample)?;
        self.audit.sample(sample)?;
        self.extra_sink.sample(sample)?;
        self.log.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.criteria_tracker.event(event)?;
        self.extra_sink.event(event)?;
        self.log.event(event)
    }

    fn should_continue(&self) -> bool {
        self.extra_sink.should_continue()
    }
}
