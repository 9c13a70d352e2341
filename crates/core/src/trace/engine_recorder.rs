//! Converts the steps of the engine model into samples, events and summary figures.

use super::consistency::ConsistencyCheck;
use super::contact_tracker::{ContactTracker, ReportedEvent, has_hand_touched, update_summaries};
use super::engine_reading::{self as reading, JointForces, sample_contact, stored_energy};
use super::extrema::StepExtrema;
use super::grid::{RecordingOptions, RecordingTime, RecordingTimes};
use super::sample::OVERLAP_ROUNDING;
use super::{Counts, Energy, Exit, Outcome, Sample, Schema, Sink, SinkError, Work};
use crate::engine::{
    ActiveContact, Change, ChangeKind, ContactExtremum, Motion, PalmFrame, PlannedActuator, ZERO_RATE,
};
use crate::scene::Scene;

/// Observer that records an engine run.
pub(super) struct EngineRecorder<'a> {
    pub scene: &'a Scene,
    pub sink: &'a mut dyn Sink,
    pub state: &'a mut EngineRecorderState,
}

/// State of a recorder between two steps.
#[derive(Clone)]
pub(super) struct EngineRecorderState {
    times: RecordingTimes,
    /// Condition that ends the run.
    exit: Option<Exit>,
    /// Time at which the object left the hand.
    ejected_s: Option<f64>,
    pub joint_forces: JointForces,
    start_energy: Energy,
    trackers: Vec<ContactTracker>,
    last: Sample,
    /// Buffer for the sample at the end of the current step.
    node: Sample,
    /// Buffer for a sample at a change or extremum within the step.
    within: Sample,
    /// Buffer for a sample on the grid or a point.
    point: Sample,
    emitted_s: f64,
    step_extrema: StepExtrema<(usize, ContactExtremum)>,
    work: Work,
    loop_gap_m: f64,
    consistency: ConsistencyCheck,
    /// Reason why the last step is not a valid motion; `None` if it is valid.
    pub failure: Option<String>,
}

impl EngineRecorderState {
    /// Creates a recorder for a motion of a scene at its start.
    pub fn new(scene: &Scene, motion: &mut Motion, recording: RecordingOptions) -> Self {
        let RecordingOptions { counts, span, ends_at_exit, required_data, .. } = recording;
        let start_energy = stored_energy(motion);
        let trackers = vec![ContactTracker::default(); counts.contacts];
        let mut last = Sample::default();
        let energy = start_energy.relative_to(&start_energy, 0.0, 0.0);
        read_node(motion, (counts, energy), &trackers, &mut last);
        let joint_forces = JointForces::new(required_data.joint_forces, motion);
        joint_forces.set(motion, &mut last);
        Self {
            joint_forces,
            times: RecordingTimes::new(span, required_data.point_interval_s),
            exit: Exit::from_scene(scene).filter(|_| ends_at_exit),
            ejected_s: None,
            last,
            node: Sample::default(),
            within: Sample::default(),
            point: Sample::default(),
            start_energy,
            trackers,
            emitted_s: 0.0,
            step_extrema: StepExtrema::default(),
            work: Work::default(),
            loop_gap_m: motion.linkage.max_joint_opening(),
            consistency: ConsistencyCheck::new(scene, start_energy),
            failure: None,
        }
    }

    /// Returns the sample at the end of the last step.
    pub fn last(&self) -> &Sample {
        &self.last
    }
}

/// Explains which number of a sample is not finite, if there is one.
pub(super) fn describe_not_finite(scene: &Scene, sample: &Sample) -> Option<String> {
    let index = sample.find_not_finite()?;
    let channels = Schema::from_scene(scene).channels();
    let name = channels.iter().find(|channel| channel.index() == Some(index)).map_or("a quantity", |found| &found.name);
    Some(format!(
        "`{name}` is not a finite number: masses, lengths, stiffnesses and forces of the scene differ too much for double \
         precision; make the extreme ones more similar"
    ))
}

