//! Turns the steps of the engine model into samples, events and summary figures.

use super::engine::Follow;
use super::engine_reading::{Start, forces, sample};
use super::grid::Grid;
use super::moments::Moments;
use super::tracked::{Told, Tracked};
use super::{Event, Instant, Outcome, Sample, Sink, SinkError, Site, Work, between};
use crate::engine::{self, Change, ChangeKind, L11, L12, L21, L22, Moment, Motion};
use crate::scene::Scene;

pub(super) struct EngineRecorder<'a> {
    sink: &'a mut dyn Sink,
    grid: Grid,
    end_s: f64,
    start: Start,
    phi22_rad: f64,
    sites: [Tracked; 3],
    last: Sample,
    emitted_s: f64,
    moments: Moments,
    work: Work,
    loop_gap_m: f64,
}

impl<'a> EngineRecorder<'a> {
    pub fn new(scene: &Scene, motion: &Motion, sink: &'a mut dyn Sink) -> Self {
        let start = Start::new(motion);
        Self {
            sink,
            grid: Grid::new(scene.log.numeric_hz),
            end_s: scene.duration_s,
            last: sample(motion, scene.finger.lengths.phi22_rad, &start, &[0.0; 3]),
            start,
            phi22_rad: scene.finger.lengths.phi22_rad,
            sites: [Tracked::default(); 3],
            emitted_s: 0.0,
            moments: Moments::default(),
            work: Work::default(),
            loop_gap_m: motion.linkage.gap(),
        }
    }

