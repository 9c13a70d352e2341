//! Turns the steps of the engine model into samples, events and summary figures.

use super::engine_reading::{self as reading, contact, stored};
use super::follow::Follow;
use super::grid::{Grid, Span};
use super::moments::Moments;
use super::sample::OVERLAP_ROUNDING;
use super::soundness::Soundness;
use super::tracked::{Told, Tracked};
use super::{ContactSample, Energy, Event, Outcome, Reach, Sample, Sink, SinkError, Work};
use crate::engine::{Change, ChangeKind, Motion, RESTING, Site};
use crate::scene::{Scene, System};

pub(super) struct EngineRecorder<'a> {
    system: &'a System,
    sink: &'a mut dyn Sink,
    grid: Grid,
    end_s: f64,
    /// The region whose boundary ends the run, and when the object left it.
    reach: Option<Reach>,
    ejected_s: Option<f64>,
    start_energy: Energy,
    places: Vec<Tracked>,
    /// Which of them have the normal turned round that the plan has.
    turned: Vec<bool>,
    last: Sample,
    /// Room for the end of the step at hand, for a sample at a change or an extreme within it, and for one on the grid.
    node: Sample,
    within: Sample,
    point: Sample,
    emitted_s: f64,
    moments: Moments,
    work: Work,
    loop_gap_m: f64,
    soundness: Soundness,
    broken: Option<String>,
}

impl<'a> EngineRecorder<'a> {
    /// Of a motion of a scene.
    pub fn new(scene: &'a Scene, motion: &Motion, span: Span, sink: &'a mut dyn Sink) -> Self {
        let system = &scene.system;
        let start_energy = stored(motion);
        let turned = reading::turned(system);
        let places = vec![Tracked::default(); turned.len()];
        let mut last = Sample::default();
        read(system, motion, start_energy.since(&start_energy, 0.0, 0.0), (&places, &turned), &mut last);
        Self {
            system,
            sink,
            grid: Grid::new(span),
            end_s: span.end_s,
            reach: Reach::of(system),
            ejected_s: None,
            last,
            node: Sample::default(),
            within: Sample::default(),
            point: Sample::default(),
            start_energy,
            places,
            turned,
            emitted_s: 0.0,
            moments: Moments::default(),
            work: Work::default(),
            loop_gap_m: motion.linkage.gap(),
            soundness: Soundness::new(system, scene.engine.stepping, start_energy),
            broken: None,
        }
    }

