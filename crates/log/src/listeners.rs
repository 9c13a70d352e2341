//! A run with everything that listens to it. `phalanx run`, `validate --out`, `replay --verify` and [`run_to`](super::run_to)
//! all go through here, so that what a log should hold is decided in one place.

use std::io::Write;
use std::time::Instant;

use super::beside::Beside;
use super::core::Severity;
use super::metadata::{CHECK_NAME, check_entries};
use phalanx_core::check::Check;
use phalanx_core::criteria::{Criteria, GraspCriteria, Judge, Judged, LinkOverlap, Rebound, fate_reason};
use phalanx_core::invariants::EnergyAudit;
use phalanx_core::scene::Scene;
use phalanx_core::trace::{Event, Model, Outcome, RunError, Sample, Sink, SinkError, Thinned, run};

/// A run that is over, and its log, which is not.
pub struct Ran<W: Write + Send + 'static> {
    pub result: Result<Outcome, RunError>,
    /// Of a finger, if it can grasp its object and the run was completed.
    pub criteria: Option<Criteria>,
    /// Of a gripper.
    pub grasp: Option<GraspCriteria>,
    /// Of every pair of discs; empty where there is a finger.
    pub rebounds: Vec<Rebound>,
    /// Sentences on what makes the results doubtful; the log has them too.
    pub warnings: Vec<String>,
    /// Time of the latest sample.
    pub last_s: f64,
    pub wall_s: f64,
    pub log: Open<W>,
}

/// A log that waits for what is said in the end.
pub struct Open<W: Write + Send + 'static> {
    log: Option<Beside<W>>,
    /// Whether the last sample could be passed on.
    last: Result<(), SinkError>,
    last_s: f64,
    /// What is to be said of the grasp.
    verdict: Option<String>,
    warnings: Vec<String>,
}

/// Simulates a scene; `also` gets what the log gets, and is asked whether the run may go on.
pub fn simulate<W: Write + Send + 'static>(
    model: Model,
    scene: &Scene,
    log: Option<Beside<W>>,
    also: &mut impl Sink,
) -> Ran<W> {
    let audit = EnergyAudit::new(model, scene);
    let listeners = Listeners { log, judge: Judge::of(scene), audit, last_s: 0.0, also };
    let mut thinned = Thinned::new(scene.log.numeric_hz, listeners);
    let start = Instant::now();
    let result = run(model, scene, &mut thinned);
    let wall_s = start.elapsed().as_secs_f64();
    let last = thinned.end();
    let Listeners { log, judge, audit, last_s, .. } = thinned.sink;
    let Judged { criteria, grasp, rebounds, overlaps } = judge.judged(result.is_ok());
    let fate =
        |found: &GraspCriteria| format!("{}: {}", found.fate.name(), fate_reason(found, scene.thresholds.held_time_s));
    let said = criteria.as_ref().map(Criteria::verdict).or_else(|| grasp.as_ref().filter(|_| result.is_ok()).map(fate));
    let energy = audit.breach().map(|breach| breach.to_string());
    let warnings: Vec<String> = energy.into_iter().chain(overlaps.iter().map(LinkOverlap::sentence)).collect();
    let log = Open { log, last, last_s, verdict: said, warnings: warnings.clone() };
    Ran { result, criteria, grasp, rebounds, warnings, last_s, wall_s, log }
}

impl<W: Write + Send + 'static> Open<W> {
    /// Says in the log how the run ended (`stopped`: when, and why, if before its time) and finishes it.
    pub fn close(self, stopped: Option<(f64, &str)>, check: Option<&Check>) -> Result<Option<W>, SinkError> {
        let Some(mut log) = self.log else { return Ok(None) };
        self.last?;
        if let Some(verdict) = &self.verdict {
            log.note(self.last_s, Severity::Info, "grasp", verdict)?;
        }
        for warning in &self.warnings {
            log.note(self.last_s, Severity::Warning, "run", warning)?;
        }
        match stopped {
            None => log.note(self.last_s, Severity::Info, "run", "completed")?,
            Some((time_s, reason)) => log.note(time_s, Severity::Error, "run", &format!("stopped: {reason}"))?,
        }
        // Last of all: it ends a chunk.
        if let Some(check) = check {
            log.record(CHECK_NAME, check_entries(check))?;
        }
        log.finish().map(Some)
    }
}

/// Everything that listens to a run.
struct Listeners<'a, W: Write + Send + 'static, A> {
    log: Option<Beside<W>>,
    judge: Judge,
    audit: EnergyAudit,
    /// Time of the latest sample.
    last_s: f64,
    /// Whoever else wants what the log gets.
    also: &'a mut A,
}

impl<W: Write + Send + 'static, A: Sink> Sink for Listeners<'_, W, A> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.last_s = sample.time_s;
        self.judge.sample(sample)?;
        self.audit.sample(sample)?;
        self.also.sample(sample)?;
        self.log.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.judge.event(event)?;
        self.also.event(event)?;
        self.log.event(event)
    }

    fn proceed(&self) -> bool {
        self.also.proceed()
    }
}
