//! Splits a run into time segments within which no contact changes, independent of the spacing of samples.

use crate::trace::{ContactSample, Event, EventKind, Sample};

/// A time segment, with the first `K` contacts of a sample.
#[derive(Clone, Copy, Debug)]
pub struct Segment<'a, const K: usize> {
    pub from_s: f64,
    pub to_s: f64,
    /// The sample at or after the end.
    pub next: &'a Sample,
    /// Whether each contact has been closed before the end of the segment.
    pub has_touched: [bool; K],
    /// Whether each contact is active: its normal force is positive or above the threshold.
    pub is_active: [bool; K],
}

/// Observer of the segments of a run, in order of time.
pub(crate) trait SegmentObserver<const K: usize> {
    /// Interpolant of the coordinates between two samples.
    type Interpolant;

    /// Receives the first sample of the run.
    fn begin(&mut self, first: &Sample);

    /// Interpolates between two samples. Appends times of changes other than contact changes to `cuts_s`, in any order.
    fn interpolate(&self, last: &Sample, next: &Sample, cuts_s: &mut Vec<f64>) -> Self::Interpolant;

    /// Receives one segment.
    fn observe(&mut self, interpolant: &Self::Interpolant, segment: &Segment<K>);
}

/// Splits a run into segments; stores only the last sample and the contact changes since. Contacts change at the times
/// of their events. Between two samples of a closed contact, the normal force counts as positive if it is positive at
/// both; the zero at the touch-down is ignored.
#[derive(Clone, Debug)]
pub(crate) struct SegmentSplitter<const K: usize> {
    last: Option<Sample>,
    contacts: [ContactStatus; K],
    /// Contact changes since the last sample.
    events: Vec<Event>,
    /// Ends of the segments of the current step; reused.
    cuts_s: Vec<f64>,
    /// Normal force above which a contact is active, N, with linear interpolation of the force between samples. `None`
    /// if a contact is active at any positive force.
    threshold_n: Option<f64>,
}

/// Returns the fraction of the step at which a force crosses the threshold; `None` if it does not. A force that rises
/// from zero counts from the start of the step.
fn threshold_crossing(threshold_n: f64, from_n: f64, to_n: f64) -> Option<f64> {
    (from_n > 0.0 && (from_n > threshold_n) != (to_n > threshold_n)).then(|| (threshold_n - from_n) / (to_n - from_n))
}

impl<const K: usize> SegmentSplitter<K> {
    /// Creates a splitter whose contacts are active while their normal force exceeds a threshold, N, or is positive if
    /// there is none.
    pub fn new(threshold_n: Option<f64>) -> Self {
        SegmentSplitter {
            last: None,
            contacts: [ContactStatus::default(); K],
            events: Vec::new(),
            cuts_s: Vec::new(),
            threshold_n,
        }
    }

    /// Returns whether a contact is active at a time between two samples.
    fn is_active(&self, contact: usize, last: &Sample, next: &Sample, time_s: f64, lifts_off: bool) -> bool {
        let threshold_n = self.threshold_n.filter(|_| self.events.iter().all(|event| event.contact != contact));
        let Some(threshold_n) = threshold_n else {
            return self.contacts[contact].is_active_until(&next.contact(contact), lifts_off);
        };
        let [from_n, to_n] = [last, next].map(|sample| sample.contact(contact).normal_n);
        let fraction = if from_n > 0.0 { (time_s - last.time_s) / (next.time_s - last.time_s) } else { 1.0 };
        from_n + fraction * (to_n - from_n) > threshold_n
    }

    /// Returns the last sample.
    pub fn last(&self) -> Option<&Sample> {
        self.last.as_ref()
    }

    /// Adds an event; friction events are ignored.
    pub fn event(&mut self, event: &Event) {
        if event.contact < K && !event.kind.is_friction_event() {
            self.events.push(*event);
        }
    }

    /// Adds a sample and passes the segments up to it to the observer.
    pub fn sample(&mut self, sample: &Sample, observer: &mut impl SegmentObserver<K>) {
        let Some(mut last) = self.last.take() else {
            for (state, contact) in self.contacts.iter_mut().zip(sample.contacts()) {
                if contact.gap_m < 0.0 {
                    state.touch_down();
                }
            }
            self.update(sample);
            observer.begin(sample);
            self.last = Some(sample.clone());
            return;
        };
        if sample.time_s > last.time_s {
            self.step(&last, sample, observer);
        } else {
            // Two samples of the same instant, before and after an event: the later one applies.
            for event in self.events.drain(..) {
                self.contacts[event.contact].change(event.kind);
            }
            self.update(sample);
        }
        last.clone_from(sample);
        self.last = Some(last);
    }