    /// Contacts that are there from the start, and the first sample.
    pub fn begin(&mut self, motion: &Motion) -> Result<(), SinkError> {
        for touch in motion.touches.iter().filter(|touch| touch.gap < 0.0) {
            let site = engine::site(motion.plan, touch.index);
            self.change(site, ChangeKind::Meets, 0.0, 0.0, 0.0)?;
            let summary = &mut self.sites[site as usize].summary;
            summary.take(self.last.pressed(site as usize));
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
        let impulses = Site::ALL.map(|site| self.sites[site as usize].impulse + impulse(motion, site));
        let now = sample(motion, self.phi22_rad, &self.start, &impulses);
        self.meet_between_steps(motion, end_s - dt)?;
        self.find_extremes(motion);
        for index in 0..motion.contact.changes.len() {
            let Change { after_s, site, kind, closing, impulse } = motion.contact.changes[index];
            let site = engine::site(motion.plan, motion.space.sites[site].touch.index);
            let time_s = end_s - dt + after_s;
            self.pass_extremes(&now, dt, after_s)?;
            if kind == ChangeKind::Meets && !self.sites[site as usize].touching {
                self.pass_touch(motion, &now, site, time_s, closing)?;
            }
            self.change(site, kind, time_s, closing, impulse)?;
        }
        self.pass_extremes(&now, dt, dt)?;
        for site in Site::ALL {
            self.close_step(motion, site, end_s)?;
        }
        self.emit(&now, dt)
    }

    /// Surfaces that the last step left apart, in its frozen geometry, or that the run starts with, and that overlap where this
    /// one starts. What recedes has just been left, and overlaps by rounding.
    fn meet_between_steps(&mut self, motion: &Motion, start_s: f64) -> Result<(), SinkError> {
        let meets = |at: &&engine::Site| at.touch.gap <= 0.0 && motion.space.closes(at);
        for at in motion.space.sites.iter().filter(meets) {
            let closing = (-motion.space.rate[at.normal]).max(0.0);
            self.change(engine::site(motion.plan, at.touch.index), ChangeKind::Meets, start_s, closing, 0.0)?;
        }
        Ok(())
    }

    /// Finds where in the step a site is deeper, or presses harder, than ever before.
    fn find_extremes(&mut self, motion: &Motion) {
        self.moments.clear();
        for site in Site::ALL {
            let Some(index) = engine::index_of(motion.plan, site) else { continue };
            let within = motion.contact_extremes(index);
            let depth = motion.touches.iter().find(|touch| touch.index == index).map_or(0.0, |touch| -touch.gap);
            let summary = &mut self.sites[site as usize].summary;
            self.moments.take(site as usize, summary, within, motion.last_dt_s, [forces(motion, site).0, depth]);
        }
        self.moments.sort();
    }

    /// Samples at the extremes of a step of length `dt` that come before `after_s`.
    fn pass_extremes(&mut self, now: &Sample, dt: f64, after_s: f64) -> Result<(), SinkError> {
        while let Some((site, moment)) = self.moments.before(after_s) {
            let time_s = now.time_s - dt + moment.after_s;
            let mut sample = between(&self.last, now, time_s);
            self.put_moment(&mut sample, site, &moment);
            while let Some((other, at_once)) = self.moments.along(moment.after_s) {
                self.put_moment(&mut sample, other, &at_once);
            }
            if time_s > self.emitted_s && time_s < now.time_s {
                self.emit_grid(now, time_s)?;
                self.show_extreme(&sample)?;
            }
        }
        Ok(())
    }

    fn put_moment(&self, sample: &mut Sample, site: usize, moment: &Moment) {
        let contact = match Site::ALL[site] {
            Site::Proximal => &mut sample.proximal,
            Site::Distal => &mut sample.distal,
            Site::Limit => &mut sample.limit,
        };
        contact.at(moment, self.sites[site].impulse);
    }

    /// A sample at a touch within the step: up to here the site has had no impulse and the bodies have moved freely, from
    /// here on not.
    fn pass_touch(
        &mut self,
        motion: &Motion,
        now: &Sample,
        site: Site,
        time_s: f64,
        closing: f64,
    ) -> Result<(), SinkError> {
        if time_s <= self.last.time_s {
            return Ok(());
        }
        let mut touch = between(&self.last, now, time_s);
        fly(&mut touch, &self.last, |body| motion.step_accelerations[body][2]);
        let last = &self.last;
        for (contact, before, at) in [
            (&mut touch.proximal, &last.proximal, Site::Proximal),
            (&mut touch.distal, &last.distal, Site::Distal),
            (&mut touch.limit, &last.limit, Site::Limit),
        ] {
            contact.press_on(before);
            if at == site {
                contact.not_yet_pressed(before, closing);
            }
        }
        self.emit_grid(&touch, time_s)?;
        self.emitted_s = time_s;
        self.show(&touch)?;
        // Whatever comes until the end of the step comes at the rates after the impact.
        self.last = Sample {
            qd11_rad_s: now.qd11_rad_s,
            qd21_rad_s: now.qd21_rad_s,
            qd12_rad_s: now.qd12_rad_s,
            qd22_rad_s: now.qd22_rad_s,
            ..touch
        };
        Ok(())
    }

    /// Impulse of one site over the step, and changes that fell between two steps.
    fn close_step(&mut self, motion: &Motion, site: Site, end_s: f64) -> Result<(), SinkError> {
        let Some(index) = engine::index_of(motion.plan, site) else { return Ok(()) };
        let force = forces(motion, site).0;
        if let Some(native) = motion.native.iter().find(|native| native.index == index)
            && force > 0.0
            && !self.sites[site as usize].touching
        {
            self.change(site, ChangeKind::Meets, end_s - motion.last_dt_s, native.closing, 0.0)?;
        }
        let tracked = &mut self.sites[site as usize];
        if let Some(touch) = motion.touches.iter().find(|touch| touch.index == index) {
            tracked.touching &= !touch.is_apart() || force > 0.0;
        }
        tracked.add_step(impulse(motion, site));
        match tracked.unnoticed(force) {
            Some(kind) => self.change(site, kind, end_s, 0.0, 0.0),
            None => Ok(()),
        }
    }

    /// A change of one site; `impulse` is that of the present step up to here.
    fn change(
        &mut self,
        site: Site,
        kind: ChangeKind,
        time_s: f64,
        closing: f64,
        impulse: f64,
    ) -> Result<(), SinkError> {
        let Some(Told { kind, approach, impulse }) = self.sites[site as usize].change(kind, time_s, closing, impulse)
        else {
            return Ok(());
        };
        self.work.events += 1;
        // Rates jump soon after an event: whoever interpolates needs the sample just before it.
        if self.emitted_s < self.last.time_s {
            let last = self.last;
            self.emitted_s = last.time_s;
            self.show(&last)?;
        }
        self.sink.event(&Event { time_s, site, kind, approach_speed: approach, impulse })
    }

    /// Hands out a sample; by rounding, and where a step has frozen the geometry, it can be above the extremes within the steps.
    fn show(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.take(sample);
        self.sink.sample(sample)
    }

    fn show_extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.take(sample);
        self.sink.extreme(sample)
    }

