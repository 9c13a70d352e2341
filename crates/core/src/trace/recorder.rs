//! Converts the steps of the analytic model into samples, events and summary figures.

use super::contact_tracker::{ContactTracker, ReportedEvent, has_surface_touched, update_summaries};
use super::extrema::{BISECTIONS, MIN_SEARCHED_FORCE_FRACTION, StepExtrema, bisect, parabola_peak};
use super::grid::{Grid, Span};
use super::reading::Reader;
use super::{ContactSummary, Energy, EventKind, Outcome, Reach, RequiredData, Sample, Sink, SinkError, Work};
use crate::analytic::ContactState;
use crate::integrator::{Observer, State, Step, StepTools};

/// Interior of one step: its mode, states inside it, and the normal impulses at the last sample.
struct Interior<'a, M, const N: usize, const Z: usize> {
    step: &'a Step<'a, N, Z>,
    mode: &'a M,
    tools: &'a mut dyn StepTools<N, Z>,
    impulses: [f64; Z],
    contacts: usize,
}

impl<M, const N: usize, const Z: usize> Interior<'_, M, N, Z> {
    fn time_s(&self, theta: f64) -> f64 {
        self.step.t0 + theta * self.step.h
    }

    /// Returns a state within the step, computed by a separate step that ends there. Its integrals differ slightly from
    /// those of the step. Normal impulses must not decrease, so they are clamped between the previous sample and the
    /// end of the step.
    fn resolve(&mut self, theta: f64) -> State<N, Z> {
        let mut state = self.tools.resolve(theta);
        for (index, before) in self.impulses.iter_mut().enumerate().take(self.contacts) {
            *before = state.z[index].min(self.step.end.z[index]).max(*before);
            state.z[index] = *before;
        }
        state
    }
}

/// Observer that records a run of the analytic model.
pub(super) struct Recorder<'a, R: Reader<N, Z>, const N: usize, const Z: usize> {
    reader: &'a R,
    sink: &'a mut dyn Sink,
    required_data: RequiredData,
    grid: Grid,
    end_s: f64,
    /// Region whose boundary ends the run.
    reach: Option<Reach>,
    /// Time at which the object left the region.
    ejected_s: Option<f64>,
    mode: R::Mode,
    start_energy: Energy,
    trackers: Vec<ContactTracker>,
    /// Sample at the end of the last step.
    last: Sample,
    /// State from which `last` was read.
    last_state: State<N, Z>,
    /// Mode from which `last` was read.
    last_mode: R::Mode,
    /// Buffer for the sample at the end of the current step.
    end: Sample,
    /// Buffer for a sample within the step.
    within: Sample,
    /// Time up to which samples have been emitted.
    emitted_s: f64,
    peaks: StepExtrema<()>,
    error: Option<SinkError>,
}

impl<'a, R: Reader<N, Z>, const N: usize, const Z: usize> Recorder<'a, R, N, Z> {
    pub fn new(
        reader: &'a R,
        mode: R::Mode,
        start: &State<N, Z>,
        (span, reach): (Span, Option<Reach>),
        sink: &'a mut dyn Sink,
    ) -> Self {
        let mut last = Sample::default();
        reader.read(0.0, start, &mode, &Energy::default(), RequiredData::ALL, &mut last);
        let start_energy = last.energy();
        reader.read(0.0, start, &mode, &start_energy, RequiredData::ALL, &mut last);
        Self {
            reader,
            required_data: sink.required_data(),
            sink,
            grid: Grid::new(span),
            end_s: span.end_s,
            reach,
            ejected_s: None,
            mode,
            start_energy,
            trackers: vec![ContactTracker::default(); last.counts().contacts],
            last,
            last_state: *start,
            last_mode: mode,
            end: Sample::default(),
            within: Sample::default(),
            emitted_s: 0.0,
            peaks: StepExtrema::default(),
            error: None,
        }
    }

    /// Emits the touch-downs of contacts that exist at the start, and the first sample.
    pub fn begin(&mut self) -> Result<(), SinkError> {
        for (index, tracker) in self.trackers.iter_mut().enumerate() {
            // An overlap is a contact with or without a force; a zero gap is a contact only if it closes.
            if self.mode[index] == ContactState::Free {
                continue;
            }
            let contact = self.last.contact(index);
            let event = tracker.touch_down(0.0, contact.approach_at_start(), 0.0);
            if self.mode[index] == ContactState::Released {
                tracker.summary.update(contact.force_and_penetration());
            }
            self.sink.event(&event.at(0.0, index))?;
        }
        // A start outside the workspace of a loop has no passive angles; the run then ends before its first step.
        if self.last.energy().kinetic_j.is_nan() { Ok(()) } else { self.sink.sample(&self.last) }
    }

