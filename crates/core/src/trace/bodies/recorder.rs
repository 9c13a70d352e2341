//! Turns the steps of the analytic model of discs into samples, events and summary figures.

use super::{BodiesEvent, BodiesOutcome, BodiesSample, DiscState};
use crate::analytic::SiteState;
use crate::analytic::discs::{DiscEnergies, DiscMode, Discs, PAIRS, PairReading, QUADRATURES};
use crate::integrator::{Hybrid, Observer, State, Step, StepTools};
use crate::scene::BodiesScene;
use crate::trace::grid::Grid;
use crate::trace::search::{Marks, SEARCH_FROM, bisect, parabola_peak};
use crate::trace::{ContactSample, Energy, EventKind, Instant, Sink, SinkError, SiteSummary, Work};

pub(super) struct Recorder<'a, const N: usize, const M: usize> {
    model: &'a Discs<N, M>,
    scene: &'a BodiesScene,
    sink: &'a mut dyn Sink<BodiesSample>,
    grid: Grid,
    mode: DiscMode,
    start_energy: DiscEnergies,
    pairs: Vec<SiteSummary>,
    /// Impulse of each pair at its last touch-down.
    impulse_before: Vec<f64>,
    /// Every pair at the end of the last step, everything there as a sample, and the time up to which the sink has samples.
    at_end: Vec<PairReading>,
    last: BodiesSample,
    emitted_s: f64,
    marks: Marks,
    error: Option<SinkError>,
}

impl<'a, const N: usize, const M: usize> Recorder<'a, N, M> {
    pub fn new(
        model: &'a Discs<N, M>,
        scene: &'a BodiesScene,
        start: State<N, QUADRATURES>,
        sink: &'a mut dyn Sink<BodiesSample>,
    ) -> Self {
        let mode = model.read_mode(0.0, &start.q, &start.v);
        let start_energy = model.energies(&start.q, &start.v);
        Self {
            model,
            scene,
            sink,
            grid: Grid::new(scene.log.numeric_hz),
            mode,
            start_energy,
            pairs: vec![SiteSummary::default(); model.pairs()],
            impulse_before: vec![0.0; model.pairs()],
            at_end: readings(model, &start, &mode),
            last: sample(model, scene, 0.0, &start, &mode, &start_energy),
            emitted_s: 0.0,
            marks: Marks::default(),
            error: None,
        }
    }

    /// Contacts that are there from the start, and the first sample.
    pub fn begin(&mut self) -> Result<(), SinkError> {
        for (pair, summary) in self.pairs.iter_mut().enumerate() {
            if self.mode[pair] == SiteState::Active {
                (summary.first_s, summary.touchdowns) = (Some(0.0), 1);
                let kind = EventKind::TouchDown;
                self.sink.event(&BodiesEvent { time_s: 0.0, pair, kind, approach_m_s: 0.0, impulse_n_s: 0.0 })?;
            }
        }
        self.sink.sample(&self.last)
    }

    /// The last sample, if the run broke off between grid points, and the summary.
    pub fn finish(mut self, end: &State<N, QUADRATURES>, work: Work) -> Result<BodiesOutcome, SinkError> {
        if let Some(error) = self.error.take() {
            return Err(error);
        }
        if self.emitted_s < self.last.time_s {
            self.sink.sample(&self.last)?;
        }
        for (summary, impulse) in self.pairs.iter_mut().zip(end.z) {
            summary.impulse_n_s = impulse;
        }
        Ok(BodiesOutcome { last: self.last, pairs: self.pairs, work })
    }