    fn take(&mut self, sample: &Sample) {
        for (index, site) in self.sites.iter_mut().enumerate() {
            site.summary.take(sample.pressed(index));
        }
    }

    /// Samples of one step, or what is left of it: the grid points inside it, and its end where steps are short, extremes lie
    /// there, or the run is over.
    fn emit(&mut self, now: &Sample, dt: f64) -> Result<(), SinkError> {
        self.emit_grid(now, now.time_s)?;
        self.last = *now;
        if self.grid.takes_end(now.time_s, dt) || now.time_s >= self.end_s {
            self.emitted_s = now.time_s;
            self.show(now)
        } else if self.moments.at_end {
            self.show_extreme(now)
        } else {
            Ok(())
        }
    }

    /// The grid points before `until_s`, between the last sample and `end`.
    fn emit_grid(&mut self, end: &Sample, until_s: f64) -> Result<(), SinkError> {
        while let Some(t) = self.grid.before(until_s) {
            // A grid can be so fine that one step holds millions of its points.
            if !self.sink.proceed() {
                break;
            }
            if t > self.last.time_s {
                self.emitted_s = t;
                self.show(&between(&self.last, end, t))?;
            }
        }
        Ok(())
    }

    /// The last sample, if the run broke off between grid points, and the summary.
    pub fn finish(mut self) -> Result<Outcome, SinkError> {
        if self.emitted_s < self.last.time_s {
            let last = self.last;
            self.show(&last)?;
        }
        let sites = self.sites.map(|tracked| tracked.summary);
        Ok(Outcome { last: self.last, sites, work: self.work, loop_gap_m: self.loop_gap_m })
    }
}

/// Normal impulse of a site in the last step.
fn impulse(motion: &Motion, site: Site) -> f64 {
    engine::index_of(motion.plan, site).map_or(0.0, |index| motion.normal_impulse(index))
}

/// Angles and rates of `sample` as free motion from `from` makes them, given the angular acceleration of each body.
fn fly(sample: &mut Sample, from: &Sample, acceleration: impl Fn(usize) -> f64) {
    let time = sample.time_s - from.time_s;
    let [a11, a12, a21, a22] = [L11, L12, L21, L22].map(acceleration);
    let angle = |q: f64, rate: f64, a: f64| q + time * (rate + 0.5 * time * a);
    sample.q11_rad = angle(from.q11_rad, from.qd11_rad_s, a11);
    sample.q21_rad = angle(from.q21_rad, from.qd21_rad_s, a21);
    sample.q12_rad = angle(from.q12_rad, from.qd12_rad_s, a12 - a11);
    sample.q22_rad = angle(from.q22_rad, from.qd22_rad_s, a22 - a21);
    sample.q13_rad = sample.q21_rad + sample.q22_rad;
    sample.qd11_rad_s = from.qd11_rad_s + time * a11;
    sample.qd21_rad_s = from.qd21_rad_s + time * a21;
    sample.qd12_rad_s = from.qd12_rad_s + time * (a12 - a11);
    sample.qd22_rad_s = from.qd22_rad_s + time * (a22 - a21);
}

impl Follow for EngineRecorder<'_> {
    fn step(&mut self, motion: &Motion) -> Result<(), SinkError> {
        EngineRecorder::step(self, motion)
    }

    fn proceed(&self) -> bool {
        self.sink.proceed()
    }
}
