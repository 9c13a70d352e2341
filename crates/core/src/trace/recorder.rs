//! Turns the steps of the analytic model into samples, events and summary figures.

use super::grid::Grid;
use super::reading::sample;
use super::search::{Marks, SEARCH_FROM, bisect, parabola_peak};
use super::{Event, EventKind, Instant, Outcome, Sample, Sink, SinkError, Site, SiteSummary, Work};
use crate::analytic::{Energies, Mode, Model, QUADRATURES, SiteState, Snapshot};
use crate::integrator::{Hybrid, Observer, State, Step, StepTools};
use crate::scene::Scene;

type Point = State<2, QUADRATURES>;

pub(super) struct Recorder<'a> {
    model: &'a Model,
    sink: &'a mut dyn Sink,
    grid: Grid,
    end_s: f64,
    mode: Mode,
    start_energy: Energies,
    sites: [SiteSummary; 3],
    /// Impulse of each site at its last touch-down.
    impulse_before: [f64; 3],
    /// Everything at the end of the last step, as a sample too, and the time up to which the sink has samples.
    at_end: Snapshot,
    last: Sample,
    emitted_s: f64,
    marks: Marks,
    error: Option<SinkError>,
}

impl<'a> Recorder<'a> {
    pub fn new(model: &'a Model, scene: &Scene, start: Point, sink: &'a mut dyn Sink) -> Self {
        let mode = model.read_mode(0.0, &start.q, &start.v);
        let at_start = model.snapshot(start.q, start.v, &mode);
        Self {
            model,
            sink,
            grid: Grid::new(scene.log.numeric_hz),
            end_s: scene.duration_s,
            mode,
            start_energy: at_start.energies,
            sites: [SiteSummary::default(); 3],
            impulse_before: [0.0; 3],
            last: sample(model, 0.0, &start, &at_start, &at_start.energies),
            at_end: at_start,
            emitted_s: 0.0,
            marks: Marks::default(),
            error: None,
        }
    }

    /// Contacts that are there from the start, and the first sample.
    pub fn begin(&mut self) -> Result<(), SinkError> {
        for site in Site::ALL {
            if self.mode[site as usize] == SiteState::Active {
                let summary = &mut self.sites[site as usize];
                (summary.first_s, summary.touchdowns) = (Some(0.0), 1);
                let event = Event { time_s: 0.0, site, kind: EventKind::TouchDown, approach_speed: 0.0, impulse: 0.0 };
                self.sink.event(&event)?;
            }
        }
        // A start beyond the reach of the loop has no passive angles; the run then ends before its first step.
        if self.last.q13_rad.is_finite() { self.sink.sample(&self.last) } else { Ok(()) }
    }

    /// The last sample, if the run broke off between grid points, and the summary.
    pub fn finish(mut self, end: &Point, work: Work) -> Result<Outcome, SinkError> {
        if let Some(error) = self.error.take() {
            return Err(error);
        }
        if self.emitted_s < self.last.time_s {
            self.sink.sample(&self.last)?;
        }
        let mut sites = self.sites;
        for (summary, impulse) in sites.iter_mut().zip(end.z) {
            summary.impulse_n_s = impulse;
        }
        Ok(Outcome { last: self.last, sites, work, loop_gap_m: 0.0 })
    }

    fn emit(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.emitted_s = sample.time_s;
        self.sink.sample(sample)
    }

