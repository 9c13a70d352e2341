//! Turns the steps of the analytic model into samples, events and summary figures.

use super::grid::{Grid, Span};
use super::reading::Reader;
use super::search::{Marks, SEARCH_FROM, bisect, parabola_peak};
use super::{Energy, EventKind, Instant, Sink, SinkError, SiteSummary, Work};
use crate::analytic::SiteState;
use crate::integrator::{Observer, State, Step, StepTools};

/// One place of contact through time.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    summary: SiteSummary,
    /// Impulse at the last touch-down.
    impulse_before: f64,
}

type Places<S> = <S as Instant>::Each<Place>;

pub(super) struct Recorder<'a, R: Reader<N, Z>, const N: usize, const Z: usize> {
    reader: &'a R,
    sink: &'a mut dyn Sink<R::Sample>,
    grid: Grid,
    end_s: f64,
    mode: R::Mode,
    start_energy: Energy,
    places: Places<R::Sample>,
    /// Everything at the end of the last step, and the time up to which the sink has samples.
    last: R::Sample,
    emitted_s: f64,
    marks: Marks,
    error: Option<SinkError>,
}

impl<'a, R: Reader<N, Z>, const N: usize, const Z: usize> Recorder<'a, R, N, Z> {
    pub fn new(
        reader: &'a R,
        mode: R::Mode,
        start: &State<N, Z>,
        span: Span,
        sink: &'a mut dyn Sink<R::Sample>,
    ) -> Self {
        let start_energy = *reader.sample(0.0, start, &mode, &Energy::default()).energy();
        let last = reader.sample(0.0, start, &mode, &start_energy);
        Self {
            reader,
            sink,
            grid: Grid::new(span.numeric_hz),
            end_s: span.end_s,
            mode,
            start_energy,
            places: R::Sample::each(last.places(), |_| Place::default()),
            last,
            emitted_s: 0.0,
            marks: Marks::default(),
            error: None,
        }
    }

    /// Contacts that are there from the start, and the first sample.
    pub fn begin(&mut self) -> Result<(), SinkError> {
        for (index, place) in self.places.as_mut().iter_mut().enumerate() {
            if self.mode[index] == SiteState::Active {
                (place.summary.first_s, place.summary.touchdowns) = (Some(0.0), 1);
                self.sink.event(&R::Sample::event(0.0, index, EventKind::TouchDown, 0.0, 0.0))?;
            }
        }
        // A start beyond the reach of a loop has no passive angles; the run then ends before its first step.
        if self.last.energy().kinetic_j.is_nan() { Ok(()) } else { self.sink.sample(&self.last) }
    }

    /// The last sample, if the run broke off between grid points, and the summary.
    pub fn finish(mut self, end: &State<N, Z>, work: Work) -> Result<<R::Sample as Instant>::Outcome, SinkError> {
        if let Some(error) = self.error.take() {
            return Err(error);
        }
        if self.emitted_s < self.last.time_s() {
            self.sink.sample(&self.last)?;
        }
        let places = self.places.as_ref();
        let summary = |index: usize| SiteSummary { impulse_n_s: end.z[index], ..places[index].summary };
        let sites = R::Sample::each(places.len(), summary);
        Ok(self.last.outcome(sites, work, 0.0))
    }

    /// Samples of one step: the grid points and extremes inside it, and its end where steps are short, extremes lie there, or
    /// the run is over.
    fn emit_step(
        &mut self,
        step: &Step<N, Z>,
        mode: &R::Mode,
        tools: &mut dyn StepTools<N, Z>,
    ) -> Result<(), SinkError> {
        let end = step.t1;
        // A damper's force cannot be read off the dense output.
        let pressing = (0..self.last.places()).any(|place| mode[place].presses());
        while let Some(t) = self.grid.before(end.min(self.end_s)) {
            // A grid can be so fine that one step holds millions of its points.
            if !self.sink.proceed() {
                break;
            }
            let theta = (t - step.t0) / step.h;
            self.emit_marks(step, mode, tools, theta)?;
            if theta > 0.0 {
                let state = if pressing { tools.resolve(theta) } else { tools.interpolate(theta) };
                let sample = self.at_state(t, &state, mode);
                if pressing {
                    self.take(&sample);
                }
                self.emitted_s = t;
                self.sink.sample(&sample)?;
            }
        }
        self.emit_marks(step, mode, tools, 1.0)?;
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
    ) -> Result<(), SinkError> {
        while let Some(mark) = self.marks.before(theta) {
            let t = step.t0 + mark * step.h;
            if t > self.emitted_s && t < step.t1 {
                let extreme = self.at_state(t, &tools.resolve(mark), mode);
                self.take(&extreme);
                self.sink.extreme(&extreme)?;
            }
        }
        Ok(())
    }

