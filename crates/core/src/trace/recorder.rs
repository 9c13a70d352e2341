//! Turns the steps of the analytic model into samples, events and summary figures.

use super::grid::{Grid, Span};
use super::reading::Reader;
use super::search::{BISECTIONS, Marks, SEARCH_FROM, bisect, parabola_peak};
use super::slipping::Slipping;
use super::{ContactSummary, Energy, Event, EventKind, Outcome, Reach, Sample, Sink, SinkError, Wants, Work};
use crate::analytic::SiteState;
use crate::integrator::{Observer, State, Step, StepTools};

/// One place of contact through time.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    summary: ContactSummary,
    /// Impulse at the last touch-down.
    impulse_before: f64,
    slipping: Slipping,
}

pub(super) struct Recorder<'a, R: Reader<N, Z>, const N: usize, const Z: usize> {
    reader: &'a R,
    sink: &'a mut dyn Sink,
    wants: Wants,
    grid: Grid,
    end_s: f64,
    /// The region whose boundary ends the run, and when the object left it.
    reach: Option<Reach>,
    ejected_s: Option<f64>,
    mode: R::Mode,
    start_energy: Energy,
    places: Vec<Place>,
    /// What is wanted at the end of the last step, and the state and mode it is read of.
    last: Sample,
    last_state: State<N, Z>,
    last_mode: R::Mode,
    /// Room for the end of the step at hand, and for a sample within it.
    end: Sample,
    within: Sample,
    /// Time up to which the sink has samples.
    emitted_s: f64,
    marks: Marks,
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
        reader.read(0.0, start, &mode, &Energy::default(), Wants::ALL, &mut last);
        let start_energy = last.energy;
        reader.read(0.0, start, &mode, &start_energy, Wants::ALL, &mut last);
        Self {
            reader,
            wants: sink.wants(),
            sink,
            grid: Grid::new(span),
            end_s: span.end_s,
            reach,
            ejected_s: None,
            mode,
            start_energy,
            places: vec![Place::default(); last.contacts.len()],
            last,
            last_state: *start,
            last_mode: mode,
            end: Sample::default(),
            within: Sample::default(),
            emitted_s: 0.0,
            marks: Marks::default(),
            error: None,
        }
    }

    /// Contacts that are there from the start, and the first sample.
    pub fn begin(&mut self) -> Result<(), SinkError> {
        for (index, place) in self.places.iter_mut().enumerate() {
            // An overlap is a contact whether there is a force or not; a gap of zero is one only where it closes.
            if self.mode[index] == SiteState::Free {
                continue;
            }
            let contact = &self.last.contacts[index];
            (place.summary.first_s, place.summary.touchdowns) = (Some(0.0), 1);
            if self.mode[index] == SiteState::Released {
                place.summary.take(contact.pressed());
            }
            self.sink.event(&Event {
                time_s: 0.0,
                contact: index,
                kind: EventKind::TouchDown,
                approach_speed: contact.approach_at_start(),
                impulse: 0.0,
            })?;
        }
        // A start beyond the reach of a loop has no passive angles; the run then ends before its first step.
        if self.last.energy.kinetic_j.is_nan() { Ok(()) } else { self.sink.sample(&self.last) }
    }

    /// The last sample, if the run broke off between grid points, and the summary.
    pub fn finish(mut self, end: &State<N, Z>, work: Work) -> Result<Outcome, SinkError> {
        if let Some(error) = self.error.take() {
            return Err(error);
        }
        if self.emitted_s < self.last.time_s {
            self.sink.sample(&self.last)?;
        }
        if self.wants != Wants::ALL {
            let (state, mode) = (&self.last_state, &self.last_mode);
            self.reader.read(self.last.time_s, state, mode, &self.start_energy, Wants::ALL, &mut self.last);
        }
        // The integrator ends a step behind the exit.
        let end = if self.ejected_s.is_some() { &self.last_state } else { end };
        let summary = |(index, place): (usize, &Place)| ContactSummary { impulse_n_s: end.z[index], ..place.summary };
        let contacts = self.places.iter().enumerate().map(summary).collect();
        Ok(Outcome { last: self.last, contacts, work, loop_gap_m: 0.0, ejected_s: self.ejected_s })
    }

    /// Samples of one step: the grid points and extremes inside it, and its end where steps are short, extremes lie there, or
    /// the run is over.
    fn emit_step(
        &mut self,
        step: &Step<N, Z>,
        mode: &R::Mode,
        tools: &mut dyn StepTools<N, Z>,
    ) -> Result<(), SinkError> {
        let end = self.last.time_s;
        // A damper's force cannot be read off the dense output.
        let pressing = (0..self.places.len()).any(|index| mode[index].presses());
        let mut impulses = step.start.z;
        self.grid.begin_step(end.min(self.end_s));
        while let Some(t) = self.grid.before(end.min(self.end_s)) {
            // A grid can be so fine that one step holds millions of its points.
            if !self.sink.proceed() {
                break;
            }
            let theta = (t - step.t0) / step.h;
            self.emit_marks(step, mode, tools, theta, &mut impulses)?;
            if theta > 0.0 {
                let state = match pressing {
                    true => self.resolved(step, tools, theta, &mut impulses),
                    false => tools.interpolate(theta),
                };
                self.read_within(t, &state, mode);
                if pressing {
                    self.take_within();
                }
                self.emitted_s = t;
                self.sink.sample(&self.within)?;
            }
        }
        self.emit_marks(step, mode, tools, 1.0, &mut impulses)?;
        if self.grid.takes_end(end, step.h) || end >= self.end_s {
            self.emitted_s = end;
            self.sink.sample(&self.last)
        } else if self.marks.at_end {
            self.sink.extreme(&self.last)
        } else {
            Ok(())
        }
    }

    /// Samples at the extremes of the step that come before `theta`.
    fn emit_marks(
        &mut self,
        step: &Step<N, Z>,
        mode: &R::Mode,
        tools: &mut dyn StepTools<N, Z>,
        theta: f64,
        impulses: &mut [f64; Z],
    ) -> Result<(), SinkError> {
        while let Some(mark) = self.marks.before(theta) {
            let t = step.t0 + mark * step.h;
            if t > self.emitted_s && t < step.t1 {
                let state = self.resolved(step, tools, mark, impulses);
                self.read_within(t, &state, mode);
                self.take_within();
                self.sink.extreme(&self.within)?;
            }
        }
        Ok(())
    }

    /// A state within the step, as a step of its own ends on it. What that sums up of forces has errors of its own, and no normal
    /// impulse falls: it lies between that of the sample before, which is in `impulses`, and that of the step's end.
    fn resolved(
        &self,
        step: &Step<N, Z>,
        tools: &mut dyn StepTools<N, Z>,
        theta: f64,
        impulses: &mut [f64; Z],
    ) -> State<N, Z> {
        let mut state = tools.resolve(theta);
        for (index, before) in impulses.iter_mut().enumerate().take(self.places.len()) {
            *before = state.z[index].min(step.end.z[index]).max(*before);
            state.z[index] = *before;
        }
        state
    }

    fn read_within(&mut self, t: f64, state: &State<N, Z>, mode: &R::Mode) {
        self.reader.read(t, state, mode, &self.start_energy, self.wants, &mut self.within);
    }

    /// By rounding, a sample can be above the peaks that were searched for.
    fn take_within(&mut self) {
        let places = self.places.iter_mut().zip(&self.within.contacts);
        places.for_each(|(place, contact)| place.summary.take(contact.pressed()));
    }

    /// The forces and depths at the end of a step that nobody wants the peaks of.
    fn take_end(&mut self) {
        let places = self.places.iter_mut().zip(&self.end.contacts);
        places.for_each(|(place, contact)| place.summary.take(contact.pressed()));
    }

    /// Where friction that holds begins to slip or to stick: steps end there, and the next one is in another mode.
    fn note_slips(&mut self, time_s: f64, mode: &R::Mode) -> Result<(), SinkError> {
        for (contact, place) in self.places.iter_mut().enumerate() {
            let slips = self.reader.slips(contact, mode);
            if let Some(kind) = place.slipping.change(slips, &mut place.summary) {
                self.sink.event(&Event { time_s, contact, kind, approach_speed: 0.0, impulse: 0.0 })?;
            }
        }
        Ok(())
    }

    /// Shortens the step at hand to where the object leaves the reach of the fingers, if something has touched it. Whether it does.
    fn end_at_exit(&mut self, step: &Step<N, Z>, mode: &R::Mode, tools: &mut dyn StepTools<N, Z>) -> bool {
        let Some(reach) = self.reach.filter(|reach| reach.leaves(&self.last, &self.end)) else { return false };
        let touched = |(index, place): (usize, &Place)| place.summary.touchdowns > 0 && !self.end.is_stop(index);
        if !self.places.iter().enumerate().any(touched) {
            return false;
        }
        let (mut inside, mut outside) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (inside + outside);
            self.read_within(step.t0 + middle * step.h, &tools.resolve(middle), mode);
            if reach.is_outside(&self.within.bodies[0]) { outside = middle } else { inside = middle }
        }
        let (exit_s, mut impulses) = (step.t0 + outside * step.h, step.start.z);
        if outside < 1.0 {
            self.last_state = self.resolved(step, tools, outside, &mut impulses);
            self.reader.read(exit_s, &self.last_state, mode, &self.start_energy, self.wants, &mut self.end);
        }
        self.end_s = self.end.time_s;
        self.ejected_s = Some(self.end_s);
        true
    }

    /// Largest force and penetration within the step from the last sample to its end, and where.
    fn search_peaks(&mut self, mode: &R::Mode, tools: &mut dyn StepTools<N, Z>) {
        self.marks.clear();
        let length_s = self.end.time_s - self.last.time_s;
        for (index, place) in self.places.iter_mut().enumerate() {
            // A released contact can still get deeper, without a force.
            let presses = mode[index].presses();
            if !presses && mode[index] != SiteState::Released {
                continue;
            }
            let (start, end) = (&self.last.contacts[index], &self.end.contacts[index]);
            let read = |state: &State<N, Z>| self.reader.contact(state, index, mode);
            let summary = &mut place.summary;
            summary.deepen(-start.gap_m);
            if summary.deepen(-end.gap_m) {
                self.marks.push(1.0);
            }
            if start.gap_rate_m_s < 0.0 && end.gap_rate_m_s > 0.0 {
                let deepest = bisect(&mut |theta| -read(&tools.interpolate(theta)).gap_rate_m_s);
                if summary.deepen(-read(&tools.resolve(deepest)).gap_m) {
                    self.marks.push(deepest);
                }
            }
            let mut highest = start.normal_n.max(end.normal_n);
            if highest == 0.0 {
                // A force that comes and goes within the step has a mean.
                highest = (end.impulse_n_s - start.impulse_n_s) / length_s;
            }
            if presses && highest > SEARCH_FROM * summary.peak_normal_n {
                let mut force = |theta: f64| read(&tools.resolve(theta)).normal_n;
                let (theta, peak) = parabola_peak(start.normal_n, end.normal_n, &mut force);
                if summary.press(peak) {
                    self.marks.push(theta);
                }
            }
        }
        self.marks.sort();
    }
}

