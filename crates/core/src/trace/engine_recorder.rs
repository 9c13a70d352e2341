//! Turns the steps of the engine model into samples, events and summary figures.

use super::engine::Follow;
use super::engine_reading::{EngineReader, stored};
use super::grid::{Grid, Span};
use super::moments::Moments;
use super::tracked::{Told, Tracked};
use super::{Energy, Instant, Sink, SinkError, Work, between};
use crate::engine::{Change, ChangeKind, Motion, Site};

type Places<S> = <S as Instant>::Each<Tracked>;

pub(super) struct EngineRecorder<'a, R: EngineReader> {
    reader: &'a R,
    sink: &'a mut dyn Sink<R::Sample>,
    grid: Grid,
    end_s: f64,
    start_energy: Energy,
    places: Places<R::Sample>,
    last: R::Sample,
    emitted_s: f64,
    moments: Moments,
    work: Work,
    loop_gap_m: f64,
}

impl<'a, R: EngineReader> EngineRecorder<'a, R> {
    /// Of a motion with so many places of contact.
    pub fn new(reader: &'a R, motion: &Motion, places: usize, span: Span, sink: &'a mut dyn Sink<R::Sample>) -> Self {
        let start_energy = stored(motion);
        let impulses = R::Sample::each(places, |_| 0.0);
        Self {
            reader,
            sink,
            grid: Grid::new(span.numeric_hz),
            end_s: span.end_s,
            last: reader.sample(motion, start_energy.since(&start_energy, 0.0, 0.0), impulses.as_ref()),
            start_energy,
            places: R::Sample::each(places, |_| Tracked::default()),
            emitted_s: 0.0,
            moments: Moments::default(),
            work: Work::default(),
            loop_gap_m: motion.linkage.gap(),
        }
    }

