//! Selection of the samples of a run: [`Decimated`] for logs and tables, [`OffGrid`] for criteria.
//!
//! Models emit the ends of all steps, and samples on the grid if a sink needs them. Criteria ignore the grid, so that
//! they are the same with and without a log, and when they are evaluated on the samples of a log.

use super::grid::is_grid_point;
use super::{Event, RequiredData, Sample, Sink, SinkError};

/// Smallest change of a contact force during an impact, per grid interval, as a fraction of the force.
const MIN_FORCE_CHANGE: f64 = 0.1;
/// An impact is extended by this fraction of a grid interval, so that it does not end at the maximum of the force.
const IMPACT_EXTENSION: f64 = 0.25;

/// A sink that forwards selected samples of a run, and all events.
///
/// The first and the last sample are kept, and all samples on the grid. Of the other samples, it keeps:
/// * those within an impact, and the one before the impact,
/// * those before and after an event, or where a cable leaves a pulley or returns, and at each crossing of a threshold,
/// * those at which a force or a penetration has a larger maximum than in any sample kept before,
/// * one per grid interval.
///
/// This selection does not depend on whether there are samples on the grid.
#[derive(Clone, Debug)]
pub struct Decimated<S> {
    interval_s: f64,
    /// End of the current impact.
    impact_end_s: f64,
    /// The latest sample off the grid.
    latest: Option<Sample>,
    /// Whether `latest` has been emitted.
    is_emitted: bool,
    /// Time of the last emitted sample off the grid.
    emitted_s: f64,
    after_event: bool,
    /// Largest emitted force and penetration of each contact.
    emitted_peaks: Vec<(f64, f64)>,
    /// Samples on the grid after `latest`; the buffers after the first `pending` are unused.
    on_grid: Vec<Sample>,
    pending: usize,
    pub sink: S,
}

impl<S: Sink> Decimated<S> {
    /// Creates a decimator that forwards `numeric_hz` samples per second to `sink`.
    pub fn new(numeric_hz: f64, sink: S) -> Self {
        Decimated {
            interval_s: 1.0 / numeric_hz,
            impact_end_s: f64::NEG_INFINITY,
            latest: None,
            is_emitted: true,
            emitted_s: f64::NEG_INFINITY,
            after_event: true,
            emitted_peaks: Vec::new(),
            on_grid: Vec::new(),
            pending: 0,
            sink,
        }
    }

    /// Forwards the last sample at the end of the run.
    pub fn end(&mut self) -> Result<(), SinkError> {
        self.emit_latest()?;
        self.emit_grid()
    }

    /// Emits the latest sample off the grid, unless that has been done.
    fn emit_latest(&mut self) -> Result<(), SinkError> {
        let Some(latest) = self.latest.as_ref().filter(|_| !self.is_emitted) else {
            return Ok(());
        };
        for (contact, emitted) in self.emitted_peaks.iter_mut().enumerate() {
            let (force, depth) = latest.force_and_penetration(contact);
            *emitted = (emitted.0.max(force), emitted.1.max(depth));
        }
        (self.is_emitted, self.after_event, self.emitted_s) = (true, false, latest.time_s);
        self.sink.sample(latest)
    }

    /// Emits the pending samples on the grid.
    fn emit_grid(&mut self) -> Result<(), SinkError> {
        let pending = std::mem::take(&mut self.pending);
        self.on_grid[..pending].iter().try_for_each(|sample| self.sink.sample(sample))
    }

    /// Buffers a sample on the grid until it is known whether the latest sample before it is kept.
    fn push_grid(&mut self, sample: &Sample) {
        match self.on_grid.get_mut(self.pending) {
            Some(buffer) => buffer.clone_from(sample),
            None => self.on_grid.push(sample.clone()),
        }
        self.pending += 1;
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
        let previous = self.on_grid[..self.pending].last().or(self.latest.as_ref());
        if previous.is_some_and(|previous| previous.time_s == now_s && previous == sample) {
            return Ok(());
        }
        if !is_first && is_grid_point(now_s, self.interval_s) {
            self.push_grid(sample);
            return Ok(());
        }
        let (mut in_impact, mut past_peak, mut changes) = (false, false, false);
        if let Some(before) = &self.latest {
            for (contact, emitted) in self.emitted_peaks.iter().enumerate() {
                let ((f0, d0), (f1, d1)) =
                    (before.force_and_penetration(contact), sample.force_and_penetration(contact));
                let change_per_interval = (f1 - f0).abs() * self.interval_s;
                in_impact |= change_per_interval > MIN_FORCE_CHANGE * f0.max(f1) * (now_s - before.time_s);
                past_peak |= (f0 > emitted.0 && f1 < f0) || (d0 > emitted.1 && d1 < d0);
            }
            let mut places = 0..sample.counts().elements;
            changes = places.any(|place| before.cable_element(place).on != sample.cable_element(place).on);
        }
        if in_impact {
            self.impact_end_s = now_s + IMPACT_EXTENSION * self.interval_s;
        }
        if in_impact || past_peak || changes {
            self.emit_latest()?;
        }
        self.emit_grid()?;
        match &mut self.latest {
            Some(latest) => latest.clone_from(sample),
            None => self.latest = Some(sample.clone()),
        }
        self.is_emitted = false;
        if self.after_event || changes || now_s <= self.impact_end_s || now_s - self.emitted_s >= self.interval_s {
            self.emit_latest()
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

/// A sink that forwards the samples of a decimated run, or of its log, that are not on the grid. The first sample, the
/// last one, and samples at the time of an event are always forwarded.
#[derive(Clone, Debug)]
pub struct OffGrid<S> {
    interval_s: f64,
    has_started: bool,
    /// The latest sample, if it is on the grid; otherwise an unused buffer.
    latest: Sample,
    is_pending: bool,
    pub sink: S,
}

impl<S: Sink> OffGrid<S> {
    /// Creates a sink that forwards samples to `sink` if they are not on a grid of `numeric_hz` samples per second.
    pub fn new(numeric_hz: f64, sink: S) -> Self {
        let (interval_s, latest) = (1.0 / numeric_hz, Sample::default());
        OffGrid { interval_s, has_started: false, latest, is_pending: false, sink }
    }

    /// Forwards the last sample at the end of the run.
    pub fn end(&mut self) -> Result<(), SinkError> {
        if std::mem::take(&mut self.is_pending) { self.sink.sample(&self.latest) } else { Ok(()) }
    }
}

impl<S: Sink> Sink for OffGrid<S> {
    fn required_data(&self) -> RequiredData {
        self.sink.required_data()
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.is_pending = self.has_started && is_grid_point(sample.time_s, self.interval_s);
        self.has_started = true;
        if self.is_pending {
            self.latest.clone_from(sample);
            return Ok(());
        }
        self.sink.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        if self.is_pending && self.latest.time_s == event.time_s {
            self.end()?;
        }
        self.sink.event(event)
    }

    fn should_continue(&self) -> bool {
        self.sink.should_continue()
    }
}