impl<R: Reader<N, Z>, const N: usize, const Z: usize> Observer<N, Z, R::Mode> for Recorder<'_, R, N, Z> {
    fn step(&mut self, step: &Step<N, Z>, mode: &R::Mode, tools: &mut dyn StepTools<N, Z>) -> bool {
        self.mode = *mode;
        (self.last_state, self.last_mode) = (*step.end, *mode);
        if let Err(error) = self.note_slips(step.t0, mode) {
            self.error = Some(error);
            return false;
        }
        self.reader.read(step.t1, step.end, mode, &self.start_energy, self.wants, &mut self.end);
        let exits = self.end_at_exit(step, mode, tools);
        if self.wants.peaks && !exits {
            self.search_peaks(mode, tools);
        } else {
            self.marks.clear();
            self.take_end();
        }
        std::mem::swap(&mut self.last, &mut self.end);
        if let Err(error) = self.emit_step(step, mode, tools) {
            self.error = Some(error);
        }
        self.error.is_none() && self.ejected_s.is_none() && self.sink.proceed()
    }

    fn event(&mut self, t: f64, state: &State<N, Z>, index: usize, mode: &R::Mode) {
        let parted = self.last.contacts[index].gap_m > 0.0 || !matches!(self.mode[index], SiteState::Released);
        let kind = match mode[index] {
            SiteState::Active if parted => EventKind::TouchDown,
            SiteState::Active => EventKind::Reload,
            _ => EventKind::LiftOff,
        };
        let place = &mut self.places[index];
        let (mut approach_speed, mut impulse) = (0.0, 0.0);
        match kind {
            EventKind::TouchDown => {
                approach_speed = -self.reader.contact(state, index, mode).gap_rate_m_s;
                place.summary.first_s.get_or_insert(t);
                place.summary.touchdowns += 1;
                place.impulse_before = state.z[index];
            }
            EventKind::LiftOff => impulse = state.z[index] - place.impulse_before,
            EventKind::Reload | EventKind::Slips | EventKind::Sticks => {}
        }
        self.mode = *mode;
        // Rates jump soon after an event: whoever interpolates needs the sample just before it.
        let before = if self.emitted_s < self.last.time_s { self.sink.sample(&self.last) } else { Ok(()) };
        self.emitted_s = self.last.time_s;
        let event = Event { time_s: t, contact: index, kind, approach_speed, impulse };
        if let Err(error) = before.and_then(|()| self.sink.event(&event)) {
            self.error.get_or_insert(error);
        }
    }
}