    /// Contacts that are there from the start, and the first sample.
    pub fn begin(&mut self, motion: &Motion) -> Result<(), SinkError> {
        for touch in motion.touches.iter().filter(|touch| touch.gap < 0.0 && touch.has_gap()) {
            let Some(place) = motion.plan.place(touch.index) else { continue };
            let contact = self.last.contacts[place];
            // Surfaces that just touch and recede overlap by rounding only.
            if contact.gap_m >= -OVERLAP_ROUNDING && contact.gap_rate_m_s > RESTING {
                continue;
            }
            self.change(place, ChangeKind::Meets, 0.0, contact.approach_at_start(), 0.0)?;
            self.places[place].summary.take(self.last.contacts[place].pressed());
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
        let gap_m = motion.linkage.gap();
        self.loop_gap_m = self.loop_gap_m.max(gap_m);
        let mut now = std::mem::take(&mut self.node);
        let energy = stored(motion).since(&self.start_energy, motion.contact_work_j, motion.motor_work_j);
        self.broken = self.soundness.take(&energy, gap_m, dt);
        read(self.system, motion, energy, (&self.places, &self.turned), &mut now);
        self.meet_between_steps(motion, end_s - dt)?;
        self.find_extremes(motion);
        for index in 0..motion.contact.changes.len() {
            let Change { after_s, site, kind, closing, impulse } = motion.contact.changes[index];
            let Some(place) = motion.plan.place(motion.space.sites[site].touch.index) else { continue };
            let time_s = end_s - dt + after_s;
            self.pass_extremes(&now, dt, after_s)?;
            if kind == ChangeKind::Meets && !self.places[place].touching {
                self.pass_touch(motion, &now, place, time_s, closing)?;
            }
            self.change(place, kind, time_s, closing, impulse)?;
        }
        self.pass_extremes(&now, dt, dt)?;
        for place in 0..self.places.len() {
            self.close_step(motion, place, end_s)?;
        }
        // A step that is none ends the run by itself.
        let is_sound = self.broken.is_none();
        if is_sound && self.is_touched() && self.reach.is_some_and(|reach| reach.leaves(&self.last, &now)) {
            self.ejected_s = Some(end_s);
        }
        self.node = now;
        self.emit(dt)
    }

    /// Whether something has touched the object.
    fn is_touched(&self) -> bool {
        let touched = |(index, place): (usize, &Tracked)| place.summary.touchdowns > 0 && !self.last.is_stop(index);
        self.places.iter().enumerate().any(touched)
    }

    /// Surfaces that the last step left apart, in its frozen geometry, or that the run starts with, and that overlap where this
    /// one starts. What recedes has just been left, and overlaps by rounding.
    fn meet_between_steps(&mut self, motion: &Motion, start_s: f64) -> Result<(), SinkError> {
        let meets = |at: &&Site| at.touch.gap <= 0.0 && motion.space.closes(at);
        for at in motion.space.sites.iter().filter(meets) {
            let closing = (-motion.space.rate[at.normal]).max(0.0);
            let Some(place) = motion.plan.place(at.touch.index) else { continue };
            self.change(place, ChangeKind::Meets, start_s, closing, 0.0)?;
        }
        Ok(())
    }

    /// Finds where in the step a contact is deeper, or presses harder, than ever before.
    fn find_extremes(&mut self, motion: &Motion) {
        self.moments.clear();
        for (place, tracked) in self.places.iter_mut().enumerate() {
            let Some(index) = motion.plan.index(place) else { continue };
            let within = motion.contact_extremes(index);
            let depth = motion.touches.iter().find(|touch| touch.index == index).map_or(0.0, |touch| -touch.gap);
            let end = [motion.forces(index).0, depth];
            self.moments.take(place, &mut tracked.summary, within, motion.last_dt_s, end);
        }
        self.moments.sort();
    }

    /// Samples at the extremes of a step of length `dt` that come before `after_s`.
    fn pass_extremes(&mut self, now: &Sample, dt: f64, after_s: f64) -> Result<(), SinkError> {
        while let Some((place, moment)) = self.moments.before(after_s) {
            let time_s = now.time_s - dt + moment.after_s;
            let sample = &mut self.within;
            sample.become_between(&self.last, now, time_s);
            sample.contacts[place].at(&moment, self.places[place].impulse);
            while let Some((other, at_once)) = self.moments.along(moment.after_s) {
                sample.contacts[other].at(&at_once, self.places[other].impulse);
            }
            if time_s > self.emitted_s && time_s < now.time_s {
                self.emit_grid(now, time_s)?;
                take(&mut self.places, &self.within);
                self.sink.extreme(&self.within)?;
            }
        }
        Ok(())
    }

    /// A sample at a touch within the step: up to here the place has had no impulse and the bodies have moved freely, from
    /// here on not.
    fn pass_touch(
        &mut self,
        motion: &Motion,
        now: &Sample,
        place: usize,
        time_s: f64,
        closing: f64,
    ) -> Result<(), SinkError> {
        if time_s <= self.last.time_s {
            return Ok(());
        }
        let mut touch = std::mem::take(&mut self.within);
        touch.become_between(&self.last, now, time_s);
        reading::fly(self.system, &mut touch, &self.last, motion);
        for (contact, before) in touch.contacts.iter_mut().zip(&self.last.contacts) {
            contact.press_on(before);
        }
        touch.contacts[place].not_yet_pressed(&self.last.contacts[place], closing);
        self.emit_grid(&touch, time_s)?;
        self.emitted_s = time_s;
        take(&mut self.places, &touch);
        self.sink.sample(&touch)?;
        // Whatever comes until the end of the step comes at the rates after the impact.
        touch.take_rates(now);
        self.within = std::mem::replace(&mut self.last, touch);
        Ok(())
    }

    /// Impulse of one place over the step, and changes that fell between two steps.
    fn close_step(&mut self, motion: &Motion, place: usize, end_s: f64) -> Result<(), SinkError> {
        let Some(index) = motion.plan.index(place) else { return Ok(()) };
        let force = motion.forces(index).0;
        if force > 0.0 && !self.places[place].touching {
            // rapier's own contact tells of no touch-down, and a step that began with an overlap has passed it.
            let native = motion.native.iter().find(|native| native.index == index);
            let closing = native.map_or(0.0, |native| native.closing);
            self.change(place, ChangeKind::Meets, end_s - motion.last_dt_s, closing, 0.0)?;
        }
        let tracked = &mut self.places[place];
        if let Some(touch) = motion.touches.iter().find(|touch| touch.index == index) {
            tracked.touching &= !touch.is_apart() || force > 0.0;
        }
        tracked.add_step(motion.normal_impulse(index));
        if let Some(kind) = tracked.unnoticed(force) {
            self.change(place, kind, end_s, 0.0, 0.0)?;
        }
        // Between two steps directions turn, and a bristle may have come over the end of its cone.
        let slips = self.places[place].slip(motion.slips(index));
        slips.map_or(Ok(()), |told| self.tell(place, end_s, told))
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
        let changed = self.places[place].change(kind, time_s, closing, impulse);
        changed.map_or(Ok(()), |told| self.tell(place, time_s, told))
    }

    fn tell(&mut self, contact: usize, time_s: f64, told: Told) -> Result<(), SinkError> {
        let Told { kind, approach: approach_speed, impulse } = told;
        let event = Event { time_s, contact, kind, approach_speed, impulse };
        if kind.is_of_friction() {
            return self.sink.event(&event);
        }
        self.work.events += 1;
        // Rates jump soon after an event: whoever interpolates needs the sample just before it.
        if self.emitted_s < self.last.time_s {
            self.emitted_s = self.last.time_s;
            take(&mut self.places, &self.last);
            self.sink.sample(&self.last)?;
        }
        self.sink.event(&event)
    }

    /// Samples of one step, or what is left of it: the grid points inside it, and its end where steps are short, extremes lie
    /// there, or the run is over.
    fn emit(&mut self, dt: f64) -> Result<(), SinkError> {
        let now = std::mem::take(&mut self.node);
        let time_s = now.time_s;
        self.emit_grid(&now, time_s)?;
        self.node = std::mem::replace(&mut self.last, now);
        if self.grid.takes_end(time_s, dt) || time_s >= self.end_s {
            self.emitted_s = time_s;
            take(&mut self.places, &self.last);
            self.sink.sample(&self.last)
        } else if self.moments.at_end {
            take(&mut self.places, &self.last);
            self.sink.extreme(&self.last)
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
                self.point.become_between(&self.last, end, t);
                take(&mut self.places, &self.point);
                self.sink.sample(&self.point)?;
            }
        }
        Ok(())
    }

