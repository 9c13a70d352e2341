//! Turns the steps of the engine model of discs into samples, events and summary figures.

use super::engine_reading::{Start, sample};
use super::{BodiesEvent, BodiesOutcome, BodiesSample};
use crate::engine::{Change, ChangeKind, Motion, Site};
use crate::scene::BodiesScene;
use crate::trace::engine::Follow;
use crate::trace::grid::Grid;
use crate::trace::moments::Moments;
use crate::trace::tracked::{Told, Tracked};
use crate::trace::{Instant, Sink, SinkError, Work, between};

pub(super) struct EngineRecorder<'a> {
    scene: &'a BodiesScene,
    sink: &'a mut dyn Sink<BodiesSample>,
    grid: Grid,
    start: Start,
    pairs: Vec<Tracked>,
    last: BodiesSample,
    emitted_s: f64,
    moments: Moments,
    work: Work,
}

impl<'a> EngineRecorder<'a> {
    pub fn new(scene: &'a BodiesScene, motion: &Motion, sink: &'a mut dyn Sink<BodiesSample>) -> Self {
        let start = Start::new(motion);
        let count = motion.plan.contacts.len();
        Self {
            scene,
            sink,
            grid: Grid::new(scene.log.numeric_hz),
            last: sample(scene, motion, &start, &vec![0.0; count]),
            start,
            pairs: vec![Tracked::default(); count],
            emitted_s: 0.0,
            moments: Moments::default(),
            work: Work::default(),
        }
    }

    /// Contacts that are there from the start, and the first sample.
    pub fn begin(&mut self, motion: &Motion) -> Result<(), SinkError> {
        for touch in motion.touches.iter().filter(|touch| touch.gap < 0.0) {
            self.change(touch.index, ChangeKind::Meets, 0.0, 0.0, 0.0)?;
            let summary = &mut self.pairs[touch.index].summary;
            summary.deepen(-touch.gap);
            summary.press(self.last.contacts[touch.index].normal_n);
        }
        self.sink.sample(&self.last)
    }

    /// One step: its events, its samples, its figures.
    pub fn step(&mut self, motion: &Motion) -> Result<(), SinkError> {
        let (end_s, dt) = (motion.clock.now(), motion.last_dt_s);
        self.work.steps += 1;
        self.work.contact_substeps += u64::from(motion.contact.substeps);
        self.work.newton_iterations += u64::from(motion.contact.iterations);
        self.work.rejected += u64::from(motion.contact.repeated);
        let impulses: Vec<f64> = self
            .pairs
            .iter()
            .enumerate()
            .map(|(pair, tracked)| tracked.impulse + motion.normal_impulse(pair))
            .collect();
        let now = sample(self.scene, motion, &self.start, &impulses);
        // Surfaces that the last step left apart, in its frozen geometry, or that the run starts with, and that overlap where
        // this one starts. What recedes has just been left, and overlaps by rounding.
        let meets = |at: &&Site| at.touch.gap <= 0.0 && motion.space.closes(at);
        for at in motion.space.sites.iter().filter(meets) {
            let closing = (-motion.space.rate[at.normal]).max(0.0);
            self.change(at.touch.index, ChangeKind::Meets, end_s - dt, closing, 0.0)?;
        }
        self.find_extremes(motion);
        for index in 0..motion.contact.changes.len() {
            let Change { after_s, site, kind, closing, impulse } = motion.contact.changes[index];
            let pair = motion.space.sites[site].touch.index;
            let time_s = end_s - dt + after_s;
            self.pass_extremes(&now, dt, after_s)?;
            if kind == ChangeKind::Meets && !self.pairs[pair].touching {
                self.pass_touch(motion, &now, pair, time_s, closing)?;
            }
            self.change(pair, kind, time_s, closing, impulse)?;
        }
        self.pass_extremes(&now, dt, dt)?;
        for pair in 0..self.pairs.len() {
            self.close_step(motion, pair, end_s)?;
        }
        self.emit(now, dt)
    }

    /// Finds where in the step a pair is deeper, or presses harder, than ever before.
    fn find_extremes(&mut self, motion: &Motion) {
        self.moments.clear();
        for (pair, tracked) in self.pairs.iter_mut().enumerate() {
            let within = motion.contact_extremes(pair);
            let depth = motion.touches.iter().find(|touch| touch.index == pair).map_or(0.0, |touch| -touch.gap);
            let end = [motion.forces(pair).0, depth];
            self.moments.take(pair, &mut tracked.summary, within, motion.last_dt_s, end);
        }
        self.moments.sort();
    }

    /// Samples at the extremes of a step of length `dt` that come before `after_s`.
    fn pass_extremes(&mut self, now: &BodiesSample, dt: f64, after_s: f64) -> Result<(), SinkError> {
        while let Some((pair, moment)) = self.moments.before(after_s) {
            let time_s = now.time_s - dt + moment.after_s;
            let mut sample = between(&self.last, now, time_s);
            sample.contacts[pair].at(&moment, self.pairs[pair].impulse);
            while let Some((other, at_once)) = self.moments.along(moment.after_s) {
                sample.contacts[other].at(&at_once, self.pairs[other].impulse);
            }
            if time_s > self.emitted_s && time_s < now.time_s {
                self.emit_grid(now, time_s)?;
                take(&mut self.pairs, &sample);
                self.sink.extreme(&sample)?;
            }
        }
        Ok(())
    }