    /// Emits the last sample if the run ended between grid points, and returns the summary.
    pub fn finish(mut self, end: &State<N, Z>, work: Work) -> Result<Outcome, SinkError> {
        if let Some(error) = self.error.take() {
            return Err(error);
        }
        if self.emitted_s < self.last.time_s {
            self.sink.sample(&self.last)?;
        }
        if self.required_data != RequiredData::ALL {
            let (state, mode) = (&self.last_state, &self.last_mode);
            self.reader.read(self.last.time_s, state, mode, &self.start_energy, RequiredData::ALL, &mut self.last);
        }
        // The integrator ends one step after the exit.
        let end = if self.ejected_s.is_some() { &self.last_state } else { end };
        let summary = |(index, tracker): (usize, &ContactTracker)| ContactSummary {
            impulse_n_s: end.z[index],
            ..tracker.summary
        };
        let contacts = self.trackers.iter().enumerate().map(summary).collect();
        Ok(Outcome { last: self.last, contacts, work, loop_gap_m: 0.0, ejected_s: self.ejected_s })
    }

    /// Emits the samples of one step: grid points and extrema inside it, and its end if the step is short, an extremum
    /// lies there, or the run is over.
    fn emit_step(&mut self, mut interior: Interior<'_, R::Mode, N, Z>) -> Result<(), SinkError> {
        let (end, step, mode) = (self.last.time_s, interior.step, interior.mode);
        // Damper forces cannot be evaluated on the dense output.
        let has_active_contact = (0..self.trackers.len()).any(|index| mode[index].has_force());
        self.grid.begin_step(end.min(self.end_s));
        while let Some(t) = self.grid.next_before(end.min(self.end_s)) {
            // A fine grid can have millions of points within one step.
            if !self.sink.should_continue() {
                break;
            }
            let theta = (t - step.t0) / step.h;
            self.emit_peaks(&mut interior, theta)?;
            if theta > 0.0 {
                if has_active_contact {
                    self.read_within(t, &interior.resolve(theta), mode);
                    update_summaries(&mut self.trackers, &self.within);
                } else {
                    self.read_within(t, &interior.tools.interpolate(theta), mode);
                }
                self.emitted_s = t;
                self.sink.sample(&self.within)?;
            }
        }
        self.emit_peaks(&mut interior, 1.0)?;
        if self.grid.includes_end(end, step.h) || end >= self.end_s {
            self.emitted_s = end;
            self.sink.sample(&self.last)
        } else if self.peaks.at_end {
            self.sink.extreme(&self.last)
        } else {
            Ok(())
        }
    }

    /// Emits samples at the extrema of the step before `theta`.
    fn emit_peaks(&mut self, interior: &mut Interior<'_, R::Mode, N, Z>, theta: f64) -> Result<(), SinkError> {
        while let Some((theta_peak, ())) = self.peaks.next_before(theta) {
            while self.peaks.next_at(theta_peak).is_some() {}
            let t = interior.time_s(theta_peak);
            if t > self.emitted_s && t < interior.step.t1 {
                self.read_within(t, &interior.resolve(theta_peak), interior.mode);
                update_summaries(&mut self.trackers, &self.within);
                self.sink.extreme(&self.within)?;
            }
        }
        Ok(())
    }

    fn read_within(&mut self, t: f64, state: &State<N, Z>, mode: &R::Mode) {
        self.reader.read(t, state, mode, &self.start_energy, self.required_data, &mut self.within);
    }

    /// Emits slip and stick events of bristle friction: steps end at these events, and the next step has another mode.
    fn record_slip_events(&mut self, time_s: f64, mode: &R::Mode) -> Result<(), SinkError> {
        for (contact, tracker) in self.trackers.iter_mut().enumerate() {
            if let Some(event) = tracker.update_slip(self.reader.is_slipping(contact, mode)) {
                self.sink.event(&event.at(time_s, contact))?;
            }
        }
        Ok(())
    }