    /// The last sample, if the run broke off between grid points, and the summary.
    pub fn finish(mut self) -> Result<Outcome, SinkError> {
        if self.emitted_s < self.last.time_s {
            take(&mut self.places, &self.last);
            self.sink.sample(&self.last)?;
        }
        let contacts = self.places.iter().map(|tracked| tracked.summary).collect();
        Ok(Outcome {
            last: self.last,
            contacts,
            work: self.work,
            loop_gap_m: self.loop_gap_m,
            ejected_s: self.ejected_s,
        })
    }
}

/// By rounding, and where a step has frozen the geometry, a sample can be above the extremes within the steps.
fn take(places: &mut [Tracked], sample: &Sample) {
    places.iter_mut().zip(&sample.contacts).for_each(|(tracked, contact)| tracked.summary.take(contact.pressed()));
}

/// The node as a sample, where these are its energies and its places of contact up to the start of the step.
fn read(
    system: &System,
    motion: &Motion,
    energy: Energy,
    (places, turned): (&[Tracked], &[bool]),
    sample: &mut Sample,
) {
    sample.time_s = motion.clock.now();
    reading::read(system, motion, sample);
    sample.contacts.clear();
    sample.contacts.extend(places.iter().zip(turned).enumerate().map(|(place, (tracked, turned))| {
        let index = motion.plan.index(place);
        // Before the first step there is none.
        let stepped = index.filter(|_| motion.last_dt_s > 0.0);
        let impulse = tracked.impulse + stepped.map_or(0.0, |index| motion.normal_impulse(index));
        let contact = contact(motion, index, impulse);
        ContactSample { normal: if *turned { contact.normal.map(|part| -part) } else { contact.normal }, ..contact }
    }));
    sample.energy = energy;
}

impl Follow for EngineRecorder<'_> {
    fn step(&mut self, motion: &Motion) -> Result<(), SinkError> {
        EngineRecorder::step(self, motion)
    }

    fn exit_in_s(&self) -> f64 {
        let object = self.last.bodies.first().filter(|_| self.is_touched());
        self.reach.zip(object).map_or(f64::INFINITY, |(reach, object)| reach.exit_in_s(object))
    }

    fn broken(&self) -> Option<&str> {
        self.broken.as_deref()
    }

    fn proceed(&self) -> bool {
        self.ejected_s.is_none() && self.sink.proceed()
    }
}
