//! A run of a gripper ends where its object has been thrown out: nothing of it comes back.

use super::{BodyState, Event, Outcome, RunError, Sample, Sink, SinkError, Wants};
use crate::numeric::elementary::hypot;
use crate::scene::System;
use crate::shape::reach;

/// How far from the palm's middle an object has left the gripper, in its reaches (radii of a disc).
pub const EJECTED_RADII: f64 = 3.0;

/// Runs a gripper with `run`, which gets `sink`, up to where the object is ejected; [`Outcome::ejected_s`] says when.
pub(super) fn up_to_ejection(
    system: &System,
    sink: &mut dyn Sink,
    run: impl FnOnce(&mut dyn Sink) -> Result<Outcome, RunError>,
) -> Result<Outcome, RunError> {
    let far_m = EJECTED_RADII * system.object().map_or(f64::INFINITY, |object| reach(&object.shape));
    let mut watch = Watch { sink, far_m, before: (0.0, 0.0), ejected_s: None };
    let result = run(&mut watch);
    let ejected_s = watch.ejected_s;
    match result {
        Ok(outcome) => Ok(Outcome { ejected_s, ..outcome }),
        Err(RunError::Simulation { so_far, .. }) if ejected_s.is_some() => Ok(Outcome { ejected_s, ..*so_far }),
        Err(error) => Err(error),
    }
}

struct Watch<'a> {
    sink: &'a mut dyn Sink,
    far_m: f64,
    /// Time and distance of the sample before.
    before: (f64, f64),
    ejected_s: Option<f64>,
}

impl Watch<'_> {
    fn look(&mut self, sample: &Sample) {
        let Some(BodyState { centre_m: [x, y], .. }) = sample.bodies.first() else { return };
        let (time_s, distance_m) = (sample.time_s, hypot(*x, *y));
        if distance_m > self.far_m && self.ejected_s.is_none() {
            let (before_s, before_m) = self.before;
            let part = ((self.far_m - before_m) / (distance_m - before_m)).clamp(0.0, 1.0);
            self.ejected_s = Some(before_s + part * (time_s - before_s));
        }
        self.before = (time_s, distance_m);
    }
}

impl Sink for Watch<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.look(sample);
        self.sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.sink.event(event)
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.look(sample);
        self.sink.extreme(sample)
    }

    fn wants(&self) -> Wants {
        self.sink.wants()
    }

    fn proceed(&self) -> bool {
        self.ejected_s.is_none() && self.sink.proceed()
    }
}