    /// Contacts that are there from the start, and the first sample.
    pub fn begin(&mut self, motion: &Motion) -> Result<(), SinkError> {
        for touch in motion.touches.iter().filter(|touch| touch.gap < 0.0) {
            let place = self.reader.place(motion.plan, touch.index);
            self.change(place, ChangeKind::Meets, 0.0, 0.0, 0.0)?;
            self.places.as_mut()[place].summary.take(self.last.pressed(place));
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
        self.loop_gap_m = self.loop_gap_m.max(motion.linkage.gap());
        let now = self.node(motion);
        self.meet_between_steps(motion, end_s - dt)?;
        self.find_extremes(motion);
        for index in 0..motion.contact.changes.len() {
            let Change { after_s, site, kind, closing, impulse } = motion.contact.changes[index];
            let place = self.reader.place(motion.plan, motion.space.sites[site].touch.index);
            let time_s = end_s - dt + after_s;
            self.pass_extremes(&now, dt, after_s)?;
            if kind == ChangeKind::Meets && !self.places.as_ref()[place].touching {
                self.pass_touch(motion, &now, place, time_s, closing)?;
            }
            self.change(place, kind, time_s, closing, impulse)?;
        }
        self.pass_extremes(&now, dt, dt)?;
        for place in 0..now.places() {
            self.close_step(motion, place, end_s)?;
        }
        self.emit(now, dt)
    }

    /// The end of the step as a sample.
    fn node(&self, motion: &Motion) -> R::Sample {
        let places = self.places.as_ref();
        let impulses = R::Sample::each(places.len(), |place| {
            let index = self.reader.index(motion.plan, place);
            places[place].impulse + index.map_or(0.0, |index| motion.normal_impulse(index))
        });
        let energy = stored(motion).since(&self.start_energy, motion.contact_work_j, motion.motor_work_j);
        self.reader.sample(motion, energy, impulses.as_ref())
    }

    /// Surfaces that the last step left apart, in its frozen geometry, or that the run starts with, and that overlap where this
    /// one starts. What recedes has just been left, and overlaps by rounding.
    fn meet_between_steps(&mut self, motion: &Motion, start_s: f64) -> Result<(), SinkError> {
        let meets = |at: &&Site| at.touch.gap <= 0.0 && motion.space.closes(at);
        for at in motion.space.sites.iter().filter(meets) {
            let closing = (-motion.space.rate[at.normal]).max(0.0);
            let place = self.reader.place(motion.plan, at.touch.index);
            self.change(place, ChangeKind::Meets, start_s, closing, 0.0)?;
        }
        Ok(())
    }

    /// Finds where in the step a contact is deeper, or presses harder, than ever before.
    fn find_extremes(&mut self, motion: &Motion) {
        self.moments.clear();
        for (place, tracked) in self.places.as_mut().iter_mut().enumerate() {
            let Some(index) = self.reader.index(motion.plan, place) else { continue };
            let within = motion.contact_extremes(index);
            let depth = motion.touches.iter().find(|touch| touch.index == index).map_or(0.0, |touch| -touch.gap);
            let end = [motion.forces(index).0, depth];
            self.moments.take(place, &mut tracked.summary, within, motion.last_dt_s, end);
        }
        self.moments.sort();
    }

    /// Samples at the extremes of a step of length `dt` that come before `after_s`.
    fn pass_extremes(&mut self, now: &R::Sample, dt: f64, after_s: f64) -> Result<(), SinkError> {
        while let Some((place, moment)) = self.moments.before(after_s) {
            let time_s = now.time_s() - dt + moment.after_s;
            let mut sample = between(&self.last, now, time_s);
            let places = self.places.as_ref();
            sample.contact_mut(place).at(&moment, places[place].impulse);
            while let Some((other, at_once)) = self.moments.along(moment.after_s) {
                sample.contact_mut(other).at(&at_once, places[other].impulse);
            }
            if time_s > self.emitted_s && time_s < now.time_s() {
                self.emit_grid(now, time_s)?;
                take(self.places.as_mut(), &sample);
                self.sink.extreme(&sample)?;
            }
        }
        Ok(())
    }

    /// A sample at a touch within the step: up to here the place has had no impulse and the bodies have moved freely, from
    /// here on not.
    fn pass_touch(
        &mut self,
        motion: &Motion,
        now: &R::Sample,
        place: usize,
        time_s: f64,
        closing: f64,
    ) -> Result<(), SinkError> {
        if time_s <= self.last.time_s() {
            return Ok(());
        }
        let mut touch = between(&self.last, now, time_s);
        self.reader.fly(&mut touch, &self.last, &motion.step_accelerations);
        for at in 0..touch.places() {
            touch.contact_mut(at).press_on(self.last.contact(at));
        }
        touch.contact_mut(place).not_yet_pressed(self.last.contact(place), closing);
        self.emit_grid(&touch, time_s)?;
        self.emitted_s = time_s;
        take(self.places.as_mut(), &touch);
        self.sink.sample(&touch)?;
        // Whatever comes until the end of the step comes at the rates after the impact.
        self.reader.take_rates(&mut touch, now);
        self.last = touch;
        Ok(())
    }

    /// Impulse of one place over the step, and changes that fell between two steps.
    fn close_step(&mut self, motion: &Motion, place: usize, end_s: f64) -> Result<(), SinkError> {
        let Some(index) = self.reader.index(motion.plan, place) else { return Ok(()) };
        let force = motion.forces(index).0;
        if let Some(native) = motion.native.iter().find(|native| native.index == index)
            && force > 0.0
            && !self.places.as_ref()[place].touching
        {
            self.change(place, ChangeKind::Meets, end_s - motion.last_dt_s, native.closing, 0.0)?;
        }
        let tracked = &mut self.places.as_mut()[place];
        if let Some(touch) = motion.touches.iter().find(|touch| touch.index == index) {
            tracked.touching &= !touch.is_apart() || force > 0.0;
        }
        tracked.add_step(motion.normal_impulse(index));
        match tracked.unnoticed(force) {
            Some(kind) => self.change(place, kind, end_s, 0.0, 0.0),
            None => Ok(()),
        }
    }

    /// A change of one place; `impulse` is that of the present step up to here.
    fn change(
        &mut self,
        place: usize,
        kind: ChangeKind,
        time_s: f64,
        closing: f64,
        impulse: f64,
    ) -> Result<(), SinkError> {
        let changed = self.places.as_mut()[place].change(kind, time_s, closing, impulse);
        let Some(Told { kind, approach, impulse }) = changed else { return Ok(()) };
        self.work.events += 1;
        // Rates jump soon after an event: whoever interpolates needs the sample just before it.
        if self.emitted_s < self.last.time_s() {
            self.emitted_s = self.last.time_s();
            take(self.places.as_mut(), &self.last);
            self.sink.sample(&self.last)?;
        }
        self.sink.event(&R::Sample::event(time_s, place, kind, approach, impulse))
    }

    /// Samples of one step, or what is left of it: the grid points inside it, and its end where steps are short, extremes lie
    /// there, or the run is over.
    fn emit(&mut self, now: R::Sample, dt: f64) -> Result<(), SinkError> {
        let time_s = now.time_s();
        self.emit_grid(&now, time_s)?;
        self.last = now;
        if self.grid.takes_end(time_s, dt) || time_s >= self.end_s {
            self.emitted_s = time_s;
            take(self.places.as_mut(), &self.last);
            self.sink.sample(&self.last)
        } else if self.moments.at_end {
            take(self.places.as_mut(), &self.last);
            self.sink.extreme(&self.last)
        } else {
            Ok(())
        }
    }

    /// The grid points before `until_s`, between the last sample and `end`.
    fn emit_grid(&mut self, end: &R::Sample, until_s: f64) -> Result<(), SinkError> {
        while let Some(t) = self.grid.before(until_s) {
            // A grid can be so fine that one step holds millions of its points.
            if !self.sink.proceed() {
                break;
            }
            if t > self.last.time_s() {
                self.emitted_s = t;
                let sample = between(&self.last, end, t);
                take(self.places.as_mut(), &sample);
                self.sink.sample(&sample)?;
            }
        }
        Ok(())
    }

    /// The last sample, if the run broke off between grid points, and the summary.
    pub fn finish(mut self) -> Result<<R::Sample as Instant>::Outcome, SinkError> {
        if self.emitted_s < self.last.time_s() {
            take(self.places.as_mut(), &self.last);
            self.sink.sample(&self.last)?;
        }
        let places = self.places.as_ref();
        let sites = R::Sample::each(places.len(), |place| places[place].summary);
        Ok(self.last.outcome(sites, self.work, self.loop_gap_m))
    }
}

/// By rounding, and where a step has frozen the geometry, a sample can be above the extremes within the steps.
fn take<S: Instant>(places: &mut [Tracked], sample: &S) {
    places.iter_mut().enumerate().for_each(|(place, tracked)| tracked.summary.take(sample.pressed(place)));
}

impl<R: EngineReader> Follow for EngineRecorder<'_, R> {
    fn step(&mut self, motion: &Motion) -> Result<(), SinkError> {
        EngineRecorder::step(self, motion)
    }

    fn proceed(&self) -> bool {
        self.sink.proceed()
    }
}
