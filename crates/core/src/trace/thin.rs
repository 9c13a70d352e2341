//! What of a run is kept: the even grid of samples, and every step of the integrator within an impact.
//!
//! Models give more: every step that is shorter than the grid's interval, of which free flight and settled contacts need
//! none. The criteria of `phalanx run` are found on what is kept, so that a log says of its run what the run said itself.

use super::grid::is_point;
use super::{Event, Sample, Sink, SinkError};

/// An impact lasts as long as some force changes by more than this part of itself in an interval of the grid…
const CHANGE: f64 = 0.1;
/// …and this part of an interval longer, so that it does not end where the force is largest.
const LINGER: f64 = 0.25;

/// Picks samples out of a stream; at most two of one given.
///
/// Kept are: the first and the last; those on the grid; all within an impact, the one before it, and the one after an
/// event; and each at which a force or a penetration has a maximum larger than any kept before.
#[derive(Clone, Debug)]
pub struct Thin {
    interval_s: f64,
    /// End of the impact.
    until_s: f64,
    latest: Option<Sample>,
    /// Whether `latest` has been kept.
    is_kept: bool,
    after_event: bool,
    /// Largest force and penetration kept of each contact.
    kept: Vec<(f64, f64)>,
}

impl Thin {
    /// Thins to `numeric_hz` samples a second.
    pub fn new(numeric_hz: f64) -> Self {
        Thin {
            interval_s: 1.0 / numeric_hz,
            until_s: f64::NEG_INFINITY,
            latest: None,
            is_kept: true,
            after_event: true,
            kept: Vec::new(),
        }
    }

    /// Takes a sample; hands to `keep` what is to be kept, in order of time.
    pub fn sample<E>(&mut self, sample: &Sample, mut keep: impl FnMut(&Sample) -> Result<(), E>) -> Result<(), E> {
        let first = self.latest.is_none();
        if first {
            self.kept = vec![(0.0, 0.0); sample.contacts.len()];
        }
        let now_s = sample.time_s;
        // An extreme at the end of a step comes again before an event there.
        if self.latest.as_ref().is_some_and(|latest| latest.time_s == now_s && latest == sample) {
            return Ok(());
        }
        let (mut changes, mut falls) = (false, false);
        if let Some(before) = &self.latest {
            for ((before_it, now), kept) in before.contacts.iter().zip(&sample.contacts).zip(&self.kept) {
                let ((f0, d0), (f1, d1)) = (before_it.pressed(), now.pressed());
                let rate = (f1 - f0).abs() * self.interval_s;
                changes |= rate > CHANGE * f0.max(f1) * (now_s - before.time_s);
                falls |= (f0 > kept.0 && f1 < f0) || (d0 > kept.1 && d1 < d0);
            }
        }
        if changes {
            self.until_s = now_s + LINGER * self.interval_s;
        }
        if changes || falls {
            self.flush(&mut keep)?;
        }
        let on_grid = is_point(now_s, self.interval_s);
        match &mut self.latest {
            Some(latest) => latest.clone_from(sample),
            None => self.latest = Some(sample.clone()),
        }
        self.is_kept = false;
        if first || on_grid || self.after_event || now_s <= self.until_s { self.flush(keep) } else { Ok(()) }
    }

    /// Before an event: the latest sample is kept, for rates can jump behind it, and so will be the next.
    pub fn event<E>(&mut self, keep: impl FnMut(&Sample) -> Result<(), E>) -> Result<(), E> {
        self.flush(keep)?;
        self.after_event = true;
        Ok(())
    }

    /// Keeps the latest sample: at the end of a run.
    pub fn flush<E>(&mut self, mut keep: impl FnMut(&Sample) -> Result<(), E>) -> Result<(), E> {
        let Some(latest) = self.latest.as_ref().filter(|_| !self.is_kept) else {
            return Ok(());
        };
        for (contact, kept) in latest.contacts.iter().zip(&mut self.kept) {
            let (force, depth) = contact.pressed();
            *kept = (kept.0.max(force), kept.1.max(depth));
        }
        (self.is_kept, self.after_event) = (true, false);
        keep(latest)
    }
}

/// A sink that passes on what [`Thin`] keeps.
#[derive(Clone, Debug)]
pub struct Thinned<S> {
    thin: Thin,
    pub sink: S,
}

impl<S> Thinned<S> {
    /// Thins to `numeric_hz` samples a second.
    pub fn new(numeric_hz: f64, sink: S) -> Self {
        Thinned { thin: Thin::new(numeric_hz), sink }
    }
}

impl<S: Sink> Thinned<S> {
    /// Passes on the last sample, when the run is over.
    pub fn end(&mut self) -> Result<(), SinkError> {
        self.thin.flush(|kept| self.sink.sample(kept))
    }
}

impl<S: Sink> Sink for Thinned<S> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.thin.sample(sample, |kept| self.sink.sample(kept))
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.thin.sample(sample, |kept| self.sink.sample(kept))
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        // Nothing jumps where friction begins to slip: no sample is due but those that come before.
        match event.kind.is_of_friction() {
            true => self.thin.flush(|kept| self.sink.sample(kept))?,
            false => self.thin.event(|kept| self.sink.sample(kept))?,
        }
        self.sink.event(event)
    }

    fn proceed(&self) -> bool {
        self.sink.proceed()
    }
}
