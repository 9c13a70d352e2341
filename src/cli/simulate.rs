//! One simulation of `phalanx run`, `validate --out` or `replay --verify`, with a progress line and interruption by
//! signals. The library determines the contents of logs and reports.

use std::io::Write;

use super::interrupt::Interrupt;
use super::output::print_diagnostic;
use super::progress::Progress;
use crate::criteria::static_grasp;
use crate::log::ThreadedWriter;
pub(super) use crate::report::simulation::{CheckPolicy, SimulatedRun};
use crate::report::simulation::{SimulationOptions, simulate_and_check};
use crate::scene::Scene;
use crate::scene::keywords::SceneKind;
use crate::trace::{Event, Model, Sample, Sink, SinkError};

/// Conditions that end a run early, and whether to check it.
pub(super) struct RunLimits<'a> {
    pub interrupt: &'a Interrupt,
    /// The run may end after the first sample beyond this time.
    pub until_s: f64,
    pub check_policy: CheckPolicy,
}

/// Simulates a scene.
pub(super) fn simulate<W: Write + Send + 'static>(
    model: Model,
    scene: &Scene,
    log: Option<ThreadedWriter<W>>,
    limits: &RunLimits<'_>,
    other_sink: &mut impl Sink,
) -> SimulatedRun<W> {
    let object = scene.object().filter(|_| scene.kind() == SceneKind::Finger);
    if let Some(Err(error)) = object.map(|object| static_grasp(scene, object)) {
        print_diagnostic(&format!("no dynamic criteria, because the finger cannot grasp this object: {error}"));
    }
    // The run may end before the duration of the scene.
    let progress = Progress::new(scene.duration_s.min(limits.until_s));
    let mut monitored_sink = MonitoredSink { last_s: 0.0, progress, limits, other_sink };
    let options = SimulationOptions {
        check_policy: limits.check_policy,
        keep_running: &|| limits.interrupt.signal().is_none(),
        describe_reason: &|reason| limits.interrupt.describe_reason(reason),
    };
    let run = simulate_and_check(model, scene, log, &options, &mut monitored_sink);
    monitored_sink.progress.clear();
    run
}

/// Adds a progress line and interruption to the sinks of a run.
struct MonitoredSink<'a, A> {
    /// Time of the last sample.
    last_s: f64,
    progress: Progress,
    limits: &'a RunLimits<'a>,
    /// Sink that receives the same data as the log.
    other_sink: &'a mut A,
}

impl<A: Sink> Sink for MonitoredSink<'_, A> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.last_s = sample.time_s;
        self.progress.update(sample.time_s);
        self.other_sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.other_sink.event(event)
    }

    fn should_continue(&self) -> bool {
        self.last_s <= self.limits.until_s && self.limits.interrupt.signal().is_none()
    }
}