    /// By rounding, a sample can be above the peaks that were searched for.
    fn take(&mut self, sample: &R::Sample) {
        let places = self.places.as_mut().iter_mut().enumerate();
        places.for_each(|(index, place)| place.summary.take(sample.pressed(index)));
    }

    fn at_state(&self, t: f64, state: &State<N, Z>, mode: &R::Mode) -> R::Sample {
        self.reader.sample(t, state, mode, &self.start_energy)
    }

    /// Largest force and penetration within the step from the last sample to `end`, and where.
    fn search_peaks(&mut self, end: &R::Sample, mode: &R::Mode, tools: &mut dyn StepTools<N, Z>) {
        self.marks.clear();
        for (index, place) in self.places.as_mut().iter_mut().enumerate() {
            if !mode[index].presses() {
                continue;
            }
            let (start, end) = (self.last.contact(index), end.contact(index));
            let read = |state: &State<N, Z>| self.reader.contact(state, index, mode);
            let summary = &mut place.summary;
            summary.deepen(-start.gap_m);
            if summary.deepen(-end.gap_m) {
                self.marks.push(1.0);
            }
            if start.gap_rate_m_s < 0.0 && end.gap_rate_m_s > 0.0 {
                let deepest = bisect(|theta| -read(&tools.interpolate(theta)).gap_rate_m_s);
                if summary.deepen(-read(&tools.resolve(deepest)).gap_m) {
                    self.marks.push(deepest);
                }
            }
            let highest = start.normal_n.max(end.normal_n);
            if highest > SEARCH_FROM * summary.peak_normal_n {
                let force = |theta: f64| read(&tools.resolve(theta)).normal_n;
                let (theta, peak) = parabola_peak(start.normal_n, end.normal_n, force);
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
        let end = self.at_state(step.t1, step.end, mode);
        self.search_peaks(&end, mode, tools);
        self.last = end;
        if let Err(error) = self.emit_step(step, mode, tools) {
            self.error = Some(error);
        }
        self.error.is_none() && self.sink.proceed()
    }

    fn event(&mut self, t: f64, state: &State<N, Z>, index: usize, mode: &R::Mode) {
        let parted = self.last.contact(index).gap_m > 0.0 || !matches!(self.mode[index], SiteState::Released);
        let kind = match mode[index] {
            SiteState::Active if parted => EventKind::TouchDown,
            SiteState::Active => EventKind::Reload,
            _ => EventKind::LiftOff,
        };
        let place = &mut self.places.as_mut()[index];
        let (mut approach, mut impulse) = (0.0, 0.0);
        match kind {
            EventKind::TouchDown => {
                approach = -self.reader.contact(state, index, mode).gap_rate_m_s;
                place.summary.first_s.get_or_insert(t);
                place.summary.touchdowns += 1;
                place.impulse_before = state.z[index];
            }
            EventKind::LiftOff => impulse = state.z[index] - place.impulse_before,
            EventKind::Reload => {}
        }
        self.mode = *mode;
        // Rates jump soon after an event: whoever interpolates needs the sample just before it.
        let before = if self.emitted_s < self.last.time_s() { self.sink.sample(&self.last) } else { Ok(()) };
        self.emitted_s = self.last.time_s();
        let event = R::Sample::event(t, index, kind, approach, impulse);
        if let Err(error) = before.and_then(|()| self.sink.event(&event)) {
            self.error.get_or_insert(error);
        }
    }
}
