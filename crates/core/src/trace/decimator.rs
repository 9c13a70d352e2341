//! Decimation of a run: keeps the samples on a uniform grid, and every integrator step within an impact.
//!
//! Models emit every step that is shorter than the grid interval; free flight and settled contacts do not need that
//! resolution. A run with a log evaluates its criteria on the decimated samples, so that the log yields the same results.
//! A run without one has no samples on the grid, and its criteria may differ in the last digits.

use super::grid::is_point;
use super::{Event, RequiredData, Sample, Sink, SinkError};

/// Smallest change of a contact force during an impact, per grid interval, as a fraction of the force.
const MIN_FORCE_CHANGE: f64 = 0.1;
/// An impact is extended by this fraction of a grid interval, so that it does not end at the maximum of the force.
const IMPACT_EXTENSION: f64 = 0.25;

/// A sink that forwards selected samples of a run, at most two per sample, and all events.
///
/// If the sink does not need samples on the grid, all are forwarded. Otherwise it keeps the first and the last
/// sample, samples on the grid, all samples within an impact and the one before it, the sample after an event, each
/// crossing of a threshold, and each sample at which a force or a penetration has a maximum larger than any kept
/// before.
#[derive(Clone, Debug)]
pub struct Decimated<S> {
    interval_s: f64,
    /// End of the current impact.
    impact_end_s: f64,
    latest: Option<Sample>,
    /// Whether `latest` has been emitted.
    is_emitted: bool,
    /// Whether every sample is forwarded, because no sink needs the grid.
    keeps_all: bool,
    after_event: bool,
    /// Largest emitted force and penetration of each contact.
    emitted_peaks: Vec<(f64, f64)>,
    pub sink: S,
}

impl<S: Sink> Decimated<S> {
    /// Decimates a run to `numeric_hz` samples per second for `sink`, unless the sink does not need samples on the grid.
    pub fn new(numeric_hz: f64, sink: S) -> Self {
        Decimated {
            interval_s: 1.0 / numeric_hz,
            impact_end_s: f64::NEG_INFINITY,
            latest: None,
            is_emitted: true,
            keeps_all: !sink.required_data().grid,
            after_event: true,
            emitted_peaks: Vec::new(),
            sink,
        }
    }

    /// Forwards the last sample at the end of the run.
    pub fn end(&mut self) -> Result<(), SinkError> {
        let Some(latest) = self.latest.as_ref().filter(|_| !self.is_emitted) else {
            return Ok(());
        };
        for (contact, emitted) in latest.contacts().zip(&mut self.emitted_peaks) {
            let (force, depth) = contact.force_and_penetration();
            *emitted = (emitted.0.max(force), emitted.1.max(depth));
        }
        (self.is_emitted, self.after_event) = (true, false);
        self.sink.sample(latest)
    }
}

impl<S: Sink> Sink for Decimated<S> {
    fn required_data(&self) -> RequiredData {
        // Decimation uses the peaks of contact forces.
        RequiredData { peaks: true, ..self.sink.required_data() }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let is_first = self.latest.is_none();
        if is_first {
            self.emitted_peaks = vec![(0.0, 0.0); sample.counts().contacts];
        }
        let now_s = sample.time_s;
        // An extremum at the end of a step is repeated before an event at the same time.
        if self.latest.as_ref().is_some_and(|latest| latest.time_s == now_s && latest == sample) {
            return Ok(());
        }
        let (mut in_impact, mut past_peak) = (false, false);
        if let Some(before) = &self.latest {
            for ((contact_before, contact_now), emitted) in
                before.contacts().zip(sample.contacts()).zip(&self.emitted_peaks)
            {
                let ((f0, d0), (f1, d1)) =
                    (contact_before.force_and_penetration(), contact_now.force_and_penetration());
                let change_per_interval = (f1 - f0).abs() * self.interval_s;
                in_impact |= change_per_interval > MIN_FORCE_CHANGE * f0.max(f1) * (now_s - before.time_s);
                past_peak |= (f0 > emitted.0 && f1 < f0) || (d0 > emitted.1 && d1 < d0);
            }
        }
        if in_impact {
            self.impact_end_s = now_s + IMPACT_EXTENSION * self.interval_s;
        }
        if in_impact || past_peak {
            self.end()?;
        }
        let is_on_grid = is_point(now_s, self.interval_s);
        match &mut self.latest {
            Some(latest) => latest.clone_from(sample),
            None => self.latest = Some(sample.clone()),
        }
        self.is_emitted = false;
        if is_first || is_on_grid || self.keeps_all || self.after_event || now_s <= self.impact_end_s {
            self.end()
        } else {
            Ok(())
        }
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sample(sample)
    }

    fn crossing(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.sample(sample)?;
        self.end()
    }

    /// Keeps the sample before an event, and the next one, because rates can jump at the event; not at the onset of
    /// slip, where no rate jumps.
    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.end()?;
        self.after_event |= !event.kind.is_friction_event();
        self.sink.event(event)
    }

    fn should_continue(&self) -> bool {
        self.sink.should_continue()
    }
}