    /// A sample at a touch within the step: up to here the pair has had no impulse and the discs have moved freely, from
    /// here on not.
    fn pass_touch(
        &mut self,
        motion: &Motion,
        now: &BodiesSample,
        pair: usize,
        time_s: f64,
        closing: f64,
    ) -> Result<(), SinkError> {
        if time_s <= self.last.time_s {
            return Ok(());
        }
        let mut touch = between(&self.last, now, time_s);
        let time = time_s - self.last.time_s;
        let moving = self.scene.discs.iter().enumerate().filter(|(_, disc)| disc.motion.moves());
        for ((index, _), a) in moving.zip(&motion.step_accelerations) {
            let (from, to) = (&self.last.discs[index], &mut touch.discs[index]);
            let free = |axis: usize| {
                let rate = from.velocity_m_s[axis];
                [from.centre_m[axis] + time * (rate + 0.5 * time * a[axis]), rate + time * a[axis]]
            };
            let [[x, vx], [y, vy]] = [free(0), free(1)];
            (to.centre_m, to.velocity_m_s) = ([x, y], [vx, vy]);
            to.angle_rad = from.angle_rad + time * (from.spin_rad_s + 0.5 * time * a[2]);
            to.spin_rad_s = from.spin_rad_s + time * a[2];
        }
        for (contact, before) in touch.contacts.iter_mut().zip(&self.last.contacts) {
            contact.press_on(before);
        }
        touch.contacts[pair].not_yet_pressed(&self.last.contacts[pair], closing);
        self.emit_grid(&touch, time_s)?;
        self.emitted_s = time_s;
        take(&mut self.pairs, &touch);
        self.sink.sample(&touch)?;
        // Whatever comes until the end of the step comes at the rates after the impact.
        for (state, end) in touch.discs.iter_mut().zip(&now.discs) {
            (state.velocity_m_s, state.spin_rad_s) = (end.velocity_m_s, end.spin_rad_s);
        }
        self.last = touch;
        Ok(())
    }

    /// Impulse of one pair over the step, and changes that fell between two steps.
    fn close_step(&mut self, motion: &Motion, pair: usize, end_s: f64) -> Result<(), SinkError> {
        let force = motion.forces(pair).0;
        if let Some(native) = motion.native.iter().find(|native| native.index == pair)
            && force > 0.0
            && !self.pairs[pair].touching
        {
            self.change(pair, ChangeKind::Meets, end_s - motion.last_dt_s, native.closing, 0.0)?;
        }
        let tracked = &mut self.pairs[pair];
        if let Some(touch) = motion.touches.iter().find(|touch| touch.index == pair) {
            tracked.touching &= !touch.is_apart() || force > 0.0;
        }
        tracked.add_step(motion.normal_impulse(pair));
        match tracked.unnoticed(force) {
            Some(kind) => self.change(pair, kind, end_s, 0.0, 0.0),
            None => Ok(()),
        }
    }

    /// A change of one pair; `impulse` is that of the present step up to here.
    fn change(
        &mut self,
        pair: usize,
        kind: ChangeKind,
        time_s: f64,
        closing: f64,
        impulse: f64,
    ) -> Result<(), SinkError> {
        let Some(Told { kind, approach, impulse }) = self.pairs[pair].change(kind, time_s, closing, impulse) else {
            return Ok(());
        };
        self.work.events += 1;
        // Rates jump soon after an event: whoever interpolates needs the sample just before it.
        if self.emitted_s < self.last.time_s {
            self.emitted_s = self.last.time_s;
            take(&mut self.pairs, &self.last);
            self.sink.sample(&self.last)?;
        }
        self.sink.event(&BodiesEvent { time_s, pair, kind, approach_m_s: approach, impulse_n_s: impulse })
    }

    /// Samples of one step, or what is left of it: the grid points inside it, and its end where steps are short, extremes lie
    /// there, or the run is over.
    fn emit(&mut self, now: BodiesSample, dt: f64) -> Result<(), SinkError> {
        self.emit_grid(&now, now.time_s)?;
        self.last = now;
        let time_s = self.last.time_s;
        if self.grid.takes_end(time_s, dt) || time_s >= self.scene.duration_s {
            self.emitted_s = time_s;
            take(&mut self.pairs, &self.last);
            self.sink.sample(&self.last)
        } else if self.moments.at_end {
            take(&mut self.pairs, &self.last);
            self.sink.extreme(&self.last)
        } else {
            Ok(())
        }
    }

    /// The grid points before `until_s`, between the last sample and `end`.
    fn emit_grid(&mut self, end: &BodiesSample, until_s: f64) -> Result<(), SinkError> {
        while let Some(t) = self.grid.before(until_s) {
            // A grid can be so fine that one step holds millions of its points.
            if !self.sink.proceed() {
                break;
            }
            if t > self.last.time_s {
                self.emitted_s = t;
                let sample = between(&self.last, end, t);
                take(&mut self.pairs, &sample);
                self.sink.sample(&sample)?;
            }
        }
        Ok(())
    }

    /// The last sample, if the run broke off between grid points, and the summary.
    pub fn finish(mut self) -> Result<BodiesOutcome, SinkError> {
        if self.emitted_s < self.last.time_s {
            take(&mut self.pairs, &self.last);
            self.sink.sample(&self.last)?;
        }
        let pairs = self.pairs.into_iter().map(|tracked| tracked.summary).collect();
        Ok(BodiesOutcome { last: self.last, pairs, work: self.work })
    }
}

/// By rounding, and where a step has frozen the geometry, a sample can be above the extremes within the steps.
fn take(pairs: &mut [Tracked], sample: &BodiesSample) {
    pairs.iter_mut().enumerate().for_each(|(pair, tracked)| tracked.summary.take(sample.pressed(pair)));
}

impl Follow for EngineRecorder<'_> {
    fn step(&mut self, motion: &Motion) -> Result<(), SinkError> {
        EngineRecorder::step(self, motion)
    }

    fn proceed(&self) -> bool {
        self.sink.proceed()
    }
}
