//! `phalanx run` of a scene of discs.

use std::time::Instant;

use super::interrupt::Interrupt;
use super::output::print;
use super::progress::Progress;
use super::run::{RunArgs, finish_log, kept, started, stopped};
use super::{Failure, Status};
use crate::criteria::Rebounds;
use crate::log::{BodiesChannels, FileWriter};
use crate::report::{self, BodiesReport};
use crate::scene::BodiesScene;
use crate::trace::SinkError;
use crate::trace::bodies::{BodiesEvent, BodiesRunError, BodiesSample, BodiesSink, run_bodies};

/// Runs the command.
pub fn run(args: &RunArgs, mut scene: BodiesScene) -> Result<Status, Failure> {
    args.overrides.apply_bodies(args.model, &mut scene)?;
    let interrupt = Interrupt::listen()?;
    let live = args.live.start(&scene.name, scene.duration_s, &interrupt)?;
    let mut sinks = Sinks {
        log: started(args, &scene, live.as_ref(), &interrupt)?,
        rebounds: Rebounds::new(scene.pairs().len()),
        last_s: 0.0,
        progress: Progress::new(scene.duration_s),
        interrupt: &interrupt,
    };

    let start = Instant::now();
    let result = run_bodies(args.model, &scene, &mut sinks);
    let wall_s = start.elapsed().as_secs_f64();
    sinks.progress.clear();

    let (outcome, error) = match &result {
        Ok(outcome) => (Some(outcome), None),
        Err(BodiesRunError::Simulation { failure, so_far }) => {
            let error = report::Failure { time_s: failure.time_s, reason: interrupt.reason(&failure.reason) };
            (Some(so_far.as_ref()), Some(error))
        }
        Err(BodiesRunError::Sink(error)) => {
            (None, Some(report::Failure { time_s: sinks.last_s, reason: error.to_string() }))
        }
    };
    let mut report = BodiesReport::new(&scene, args.model, wall_s, outcome, sinks.rebounds.pairs(), error);
    report.log = args.log.as_ref().map(|path| path.display().to_string());

    let finished = finish_log(sinks.log, sinks.last_s, report.error.as_ref());
    print(&match args.json {
        true => report::bodies_json(&report),
        false => report::bodies_text(&report),
    })?;
    if let Some(live) = live {
        live.end();
    }
    match (&report.error, finished) {
        (Some(error), finished) => {
            Err(Failure::incomplete(stopped(error, scene.duration_s) + &kept(args, finished.is_ok())))
        }
        (None, Err(error)) => Err(Failure::incomplete(format!("{error}{}", kept(args, false)))),
        (None, Ok(())) => Ok(Status::Done),
    }
}

/// Everything that listens to a run.
struct Sinks<'a> {
    log: Option<FileWriter<BodiesChannels>>,
    rebounds: Rebounds,
    /// Time of the latest sample.
    last_s: f64,
    progress: Progress,
    interrupt: &'a Interrupt,
}

impl BodiesSink for Sinks<'_> {
    fn sample(&mut self, sample: &BodiesSample) -> Result<(), SinkError> {
        self.last_s = sample.time_s;
        self.progress.sample(sample)?;
        self.rebounds.sample(sample)?;
        match &mut self.log {
            Some(log) => log.sample(sample),
            None => Ok(()),
        }
    }

    fn event(&mut self, event: &BodiesEvent) -> Result<(), SinkError> {
        self.rebounds.event(event)?;
        match &mut self.log {
            Some(log) => log.event(event),
            None => Ok(()),
        }
    }

    fn proceed(&self) -> bool {
        self.interrupt.signal().is_none()
    }
}