    /// Samples of one step: the grid points and extremes inside it, and its end where steps are short, extremes lie there, or
    /// the run is over.
    fn emit_step(
        &mut self,
        step: &Step<2, QUADRATURES>,
        mode: &Mode,
        tools: &mut dyn StepTools<2, QUADRATURES>,
    ) -> Result<(), SinkError> {
        let end = step.t1;
        // A damper's force cannot be read off the dense output.
        let pressing = mode.sites.iter().any(|state| matches!(state, SiteState::Active | SiteState::Natural));
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
                self.emit(&sample)?;
            }
        }
        self.emit_marks(step, mode, tools, 1.0)?;
        let last = self.last;
        if self.grid.takes_end(end, step.h) || end >= self.end_s {
            self.emit(&last)
        } else if self.marks.at_end {
            self.sink.extreme(&last)
        } else {
            Ok(())
        }
    }

    /// Samples at the extremes of the step that come before `theta`.
    fn emit_marks(
        &mut self,
        step: &Step<2, QUADRATURES>,
        mode: &Mode,
        tools: &mut dyn StepTools<2, QUADRATURES>,
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
    fn take(&mut self, sample: &Sample) {
        self.sites.iter_mut().enumerate().for_each(|(site, summary)| summary.take(sample.pressed(site)));
    }

    fn at_state(&self, t: f64, state: &Point, mode: &Mode) -> Sample {
        let snapshot = self.model.snapshot(state.q, state.v, mode);
        sample(self.model, t, state, &snapshot, &self.start_energy)
    }

    /// Largest force and penetration within one step, and where.
    fn search_peaks(&mut self, end: &Snapshot, mode: &Mode, tools: &mut dyn StepTools<2, QUADRATURES>) {
        self.marks.clear();
        for site in Site::ALL {
            let index = site as usize;
            if !matches!(mode[index], SiteState::Active | SiteState::Natural) {
                continue;
            }
            let model = self.model;
            let read = |state: &Point| model.reading(state.q, state.v, site, mode[index]);
            let (Some(start), Some(end)) = (self.at_end.sites[index], end.sites[index]) else { continue };
            let summary = &mut self.sites[index];
            summary.deepen(start.delta);
            if summary.deepen(end.delta) {
                self.marks.push(1.0);
            }
            if start.delta_rate > 0.0 && end.delta_rate < 0.0 {
                let deepest = bisect(|theta| read(&tools.interpolate(theta)).map_or(0.0, |r| r.delta_rate));
                if summary.deepen(read(&tools.resolve(deepest)).map_or(0.0, |r| r.delta)) {
                    self.marks.push(deepest);
                }
            }
            let highest = start.normal.max(end.normal);
            if highest > SEARCH_FROM * summary.peak_normal_n {
                let force = |theta: f64, tools: &mut dyn StepTools<2, QUADRATURES>| {
                    read(&tools.resolve(theta)).map_or(0.0, |r| r.normal)
                };
                let (theta, peak) = parabola_peak(start.normal, end.normal, |theta| force(theta, tools));
                if summary.press(peak) {
                    self.marks.push(theta);
                }
            }
        }
        self.marks.sort();
    }
}

impl Observer<2, QUADRATURES, Mode> for Recorder<'_> {
    fn step(&mut self, step: &Step<2, QUADRATURES>, mode: &Mode, tools: &mut dyn StepTools<2, QUADRATURES>) -> bool {
        self.mode = *mode;
        let end = self.model.snapshot(step.end.q, step.end.v, mode);
        self.search_peaks(&end, mode, tools);
        self.at_end = end;
        self.last = sample(self.model, step.t1, step.end, &end, &self.start_energy);
        if let Err(error) = self.emit_step(step, mode, tools) {
            self.error = Some(error);
        }
        self.error.is_none() && self.sink.proceed()
    }

    fn event(&mut self, t: f64, state: &Point, site: usize, mode: &Mode) {
        let Some(reading) = self.model.reading(state.q, state.v, Site::ALL[site], mode[site]) else {
            return;
        };
        let apart = self.at_end.sites[site].is_some_and(|r| r.delta < 0.0);
        let parted = apart || !matches!(self.mode[site], SiteState::Released);
        let kind = match mode[site] {
            SiteState::Active if parted => EventKind::TouchDown,
            SiteState::Active => EventKind::Reload,
            _ => EventKind::LiftOff,
        };
        let summary = &mut self.sites[site];
        let (mut approach_speed, mut impulse) = (0.0, 0.0);
        match kind {
            EventKind::TouchDown => {
                approach_speed = reading.delta_rate;
                summary.first_s.get_or_insert(t);
                summary.touchdowns += 1;
                self.impulse_before[site] = state.z[site];
            }
            EventKind::LiftOff => impulse = state.z[site] - self.impulse_before[site],
            EventKind::Reload => {}
        }
        self.mode = *mode;
        let event = Event { time_s: t, site: Site::ALL[site], kind, approach_speed, impulse };
        // Rates jump soon after an event: whoever interpolates needs the sample just before it.
        let before = if self.emitted_s < self.last.time_s { self.sink.sample(&self.last) } else { Ok(()) };
        self.emitted_s = self.last.time_s;
        if let Err(error) = before.and_then(|()| self.sink.event(&event)) {
            self.error.get_or_insert(error);
        }
    }
}
