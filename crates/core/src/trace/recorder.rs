//! Converts the steps of the analytic model into samples, events and summary figures.

use super::contact_tracker::{ContactTracker, ReportedEvent, has_hand_touched, update_summaries};
use super::extrema::{
    BISECTIONS, Reason, StepExtrema, bisect, find_crossing, is_monotonic, may_be_deeper, may_exceed, parabola_peak,
};
use super::grid::{RecordingOptions, RecordingTime, RecordingTimes};
use super::reading::Kernel;
use super::{ContactSummary, Energy, EventKind, Exit, Outcome, RequiredData, Sample, Sink, SinkError, Work};
use crate::analytic::ContactState;
use crate::analytic::mechanism::EXCHANGE_SINE;
use crate::integrator::{Layout, Observer, State, Step, StepTools};

/// Memory for states inside a step, and the normal impulses at the last sample.
#[derive(Clone)]
struct StepBuffers<L: Layout> {
    impulses: L::Quadratures,
    impulses_before: L::Quadratures,
    state: State<L>,
}

impl<L: Layout> StepBuffers<L> {
    fn new(state: &State<L>) -> Self {
        Self { impulses: state.z.clone(), impulses_before: state.z.clone(), state: state.clone() }
    }
}

/// Interior of one step: its mode, and states inside it.
struct Interior<'a, R: Kernel> {
    kernel: &'a R,
    step: &'a Step<'a, R::Layout>,
    mode: &'a R::Mode,
    tools: &'a mut dyn StepTools<R::Layout>,
    buffers: StepBuffers<R::Layout>,
    /// Number of contacts of samples.
    contacts: usize,
}

impl<R: Kernel> Interior<'_, R> {
    fn has_force(&self) -> bool {
        (0..self.contacts).any(|contact| self.mode[self.kernel.contact_index(contact)].has_force())
    }

    /// Returns the state at time `t` after the start of the step.
    fn state_at(&mut self, t: f64) -> &State<R::Layout> {
        let theta = (t - self.step.t0) / self.step.h;
        // Damper forces cannot be evaluated on the dense output.
        match self.has_force() {
            true => self.resolve(theta),
            false => self.tools.interpolate(theta),
        }
    }

    fn time_s(&self, theta: f64) -> f64 {
        self.step.t0 + theta * self.step.h
    }

    /// Returns a state within the step, computed by a separate step that ends there. Its integrals differ slightly from
    /// those of the step. Normal impulses must not decrease, so they are clamped between the previous sample and the
    /// end of the step.
    fn resolve(&mut self, theta: f64) -> &State<R::Layout> {
        self.buffers.state.copy_from(self.tools.resolve(theta));
        self.with_impulses()
    }

    /// Like [`Interior::resolve`], but from the dense output.
    fn refine(&mut self, theta: f64) -> &State<R::Layout> {
        self.buffers.state.copy_from(self.tools.refine(theta));
        self.with_impulses()
    }

    fn with_impulses(&mut self) -> &State<R::Layout> {
        let StepBuffers { impulses, state, .. } = &mut self.buffers;
        for contact in 0..self.contacts {
            let index = self.kernel.contact_index(contact);
            let before = &mut impulses[index];
            *before = state.z[index].min(self.step.end.z[index]).max(*before);
            state.z[index] = *before;
        }
        state
    }
}

/// Another observer of the steps that are recorded.
pub(crate) trait StepObserver<R: Kernel>: Observer<R::Layout, R::Mode> {
    /// Called where a kernel in other coordinates takes over, with the state and the mode at the end of the last step.
    fn exchange(&mut self, kernel: &R, state: &State<R::Layout>, mode: &R::Mode);
}

/// Observer that records a run of the analytic model.
pub(super) struct Recorder<'a, R: Kernel> {
    pub kernel: &'a R,
    pub sink: &'a mut dyn Sink,
    pub state: &'a mut RecorderState<R>,
    /// Observer that receives each step and each event before the sink.
    pub observer: Option<&'a mut dyn StepObserver<R>>,
    pub error: Option<SinkError>,
}