    /// Shortens the current step to where the object leaves the reach of the fingers, if something has touched the
    /// object; returns whether it does.
    fn end_at_exit(&mut self, interior: &mut Interior<'_, R::Mode, N, Z>) -> bool {
        let Some(reach) = self.reach.filter(|reach| reach.leaves(&self.last, &self.end)) else { return false };
        if !has_surface_touched(&self.trackers, &self.end) {
            return false;
        }
        let (mut inside, mut outside) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (inside + outside);
            self.read_within(interior.time_s(middle), &interior.tools.resolve(middle), interior.mode);
            if reach.is_outside(&self.within.body(0)) { outside = middle } else { inside = middle }
        }
        if outside < 1.0 {
            (self.last_state, self.last_mode) = (interior.resolve(outside), *interior.mode);
            interior.impulses = interior.step.start.z;
            let (exit_s, state, mode) = (interior.time_s(outside), &self.last_state, interior.mode);
            self.reader.read(exit_s, state, mode, &self.start_energy, self.required_data, &mut self.end);
        }
        self.end_s = self.end.time_s;
        self.ejected_s = Some(self.end_s);
        true
    }

    /// Searches the largest force and penetration within the step from the last sample to its end.
    fn search_peaks(&mut self, mode: &R::Mode, tools: &mut dyn StepTools<N, Z>) {
        self.peaks.clear();
        let length_s = self.end.time_s - self.last.time_s;
        for (index, tracker) in self.trackers.iter_mut().enumerate() {
            // A released contact can still get deeper without a force.
            let is_active = mode[index].has_force();
            if !is_active && mode[index] != ContactState::Released {
                continue;
            }
            let (start, end) = (self.last.contact(index), self.end.contact(index));
            let read = |state: &State<N, Z>| self.reader.contact(state, index, mode);
            let summary = &mut tracker.summary;
            summary.update_max_penetration(-start.gap_m);
            if summary.update_max_penetration(-end.gap_m) {
                self.peaks.push(1.0);
            }
            if start.gap_rate_m_s < 0.0 && end.gap_rate_m_s > 0.0 {
                let deepest = bisect(&mut |theta| -read(&tools.interpolate(theta)).gap_rate_m_s);
                if summary.update_max_penetration(-read(&tools.resolve(deepest)).gap_m) {
                    self.peaks.push(deepest);
                }
            }
            let mut highest = start.normal_n.max(end.normal_n);
            if highest == 0.0 {
                // A force that starts and ends within the step still has a mean.
                highest = (end.impulse_n_s - start.impulse_n_s) / length_s;
            }
            if is_active && highest > MIN_SEARCHED_FORCE_FRACTION * summary.peak_normal_n {
                let mut force = |theta: f64| read(&tools.resolve(theta)).normal_n;
                let (theta, peak) = parabola_peak(start.normal_n, end.normal_n, &mut force);
                if summary.update_peak_force(peak) {
                    self.peaks.push(theta);
                }
            }
        }
        self.peaks.sort();
    }
}

impl<R: Reader<N, Z>, const N: usize, const Z: usize> Observer<N, Z, R::Mode> for Recorder<'_, R, N, Z> {
    fn step(&mut self, step: &Step<N, Z>, mode: &R::Mode, tools: &mut dyn StepTools<N, Z>) -> bool {
        self.mode = *mode;
        (self.last_state, self.last_mode) = (*step.end, *mode);
        if let Err(error) = self.record_slip_events(step.t0, mode) {
            self.error = Some(error);
            return false;
        }
        self.reader.read(step.t1, step.end, mode, &self.start_energy, self.required_data, &mut self.end);
        let (impulses, contacts) = (step.start.z, self.trackers.len());
        let mut interior = Interior { step, mode, tools, impulses, contacts };
        let exits = self.end_at_exit(&mut interior);
        if self.required_data.peaks && !exits {
            self.search_peaks(mode, interior.tools);
        } else {
            self.peaks.clear();
            update_summaries(&mut self.trackers, &self.end);
        }
        std::mem::swap(&mut self.last, &mut self.end);
        if let Err(error) = self.emit_step(interior) {
            self.error = Some(error);
        }
        self.error.is_none() && self.ejected_s.is_none() && self.sink.should_continue()
    }

    fn event(&mut self, t: f64, state: &State<N, Z>, index: usize, mode: &R::Mode) {
        let was_separated = self.last.contact(index).gap_m > 0.0 || !matches!(self.mode[index], ContactState::Released);
        let kind = match mode[index] {
            ContactState::Active if was_separated => EventKind::TouchDown,
            ContactState::Active => EventKind::Reload,
            _ => EventKind::LiftOff,
        };
        let (tracker, impulse) = (&mut self.trackers[index], state.z[index]);
        let event = match kind {
            EventKind::TouchDown => {
                let approach = -self.reader.contact(state, index, mode).gap_rate_m_s;
                tracker.touch_down(t, approach, impulse)
            }
            EventKind::LiftOff => tracker.lift_off(impulse),
            EventKind::Reload | EventKind::Slips | EventKind::Sticks => ReportedEvent::of_kind(kind),
        };
        self.mode = *mode;
        // Rates jump after an event: interpolation needs the sample just before it.
        let emitted = if self.emitted_s < self.last.time_s { self.sink.sample(&self.last) } else { Ok(()) };
        self.emitted_s = self.last.time_s;
        if let Err(error) = emitted.and_then(|()| self.sink.event(&event.at(t, index))) {
            self.error.get_or_insert(error);
        }
    }
}