impl EngineRecorder<'_> {
    /// Emits the touch-downs of contacts that exist at the start, and the first sample.
    pub fn begin(&mut self, motion: &Motion) -> Result<(), SinkError> {
        for candidate in motion.candidates.iter().filter(|candidate| candidate.gap < 0.0 && candidate.has_gap()) {
            let Some(channel) = motion.plan.contact_channel(candidate.index) else { continue };
            let contact = self.state.last.contact(channel);
            // The overlap of surfaces that just touch and recede is rounding error.
            if contact.gap_m >= -OVERLAP_ROUNDING && contact.gap_rate_m_s > ZERO_RATE {
                continue;
            }
            self.process_change(channel, ChangeKind::Closes, 0.0, contact.approach_at_start(), 0.0)?;
            self.state.trackers[channel].summary.update(self.state.last.contact(channel).force_and_penetration());
        }
        self.sink.sample(&self.state.last)
    }

    /// Processes one step: emits its events and samples and updates the summary.
    pub fn step(&mut self, motion: &Motion) -> Result<(), SinkError> {
        let (end_s, dt) = (motion.clock.now(), motion.last_dt_s);
        self.state.work.steps += 1;
        self.state.work.contact_substeps += u64::from(motion.contact.substeps);
        self.state.work.newton_iterations += u64::from(motion.contact.iterations);
        self.state.work.rejected += u64::from(motion.contact.repeated);
        let gap_m = motion.linkage.max_joint_opening();
        self.state.loop_gap_m = self.state.loop_gap_m.max(gap_m);
        let mut node = std::mem::take(&mut self.state.node);
        let energy =
            stored_energy(motion).relative_to(&self.state.start_energy, motion.contact_work_j, motion.motor_work_j);
        let energy = Energy { cable_friction_j: 0.0 - motion.cable_work_j, ..energy };
        self.state.failure = self.state.consistency.check(&energy, gap_m, dt);
        read_node(motion, (self.state.last.counts(), energy), &self.state.trackers, &mut node);
        self.state.joint_forces.set(motion, &mut node);
        // Such a step is not recorded: the run ends with the last valid sample.
        if let Some(reason) = describe_not_finite(self.scene, &node) {
            (self.state.failure, self.state.node) = (Some(reason), node);
            return Ok(());
        }
        self.record_touch_downs_between_steps(motion, end_s - dt)?;
        self.find_extrema(motion);
        let start_s = self.state.last.time_s;
        for index in 0..motion.contact.changes.len() {
            let Change { after_s, contact, kind, closing, impulse } = motion.contact.changes[index];
            let Some(channel) = motion.plan.contact_channel(motion.space.active_contacts[contact].candidate.index)
            else {
                continue;
            };
            let time_s = end_s - dt + after_s;
            self.emit_extrema_before(motion, &node, after_s)?;
            if kind == ChangeKind::Closes && !self.state.trackers[channel].engine.is_touching {
                let change_from_start = (self.state.last.time_s == start_s).then_some(index);
                self.emit_touch_down(motion, &node, (channel, change_from_start), time_s, closing)?;
            }
            self.process_change(channel, kind, time_s, closing, impulse)?;
        }
        self.emit_extrema_before(motion, &node, dt)?;
        for channel in 0..self.state.trackers.len() {
            self.finish_step(motion, channel, end_s)?;
        }
        // An inconsistent step ends the run as a failure instead.
        let is_consistent = self.state.failure.is_none();
        let leaves = |exit: &Exit| {
            has_hand_touched(&self.state.trackers, &self.state.last, exit) && exit.leaves(&self.state.last, &node)
        };
        if is_consistent && self.state.exit.as_ref().is_some_and(leaves) {
            self.state.ejected_s = Some(end_s);
        }
        self.state.node = node;
        self.emit_step(motion)
    }

    /// Records touch-downs of surfaces that the last step left separated in its frozen geometry, or that the run starts
    /// with, and that overlap at the start of this step. Receding surfaces have just separated, and overlap by rounding
    /// only.
    fn record_touch_downs_between_steps(&mut self, motion: &Motion, start_s: f64) -> Result<(), SinkError> {
        let has_closed = |contact: &&ActiveContact| contact.candidate.gap <= 0.0 && motion.space.is_closing(contact);
        for contact in motion.space.active_contacts.iter().filter(has_closed) {
            let closing = (-motion.space.rate[contact.normal]).max(0.0);
            let Some(channel) = motion.plan.contact_channel(contact.candidate.index) else { continue };
            self.process_change(channel, ChangeKind::Closes, start_s, closing, 0.0)?;
        }
        Ok(())
    }

    /// Finds the instants of the step at which a penetration or a contact force exceeds all earlier values.
    fn find_extrema(&mut self, motion: &Motion) {
        self.state.step_extrema.clear();
        for (channel, tracker) in self.state.trackers.iter_mut().enumerate() {
            let Some(index) = motion.plan.element_index(channel) else { continue };
            let within = motion.contact_extrema(index);
            let depth = motion.candidate(index).map_or(0.0, |candidate| -candidate.gap);
            let end = [motion.forces(index).0, depth];
            self.state.step_extrema.add_contact(channel, &mut tracker.summary, within, motion.last_dt_s, end);
        }
        self.state.step_extrema.sort();
    }

    /// Emits samples at the extrema of a step of length `dt` that lie before `after_s`.
    fn emit_extrema_before(&mut self, motion: &Motion, now: &Sample, after_s: f64) -> Result<(), SinkError> {
        let dt = motion.last_dt_s;
        while let Some((_, (channel, extremum))) = self.state.step_extrema.next_before(after_s) {
            let time_s = now.time_s - dt + extremum.after_s;
            let sample = &mut self.state.within;
            sample.interpolate_from(&self.state.last, now, time_s);
            let mut set_extremum = |channel: usize, extremum: &ContactExtremum| {
                let mut contact = sample.contact(channel);
                contact.set_extremum(extremum, self.state.trackers[channel].engine.impulse);
                sample.set_contact(channel, &contact);
            };
            set_extremum(channel, &extremum);
            while let Some((other, simultaneous)) = self.state.step_extrema.next_at(extremum.after_s) {
                set_extremum(other, &simultaneous);
            }
            if time_s > self.state.emitted_s && time_s < now.time_s {
                self.emit_grid(motion, now, time_s)?;
                self.state.joint_forces.set(motion, &mut self.state.within);
                update_summaries(&mut self.state.trackers, &self.state.within);
                self.sink.extreme(&self.state.within)?;
            }
        }
        Ok(())
    }

    /// Emits a sample at a touch-down within the step: up to here the contact has had no impulse.
    fn emit_touch_down(
        &mut self,
        motion: &Motion,
        now: &Sample,
        (channel, change_from_start): (usize, Option<usize>),
        time_s: f64,
        closing: f64,
    ) -> Result<(), SinkError> {
        if time_s <= self.state.last.time_s {
            return Ok(());
        }
        let mut sample = std::mem::take(&mut self.state.within);
        sample.interpolate_from(&self.state.last, now, time_s);
        reading::extrapolate(&mut sample, &self.state.last, motion, change_from_start);
        for index in 0..sample.counts().contacts {
            let (mut contact, before) = (sample.contact(index), self.state.last.contact(index));
            contact.set_before_touch_down_elsewhere(&before);
            if index == channel {
                contact.set_touch_down(&before, closing);
            }
            sample.set_contact(index, &contact);
        }
        self.state.joint_forces.set(motion, &mut sample);
        self.emit_grid(motion, &sample, time_s)?;
        self.state.emitted_s = time_s;
        update_summaries(&mut self.state.trackers, &sample);
        self.sink.sample(&sample)?;
        // The rest of the step has the rates after the impact.
        sample.copy_rates(now);
        self.state.within = std::mem::replace(&mut self.state.last, sample);
        Ok(())
    }

    /// Adds the impulse of one contact over the step, and processes changes between two steps.
    fn finish_step(&mut self, motion: &Motion, channel: usize, end_s: f64) -> Result<(), SinkError> {
        let Some(index) = motion.plan.element_index(channel) else { return Ok(()) };
        let force = motion.forces(index).0;
        if force > 0.0 && !self.state.trackers[channel].engine.is_touching {
            // rapier's own contact reports no touch-down, and a step that began with an overlap has passed it.
            let closing_rate = motion.rapier_contact(index).map_or(0.0, |contact| contact.closing_rate);
            self.process_change(channel, ChangeKind::Closes, end_s - motion.last_dt_s, closing_rate, 0.0)?;
        }
        let tracker = &mut self.state.trackers[channel];
        if let Some(candidate) = motion.candidate(index) {
            tracker.engine.is_touching &= !candidate.is_separated() || force > 0.0;
        }
        tracker.add_step(motion.normal_impulse(index));
        if let Some(kind) = tracker.change_between_steps(force) {
            self.process_change(channel, kind, end_s, 0.0, 0.0)?;
        }
        // The contact normal turns between two steps, so a bristle may have crossed the edge of its friction cone.
        let slip_event = self.state.trackers[channel].update_slip(motion.is_slipping(index));
        slip_event.map_or(Ok(()), |event| self.emit_event(channel, end_s, event))
    }

    /// Processes a change of one contact; `impulse` is the impulse of the current step so far.
    fn process_change(
        &mut self,
        channel: usize,
        kind: ChangeKind,
        time_s: f64,
        closing: f64,
        impulse: f64,
    ) -> Result<(), SinkError> {
        let event = self.state.trackers[channel].process_change(kind, time_s, closing, impulse);
        event.map_or(Ok(()), |event| self.emit_event(channel, time_s, event))
    }

    /// Counts and emits an event.
    fn emit_event(&mut self, contact: usize, time_s: f64, event: ReportedEvent) -> Result<(), SinkError> {
        let is_friction_event = event.kind.is_friction_event();
        let event = event.at(time_s, contact);
        if is_friction_event {
            return self.sink.event(&event);
        }
        self.state.work.events += 1;
        self.sink.event(&event)
    }

    /// Emits the samples of one step, or of the rest of it: the grid points inside it, and its end.
    fn emit_step(&mut self, motion: &Motion) -> Result<(), SinkError> {
        let now = std::mem::take(&mut self.state.node);
        let time_s = now.time_s;
        self.emit_grid(motion, &now, time_s)?;
        self.state.node = std::mem::replace(&mut self.state.last, now);
        if self.state.times.pass_end(time_s) {
            self.sink.point(&self.state.last)?;
        }
        self.state.emitted_s = time_s;
        update_summaries(&mut self.state.trackers, &self.state.last);
        self.sink.sample(&self.state.last)
    }

    /// Emits the samples on the grid and the points before `until_s`, between the last sample and `end`.
    fn emit_grid(&mut self, motion: &Motion, end: &Sample, until_s: f64) -> Result<(), SinkError> {
        while let Some(RecordingTime { time_s: t, is_sample, is_point }) = self.state.times.next_before(until_s) {
            // A fine grid can have millions of points within one step.
            if !self.sink.should_continue() {
                break;
            }
            if t > self.state.last.time_s {
                self.state.point.interpolate_from(&self.state.last, end, t);
                if is_point {
                    self.sink.point(&self.state.point)?;
                }
                if !is_sample {
                    continue;
                }
                self.state.emitted_s = t;
                self.state.joint_forces.set(motion, &mut self.state.point);
                update_summaries(&mut self.state.trackers, &self.state.point);
                self.sink.sample(&self.state.point)?;
            }
        }
        Ok(())
    }

    /// Upper bound of the next step, s, so that it ends where the object leaves the hand.
    pub(crate) fn time_to_exit_s(&self) -> f64 {
        let last = &self.state.last;
        let exit = self.state.exit.as_ref().filter(|exit| has_hand_touched(&self.state.trackers, last, exit));
        exit.map_or(f64::INFINITY, |exit| exit.time_to_exit_s(last))
    }

    /// Explains why a cable cannot go on, or which points have met, if either is so.
    pub(crate) fn describe_obstacle(&self, motion: &Motion) -> Option<String> {
        let mechanism = self.scene.mechanism.as_ref()?;
        if let Some(met) = motion.met_points() {
            let is_met =
                |actuator: &PlannedActuator| matches!(actuator, PlannedActuator::Powertrain(index) if *index == met);
            return motion.plan.actuators.iter().position(is_met).map(|index| mechanism.describe_met_points(index));
        }
        let (tendon, fault) = motion.cable_fault?;
        Some(mechanism.describe_cable(&mechanism.tendons[tendon], fault))
    }

    /// Whether the run may continue; called after every step and after every contact sub-step.
    pub fn should_continue(&self) -> bool {
        self.state.ejected_s.is_none() && self.sink.should_continue()
    }

    /// Completes the last sample of a mechanism, which reports show: adds the forces in joints if the sink did not
    /// require them.
    pub fn complete_last(&mut self, motion: &mut Motion) {
        if self.scene.mechanism.is_some() && !self.sink.required_data().joint_forces {
            JointForces::new(true, motion).set(motion, &mut self.state.last);
        }
    }

    /// Returns the summary.
    pub fn finish(&self) -> Outcome {
        let contacts = self.state.trackers.iter().map(|tracker| tracker.summary).collect();
        Outcome {
            last: self.state.last.clone(),
            contacts,
            work: self.state.work,
            loop_gap_m: self.state.loop_gap_m,
            ejected_s: self.state.ejected_s,
        }
    }
}

/// Reads the node into a sample, given its energies and the contact states up to the start of the step.
fn read_node(motion: &Motion, (counts, energy): (Counts, Energy), trackers: &[ContactTracker], sample: &mut Sample) {
    sample.prepare(motion.clock.now(), counts);
    reading::read_state(motion, sample);
    let frame = PalmFrame::at(&motion.plan, motion.clock.now());
    for (channel, tracker) in trackers.iter().enumerate() {
        let index = motion.plan.element_index(channel);
        // There is no step impulse before the first step.
        let stepped_index = index.filter(|_| motion.last_dt_s > 0.0);
        let impulse = tracker.engine.impulse + stepped_index.map_or(0.0, |index| motion.normal_impulse(index));
        sample.set_contact(channel, &sample_contact(motion, &frame, index, impulse));
    }
    sample.set_energy(&energy);
}