/// State of a recorder between two steps.
#[derive(Clone)]
pub(super) struct RecorderState<R: Kernel> {
    required_data: RequiredData,
    /// Whether samples inside steps are refined dense output.
    is_refined: bool,
    times: RecordingTimes,
    end_s: f64,
    /// Condition that ends the run.
    exit: Option<Exit>,
    /// Time at which the object left the hand.
    ejected_s: Option<f64>,
    mode: R::Mode,
    start_energy: Energy,
    trackers: Vec<ContactTracker>,
    /// Sample at the end of the last step.
    last: Sample,
    /// State from which `last` was read.
    last_state: State<R::Layout>,
    /// Mode from which `last` was read.
    last_mode: R::Mode,
    /// Buffer for the sample at the end of the current step.
    end: Sample,
    /// Buffer for a sample or a point within the step.
    within: Sample,
    /// Time up to which samples have been emitted.
    emitted_s: f64,
    /// Normal force at whose crossings samples are emitted, N.
    threshold_n: Option<f64>,
    peaks: StepExtrema<Reason>,
    history: R::History,
    /// Memory for the next step.
    buffers: Option<StepBuffers<R::Layout>>,
    /// Conditioning of the coordinates below which others are searched.
    exchange_below: f64,
    /// Whether the advance is suspended, so that other coordinates can take over.
    is_suspended: bool,
}

impl<R: Kernel> RecorderState<R> {
    pub fn new(
        kernel: &R,
        (start, mode): (&State<R::Layout>, R::Mode),
        exit: Option<Exit>,
        RecordingOptions { counts, span, required_data, threshold_n, .. }: RecordingOptions,
    ) -> Self {
        let [mut last, end, within] = [0; 3].map(|_| Sample::new(0.0, counts));
        let mut history = R::History::default();
        kernel.read((start, &mode), &Energy::default(), RequiredData::ALL, &mut history, &mut last);
        let start_energy = last.energy();
        kernel.read((start, &mode), &start_energy, RequiredData::ALL, &mut history, &mut last);
        Self {
            required_data,
            is_refined: span.is_refined,
            times: RecordingTimes::new(span, required_data.point_interval_s),
            end_s: span.end_s,
            exit,
            ejected_s: None,
            mode: mode.clone(),
            start_energy,
            trackers: vec![ContactTracker::default(); counts.contacts],
            last,
            last_state: start.clone(),
            last_mode: mode,
            end,
            within,
            emitted_s: 0.0,
            threshold_n,
            peaks: StepExtrema::default(),
            history,
            buffers: None,
            exchange_below: EXCHANGE_SINE,
            is_suspended: false,
        }
    }

    /// Returns whether the advance is suspended, and ends the suspension.
    pub fn take_suspended(&mut self) -> bool {
        std::mem::take(&mut self.is_suspended)
    }

    /// Continues in other coordinates; `state` and `mode` are those at the end of the last step in these coordinates.
    pub fn exchange(&mut self, state: &State<R::Layout>, mode: &R::Mode) {
        self.replace(state, mode);
        self.exchange_below = EXCHANGE_SINE;
    }

    /// Continues from another state and mode at the end of the last step.
    pub fn replace(&mut self, state: &State<R::Layout>, mode: &R::Mode) {
        (self.last_state, self.last_mode, self.mode) = (state.clone(), mode.clone(), mode.clone());
    }

    /// Continues in the same coordinates, because no others are much better. Others are searched again once the
    /// conditioning has fallen to half of this value.
    pub fn keep(&mut self, conditioning: f64) {
        self.exchange_below = 0.5 * conditioning;
    }