    fn update(&mut self, sample: &Sample) {
        self.contacts.iter_mut().zip(sample.contacts()).for_each(|(state, contact)| state.update(&contact));
    }

    /// Splits the step from the last sample to `next`.
    fn step(&mut self, last: &Sample, next: &Sample, observer: &mut impl SegmentObserver<K>) {
        let mut cuts_s = std::mem::take(&mut self.cuts_s);
        cuts_s.clear();
        let interpolant = observer.interpolate(last, next, &mut cuts_s);
        cuts_s.extend(self.events.iter().map(|event| event.time_s.clamp(last.time_s, next.time_s)));
        if let Some(threshold_n) = self.threshold_n {
            let forces = last.contacts().zip(next.contacts()).take(K);
            let fractions = forces.filter_map(|(from, to)| threshold_crossing(threshold_n, from.normal_n, to.normal_n));
            cuts_s.extend(fractions.map(|fraction| last.time_s + fraction * (next.time_s - last.time_s)));
        }
        cuts_s.push(next.time_s);
        cuts_s.sort_by(f64::total_cmp);

        let mut pending = self.events.iter().peekable();
        let mut from_s = last.time_s;
        for &to_s in &cuts_s {
            while let Some(event) = pending.next_if(|event| event.time_s <= from_s) {
                self.contacts[event.contact].change(event.kind);
            }
            if to_s > from_s {
                let lifts_off =
                    |contact| pending.clone().any(|event| event.contact == contact && event.kind == EventKind::LiftOff);
                let middle_s = 0.5 * (from_s + to_s);
                let is_active =
                    std::array::from_fn(|contact| self.is_active(contact, last, next, middle_s, lifts_off(contact)));
                let has_touched = self.contacts.map(|contact| contact.has_touched);
                observer.observe(&interpolant, &Segment { from_s, to_s, next, has_touched, is_active });
                from_s = to_s;
            }
        }
        for event in pending {
            self.contacts[event.contact].change(event.kind);
        }
        self.events.clear();
        self.cuts_s = cuts_s;
        self.update(next);
    }
}

/// Whether a contact is closed and active. Events give the times of changes; samples give the force between them.
#[derive(Clone, Copy, Debug, Default)]
struct ContactStatus {
    is_closed: bool,
    /// Whether the contact has been closed before.
    has_touched: bool,
    /// Whether a sample since the touch-down had a positive force.
    was_loaded: bool,
    /// Whether the normal force was zero at the last sample although the contact had been loaded: the normal law clamps
    /// it to 0.
    is_slack: bool,
}

impl ContactStatus {
    fn touch_down(&mut self) {
        *self = ContactStatus {
            is_closed: true,
            has_touched: true,
            // A second touch-down does not change a closed contact.
            was_loaded: self.is_closed && self.was_loaded,
            is_slack: self.is_closed && self.is_slack,
        };
    }

    fn change(&mut self, kind: EventKind) {
        match kind {
            EventKind::TouchDown | EventKind::Reload => self.touch_down(),
            EventKind::LiftOff => *self = ContactStatus { has_touched: true, ..ContactStatus::default() },
            EventKind::Slips | EventKind::Sticks => {}
        }
    }

    /// Updates the status from the force of a sample.
    fn update(&mut self, contact: &ContactSample) {
        if contact.normal_n > 0.0 {
            *self = ContactStatus { is_closed: true, has_touched: true, was_loaded: true, is_slack: false };
        } else {
            self.is_slack = self.is_closed && self.was_loaded;
        }
    }

    /// Returns whether the normal force is positive up to the next sample: the contact is closed, was loaded at the
    /// last sample or has just touched down, and is loaded at the next sample or lifts off before it.
    fn is_active_until(&self, next: &ContactSample, lifts_off: bool) -> bool {
        self.is_closed && !self.is_slack && (next.normal_n > 0.0 || lifts_off)
    }
}
