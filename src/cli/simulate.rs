//! One simulation as a command makes it, `phalanx run`, `validate --out` or `replay --verify`: with a line that says how far it
//! has come, ended by a signal. What its log holds and what is reported of it is decided in the library.

use crate::scene::words::SceneKind;
use std::io::Write;

use super::interrupt::Interrupt;
use super::output::complain;
use super::progress::Progress;
use crate::criteria::{AtRest, at_rest};
use crate::log::Beside;
pub(super) use crate::report::simulated::{Broken, Checking, Finished};
use crate::report::simulated::{Making, simulated};
use crate::scene::Scene;
use crate::trace::{Event, Model, Sample, Sink, SinkError};

/// What ends a run before its time: a signal, or that it is past what anybody wants to know.
pub(super) struct Limits<'a> {
    pub interrupt: &'a Interrupt,
    /// The run may end after the first sample beyond.
    pub until_s: f64,
    pub checking: Checking,
}

/// Simulates a scene.
pub(super) fn simulate<W: Write + Send + 'static>(
    model: Model,
    scene: &Scene,
    log: Option<Beside<W>>,
    limits: &Limits<'_>,
    also: &mut impl Sink,
) -> Finished<W> {
    if scene.kind() == SceneKind::Finger {
        grasp(scene);
    }
    let mut watched = Watched::new(scene.duration_s, limits, also);
    let making = Making {
        checking: limits.checking,
        go_on: &|| limits.interrupt.signal().is_none(),
        reason: &|reason| limits.interrupt.reason(reason),
    };
    let finished = simulated(model, scene, log, &making, &mut watched);
    watched.progress.clear();
    finished
}

/// The grasp at rest that a run is judged by; `None`, and said why, if the criteria make no sense for this scene.
pub(super) fn grasp(scene: &Scene) -> Option<AtRest> {
    at_rest(scene, scene.object()?)
        .map_err(|error| complain(&format!("no dynamic criteria, for the finger cannot grasp this object: {error}")))
        .ok()
}

/// What the command line adds to those who listen to a run: how far it has come, and that it may be ended.
struct Watched<'a, A> {
    /// Time of the latest sample.
    last_s: f64,
    progress: Progress,
    limits: &'a Limits<'a>,
    /// Whoever else wants what the log gets.
    also: &'a mut A,
}

impl<'a, A> Watched<'a, A> {
    fn new(duration_s: f64, limits: &'a Limits<'a>, also: &'a mut A) -> Self {
        // A run may end before it is over.
        let progress = Progress::new(duration_s.min(limits.until_s));
        Watched { last_s: 0.0, progress, limits, also }
    }
}

impl<A: Sink> Sink for Watched<'_, A> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.last_s = sample.time_s;
        Sink::sample(&mut self.progress, sample)?;
        self.also.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.also.event(event)
    }

    fn proceed(&self) -> bool {
        self.last_s <= self.limits.until_s && self.limits.interrupt.signal().is_none()
    }
}