    /// Reads the complete data of a state inside a step at time `t`.
    pub fn read_within(
        &self,
        kernel: &R,
        t: f64,
        (step, mode, tools): (&Step<R::Layout>, &R::Mode, &mut dyn StepTools<R::Layout>),
        sample: &mut Sample,
    ) {
        let (buffers, contacts) = (StepBuffers::new(step.start), self.trackers.len());
        let mut interior = Interior { kernel, step, mode, tools, buffers, contacts };
        self.read_at(kernel, t, (interior.state_at(t), mode), sample);
    }

    /// Reads the complete data of a state at time `t`; later readings do not depend on this one.
    pub fn read_at(&self, kernel: &R, t: f64, state: (&State<R::Layout>, &R::Mode), sample: &mut Sample) {
        sample.prepare(t, self.last.counts());
        kernel.read(state, &self.start_energy, RequiredData::ALL, &mut self.history.clone(), sample);
    }
}

impl<R: Kernel> Recorder<'_, R> {
    /// Emits the touch-downs of contacts that exist at the start, and the first sample.
    pub fn begin(&mut self) -> Result<(), SinkError> {
        for (index, tracker) in self.state.trackers.iter_mut().enumerate() {
            // An overlap is a contact with or without a force; a zero gap is a contact only if it closes.
            let state = self.state.mode[self.kernel.contact_index(index)];
            if state == ContactState::Free {
                continue;
            }
            let contact = self.state.last.contact(index);
            let event = tracker.touch_down(0.0, contact.approach_at_start(), 0.0);
            if state == ContactState::Released {
                tracker.summary.update(contact.force_and_penetration());
            }
            self.sink.event(&event.at(0.0, index))?;
        }
        // A start outside the workspace of a loop has no passive angles; the run then ends before its first step.
        if self.state.last.energy().kinetic_j.is_nan() { Ok(()) } else { self.sink.sample(&self.state.last) }
    }

    /// Returns the summary.
    pub fn finish(&mut self, end: &State<R::Layout>, work: Work) -> Outcome {
        if self.state.required_data != RequiredData::ALL {
            let RecorderState { last_state, last_mode, start_energy, history, last, .. } = &mut *self.state;
            self.kernel.read((last_state, last_mode), start_energy, RequiredData::ALL, history, last);
        }
        // The integrator ends one step after the exit.
        let end = if self.state.ejected_s.is_some() { &self.state.last_state } else { end };
        let summary = |(index, tracker): (usize, &ContactTracker)| ContactSummary {
            impulse_n_s: end.z[self.kernel.contact_index(index)],
            ..tracker.summary
        };
        let contacts = self.state.trackers.iter().enumerate().map(summary).collect();
        Outcome { last: self.state.last.clone(), contacts, work, loop_gap_m: 0.0, ejected_s: self.state.ejected_s }
    }

    /// Emits the samples of one step: grid points and extrema inside it, and its end.
    fn emit_step(&mut self, interior: &mut Interior<'_, R>) -> Result<(), SinkError> {
        let (end, step, mode) = (self.state.last.time_s, interior.step, interior.mode);
        // Damper forces cannot be evaluated on the dense output.
        let has_active_contact = interior.has_force();
        let until_s = end.min(self.state.end_s);
        self.state.times.begin_step(until_s);
        while let Some(RecordingTime { time_s: t, is_sample, is_point }) = self.state.times.next_before(until_s) {
            // A fine grid can have millions of points within one step.
            if !self.sink.should_continue() {
                break;
            }
            let theta = (t - step.t0) / step.h;
            if is_point {
                self.emit_point(interior, t, has_active_contact)?;
            }
            if !is_sample {
                continue;
            }
            self.emit_peaks(interior, theta)?;
            if theta > 0.0 {
                if has_active_contact {
                    if self.state.is_refined {
                        self.read_within(t, interior.refine(theta), mode);
                    }
                    if !self.state.is_refined || exceeds_summaries(&self.state.trackers, &self.state.within) {
                        self.read_within(t, interior.resolve(theta), mode);
                    }
                    update_summaries(&mut self.state.trackers, &self.state.within);
                } else {
                    self.read_within(t, interior.tools.interpolate(theta), mode);
                }
                self.state.emitted_s = t;
                self.sink.sample(&self.state.within)?;
            }
        }
        self.emit_peaks(interior, 1.0)?;
        if self.state.times.pass_end(end) {
            self.sink.point(&self.state.last)?;
        }
        // A step between two events may be too short to change the time.
        if end > self.state.emitted_s {
            self.state.emitted_s = end;
            self.sink.sample(&self.state.last)
        } else if self.state.peaks.at_end {
            self.sink.extreme(&self.state.last)
        } else {
            Ok(())
        }
    }

    /// Emits a point, without an effect on later samples.
    fn emit_point(
        &mut self,
        interior: &mut Interior<'_, R>,
        time_s: f64,
        has_active_contact: bool,
    ) -> Result<(), SinkError> {
        let (theta, mode) = ((time_s - interior.step.t0) / interior.step.h, interior.mode);
        let StepBuffers { impulses, impulses_before, .. } = &mut interior.buffers;
        impulses_before.as_mut().copy_from_slice(impulses.as_ref());
        let state = match has_active_contact {
            true if self.state.is_refined => interior.refine(theta),
            true => interior.resolve(theta),
            false => interior.tools.interpolate(theta),
        };
        let RecorderState { start_energy, required_data, history, within, .. } = &mut *self.state;
        within.time_s = time_s;
        self.kernel.read((state, mode), start_energy, *required_data, &mut history.clone(), within);
        let StepBuffers { impulses, impulses_before, .. } = &mut interior.buffers;
        impulses.as_mut().copy_from_slice(impulses_before.as_ref());
        self.sink.point(&self.state.within)
    }

    /// Emits samples at the extrema of the step before `theta`.
    fn emit_peaks(&mut self, interior: &mut Interior<'_, R>, theta: f64) -> Result<(), SinkError> {
        while let Some((theta_peak, reason)) = self.state.peaks.next_before(theta) {
            let mut is_crossing = reason == Reason::Crossing;
            while let Some(reason) = self.state.peaks.next_at(theta_peak) {
                is_crossing |= reason == Reason::Crossing;
            }
            let t = interior.time_s(theta_peak);
            if t > self.state.emitted_s && t < interior.step.t1 {
                let mode = interior.mode;
                self.read_within(t, interior.resolve(theta_peak), mode);
                update_summaries(&mut self.state.trackers, &self.state.within);
                match is_crossing {
                    true => self.sink.crossing(&self.state.within)?,
                    false => self.sink.extreme(&self.state.within)?,
                }
            }
        }
        Ok(())
    }

    fn read_within(&mut self, t: f64, state: &State<R::Layout>, mode: &R::Mode) {
        let RecorderState { start_energy, required_data, history, within, .. } = &mut *self.state;
        within.time_s = t;
        self.kernel.read((state, mode), start_energy, *required_data, history, within);
    }

    /// Emits slip and stick events of bristle friction: steps end at these events, and the next step has another mode.
    fn record_slip_events(&mut self, time_s: f64, mode: &R::Mode) -> Result<(), SinkError> {
        for (contact, tracker) in self.state.trackers.iter_mut().enumerate() {
            if let Some(event) = tracker.update_slip(self.kernel.is_slipping(self.kernel.contact_index(contact), mode))
            {
                self.sink.event(&event.at(time_s, contact))?;
            }
        }
        Ok(())
    }

    /// Shortens the current step to where the object leaves the hand, if the hand has touched the object; returns whether it
    /// does.
    fn end_at_exit(&mut self, interior: &mut Interior<'_, R>) -> bool {
        let leaves = |exit: &&Exit| {
            exit.leaves(&self.state.last, &self.state.end)
                && has_hand_touched(&self.state.trackers, &self.state.end, exit)
        };
        let Some(exit) = self.state.exit.as_ref().filter(leaves).cloned() else { return false };
        let (mut inside, mut outside) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (inside + outside);
            let (time_s, mode) = (interior.time_s(middle), interior.mode);
            self.read_within(time_s, interior.tools.resolve(middle), mode);
            if exit.is_outside(&self.state.within) { outside = middle } else { inside = middle }
        }
        if outside < 1.0 {
            self.state.last_mode.clone_from(interior.mode);
            self.state.last_state.copy_from(interior.resolve(outside));
            interior.buffers.impulses.as_mut().copy_from_slice(interior.step.start.z.as_ref());
            let RecorderState { last_state, start_energy, required_data, history, end, .. } = &mut *self.state;
            end.time_s = interior.time_s(outside);
            self.kernel.read((last_state, interior.mode), start_energy, *required_data, history, end);
        }
        self.state.end_s = self.state.end.time_s;
        self.state.ejected_s = Some(self.state.end_s);
        true
    }

    /// Searches the largest force and penetration within the step of length `step_s` from the last sample to its end.
    fn search_peaks(&mut self, step_s: f64, mode: &R::Mode, tools: &mut dyn StepTools<R::Layout>) {
        self.state.peaks.clear();
        for (contact, tracker) in self.state.trackers.iter_mut().enumerate() {
            let index = self.kernel.contact_index(contact);
            // A released contact can still get deeper without a force.
            let is_active = mode[index].has_force();
            if !is_active && mode[index] != ContactState::Released {
                continue;
            }
            let (start, end) = (self.state.last.contact(contact), self.state.end.contact(contact));
            let read = |state: &State<R::Layout>| self.kernel.contact(state, index, mode);
            let summary = &mut tracker.summary;
            summary.update_max_penetration(-start.gap_m);
            if summary.update_max_penetration(-end.gap_m) {
                self.state.peaks.push(1.0, Reason::Peak);
            }
            let rates = [start.gap_rate_m_s, end.gap_rate_m_s];
            if may_be_deeper(summary.max_penetration_m, [-start.gap_m, -end.gap_m], rates, step_s) {
                let deepest = bisect(&mut |theta| -read(tools.interpolate(theta)).gap_rate_m_s);
                if summary.update_max_penetration(-read(tools.resolve(deepest)).gap_m) {
                    self.state.peaks.push(deepest, Reason::Peak);
                }
            }
            // A damper makes the force jump at a touch-down, to its value just after the start of the step.
            let at_start = match is_active && start.normal_n == 0.0 {
                true => read(tools.resolve(STEP_START)).normal_n,
                false => start.normal_n,
            };
            let mean = (end.impulse_n_s - start.impulse_n_s) / step_s;
            if is_active && may_exceed(summary.peak_normal_n, [at_start, end.normal_n], mean) {
                let mut force = |theta: f64| read(tools.refine_motion(theta)).normal_n;
                let (theta, mut peak) = match is_monotonic([at_start, end.normal_n], mean) {
                    true if at_start < end.normal_n => (1.0, end.normal_n),
                    true => (0.0, at_start),
                    false => parabola_peak(at_start, end.normal_n, &mut force),
                };
                if theta > 0.0 && theta < 1.0 && peak > summary.peak_normal_n {
                    peak = read(tools.resolve(theta)).normal_n;
                }
                if summary.update_peak_force(peak) {
                    self.state.peaks.push(theta.max(STEP_START), Reason::Peak);
                }
            }
            // A force that rises from zero counts from its start.
            if let Some(threshold_n) = self.state.threshold_n.filter(|_| start.normal_n > 0.0) {
                let ends = [start.normal_n - threshold_n, end.normal_n - threshold_n];
                if (ends[0] > 0.0) != (ends[1] > 0.0) {
                    let mut excess = |theta: f64| read(tools.refine_motion(theta)).normal_n - threshold_n;
                    self.state.peaks.push(find_crossing(ends, &mut excess), Reason::Crossing);
                }
            }
        }
        self.state.peaks.sort();
    }
}