    /// Samples of one step: the grid points and extremes inside it, and its end where steps are short, extremes lie there, or
    /// the run is over.
    fn emit_step(
        &mut self,
        step: &Step<N, QUADRATURES>,
        mode: &DiscMode,
        tools: &mut dyn StepTools<N, QUADRATURES>,
    ) -> Result<(), SinkError> {
        let (end, end_s) = (step.t1, self.scene.duration_s);
        // A damper's force cannot be read off the dense output.
        let pressing = mode.sites.iter().any(|state| matches!(state, SiteState::Active | SiteState::Natural));
        while let Some(t) = self.grid.before(end.min(end_s)) {
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
        if self.grid.takes_end(end, step.h) || end >= end_s {
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
        step: &Step<N, QUADRATURES>,
        mode: &DiscMode,
        tools: &mut dyn StepTools<N, QUADRATURES>,
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
    fn take(&mut self, sample: &BodiesSample) {
        self.pairs.iter_mut().enumerate().for_each(|(pair, summary)| summary.take(sample.pressed(pair)));
    }

    fn at_state(&self, t: f64, state: &State<N, QUADRATURES>, mode: &DiscMode) -> BodiesSample {
        sample(self.model, self.scene, t, state, mode, &self.start_energy)
    }

    /// Largest force and penetration within one step, and where.
    fn search_peaks(&mut self, end: &[PairReading], mode: &DiscMode, tools: &mut dyn StepTools<N, QUADRATURES>) {
        self.marks.clear();
        for pair in 0..self.pairs.len() {
            if !matches!(mode[pair], SiteState::Active | SiteState::Natural) {
                continue;
            }
            let model = self.model;
            let read = |state: &State<N, QUADRATURES>| model.reading(&state.q, &state.v, pair, mode[pair]);
            let (start, end) = (&self.at_end[pair], &end[pair]);
            let summary = &mut self.pairs[pair];
            summary.deepen(start.delta);
            if summary.deepen(end.delta) {
                self.marks.push(1.0);
            }
            if start.delta_rate > 0.0 && end.delta_rate < 0.0 {
                let deepest = bisect(|theta| read(&tools.interpolate(theta)).delta_rate);
                if summary.deepen(read(&tools.resolve(deepest)).delta) {
                    self.marks.push(deepest);
                }
            }
            let highest = start.normal_force.max(end.normal_force);
            if highest > SEARCH_FROM * summary.peak_normal_n {
                let force = |theta: f64| read(&tools.resolve(theta)).normal_force;
                let (theta, peak) = parabola_peak(start.normal_force, end.normal_force, force);
                if summary.press(peak) {
                    self.marks.push(theta);
                }
            }
        }
        self.marks.sort();
    }
}

impl<const N: usize, const M: usize> Observer<N, QUADRATURES, DiscMode> for Recorder<'_, N, M> {
    fn step(
        &mut self,
        step: &Step<N, QUADRATURES>,
        mode: &DiscMode,
        tools: &mut dyn StepTools<N, QUADRATURES>,
    ) -> bool {
        self.mode = *mode;
        let end = readings(self.model, step.end, mode);
        self.search_peaks(&end, mode, tools);
        self.at_end = end;
        self.last = sample(self.model, self.scene, step.t1, step.end, mode, &self.start_energy);
        if let Err(error) = self.emit_step(step, mode, tools) {
            self.error = Some(error);
        }
        self.error.is_none() && self.sink.proceed()
    }

    fn event(&mut self, t: f64, state: &State<N, QUADRATURES>, pair: usize, mode: &DiscMode) {
        let reading = self.model.reading(&state.q, &state.v, pair, mode[pair]);
        let parted = self.at_end[pair].delta < 0.0 || !matches!(self.mode[pair], SiteState::Released);
        let kind = match mode[pair] {
            SiteState::Active if parted => EventKind::TouchDown,
            SiteState::Active => EventKind::Reload,
            _ => EventKind::LiftOff,
        };
        let summary = &mut self.pairs[pair];
        let (mut approach_m_s, mut impulse_n_s) = (0.0, 0.0);
        match kind {
            EventKind::TouchDown => {
                approach_m_s = reading.delta_rate;
                summary.first_s.get_or_insert(t);
                summary.touchdowns += 1;
                self.impulse_before[pair] = state.z[pair];
            }
            EventKind::LiftOff => impulse_n_s = state.z[pair] - self.impulse_before[pair],
            EventKind::Reload => {}
        }
        self.mode = *mode;
        // Rates jump soon after an event: whoever interpolates needs the sample just before it.
        let before = if self.emitted_s < self.last.time_s { self.sink.sample(&self.last) } else { Ok(()) };
        self.emitted_s = self.last.time_s;
        let event = BodiesEvent { time_s: t, pair, kind, approach_m_s, impulse_n_s };
        if let Err(error) = before.and_then(|()| self.sink.event(&event)) {
            self.error.get_or_insert(error);
        }
    }
}

fn readings<const N: usize, const M: usize>(
    model: &Discs<N, M>,
    state: &State<N, QUADRATURES>,
    mode: &DiscMode,
) -> Vec<PairReading> {
    (0..model.pairs()).map(|pair| model.reading(&state.q, &state.v, pair, mode[pair])).collect()
}

/// Everything about one state; `start` has the energies at the start of the run, from which works and losses count.
fn sample<const N: usize, const M: usize>(
    model: &Discs<N, M>,
    scene: &BodiesScene,
    t: f64,
    state: &State<N, QUADRATURES>,
    mode: &DiscMode,
    start: &DiscEnergies,
) -> BodiesSample {
    let mut moving = state.q.chunks_exact(3).zip(state.v.chunks_exact(3));
    let discs = scene.discs.iter().map(|disc| {
        let coordinates = if disc.motion.moves() { moving.next() } else { None };
        coordinates.map_or(DiscState { centre_m: disc.centre_m, ..DiscState::default() }, |(q, v)| DiscState {
            centre_m: [q[0], q[1]],
            angle_rad: q[2],
            velocity_m_s: [v[0], v[1]],
            spin_rad_s: v[2],
        })
    });
    let contacts = readings(model, state, mode).into_iter().zip(state.z).map(|(r, impulse_n_s)| ContactSample {
        gap_m: -r.delta,
        gap_rate_m_s: -r.delta_rate,
        slip_m_s: r.slip,
        normal_n: r.normal_force,
        tangential_n: r.tangential_force,
        impulse_n_s,
        point_m: r.point,
        normal: r.normal,
    });
    let now = model.energies(&state.q, &state.v);
    let (contact_work, drive_work) = (state.z[PAIRS], state.z[PAIRS + 1]);
    BodiesSample {
        time_s: t,
        discs: discs.collect(),
        contacts: contacts.collect(),
        energy: Energy {
            kinetic_j: now.kinetic,
            gravity_j: now.gravity,
            spring_j: 0.0,
            elastic_j: now.elastic,
            dissipated_j: start.elastic - now.elastic - contact_work,
            motor_work_j: drive_work,
            balance_j: (now.kinetic - start.kinetic) + (now.gravity - start.gravity) - contact_work - drive_work,
        },
    }
}