/// Whether a force of a sample exceeds the largest one of its contact so far.
fn exceeds_summaries(trackers: &[ContactTracker], sample: &Sample) -> bool {
    trackers.iter().zip(sample.contacts()).any(|(tracker, contact)| contact.normal_n > tracker.summary.peak_normal_n)
}

/// Position just after the start of a step.
const STEP_START: f64 = 1e-9;

impl<R: Kernel> Observer<R::Layout, R::Mode> for Recorder<'_, R> {
    fn step(&mut self, step: &Step<R::Layout>, mode: &R::Mode, tools: &mut dyn StepTools<R::Layout>) -> bool {
        if let Some(observer) = &mut self.observer
            && !observer.step(step, mode, tools)
        {
            return false;
        }
        self.state.mode.clone_from(mode);
        self.state.last_mode.clone_from(mode);
        self.state.last_state.copy_from(step.end);
        if let Err(error) = self.record_slip_events(step.t0, mode) {
            self.error = Some(error);
            return false;
        }
        let RecorderState { start_energy, required_data, history, end, .. } = &mut *self.state;
        end.time_s = step.t1;
        self.kernel.read((step.end, mode), start_energy, *required_data, history, end);
        let (kernel, contacts) = (self.kernel, self.state.trackers.len());
        let mut buffers = self.state.buffers.take().unwrap_or_else(|| StepBuffers::new(step.start));
        buffers.impulses.as_mut().copy_from_slice(step.start.z.as_ref());
        let mut interior = Interior { kernel, step, mode, tools, buffers, contacts };
        let exits = self.end_at_exit(&mut interior);
        if self.state.required_data.peaks && !exits {
            self.search_peaks(step.h, mode, interior.tools);
        } else {
            self.state.peaks.clear();
            update_summaries(&mut self.state.trackers, &self.state.end);
        }
        std::mem::swap(&mut self.state.last, &mut self.state.end);
        if let Err(error) = self.emit_step(&mut interior) {
            self.error = Some(error);
        }
        self.state.buffers = Some(interior.buffers);
        self.error.is_none() && self.state.ejected_s.is_none() && self.sink.should_continue()
    }

    fn event(&mut self, t: f64, state: &State<R::Layout>, index: usize, mode: &R::Mode) {
        if let Some(observer) = &mut self.observer {
            observer.event(t, state, index, mode);
        }
        let contact = self.kernel.sample_contact(index, self.state.trackers.len()).expect("a contact of a sample");
        let was_separated =
            self.state.last.contact(contact).gap_m > 0.0 || !matches!(self.state.mode[index], ContactState::Released);
        let kind = match mode[index] {
            ContactState::Active if was_separated => EventKind::TouchDown,
            ContactState::Active => EventKind::Reload,
            _ => EventKind::LiftOff,
        };
        let (tracker, impulse) = (&mut self.state.trackers[contact], state.z[index]);
        let event = match kind {
            EventKind::TouchDown => {
                let approach = -self.kernel.contact(state, index, mode).gap_rate_m_s;
                tracker.touch_down(t, approach, impulse)
            }
            EventKind::LiftOff => tracker.lift_off(impulse),
            EventKind::Reload | EventKind::Slips | EventKind::Sticks => ReportedEvent::of_kind(kind),
        };
        self.state.mode.clone_from(mode);
        if let Err(error) = self.sink.event(&event.at(t, contact)) {
            self.error.get_or_insert(error);
        }
    }

    #[inline(always)]
    fn suspends(&mut self, state: &State<R::Layout>, mode: &R::Mode, clearance: f64) -> bool {
        // Nearly always; the conditioning is at least the clearance.
        if clearance >= EXCHANGE_SINE {
            self.state.exchange_below = EXCHANGE_SINE;
            return false;
        }
        self.state.is_suspended = self.kernel.conditioning(state, mode) < self.state.exchange_below;
        self.state.is_suspended
    }
}
