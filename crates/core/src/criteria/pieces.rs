//! A run as pieces of time within which no contact changes, whatever the samples are spaced like.

use super::pressing::Pressing;
use crate::trace::{Event, EventKind, Sample};

/// A piece of time. Contacts are those of a sample, the first `K` of them.
#[derive(Clone, Copy, Debug)]
pub struct Piece<'a, const K: usize> {
    pub from_s: f64,
    pub to_s: f64,
    /// The sample at or after its end.
    pub next: &'a Sample,
    /// Whether a contact has been closed so far.
    pub touched: [bool; K],
    /// Whether its normal force is positive.
    pub pressing: [bool; K],
}

/// Who judges the pieces of a run one after the other.
pub trait Judge<const K: usize> {
    /// What the pieces between two samples have in common: how coordinates go from one to the other.
    type Path;

    /// The first sample of the run.
    fn begin(&mut self, first: &Sample);

    /// The way from one sample to the next. Times within it at which something changes that is no contact go to `cuts_s`, in any order.
    fn path(&self, last: &Sample, next: &Sample, cuts_s: &mut Vec<f64>) -> Self::Path;

    fn judge(&mut self, path: &Self::Path, piece: &Piece<K>);
}

/// Cuts a run into pieces and keeps nothing of it but the last sample and the contact changes since. Contacts change at the times of
/// their events. Within a contact the normal force counts as positive between two samples if it is positive at both; the zero at the
/// very touch-down does not count against it.
#[derive(Clone, Debug)]
pub struct Pieces<const K: usize> {
    last: Option<Sample>,
    contacts: [Pressing; K],
    /// Contact changes since the last sample.
    events: Vec<Event>,
    /// Ends of the pieces of the step at hand, reused.
    cuts_s: Vec<f64>,
    /// Normal force, N, that a contact must exceed to press, where forces between samples are interpolated; otherwise `None`.
    threshold_n: Option<f64>,
}

impl<const K: usize> Default for Pieces<K> {
    fn default() -> Self {
        Self::new(None)
    }
}

/// How far between its last and its next value a force passes the threshold; `None` if it does not. A force that rises from zero has just
/// begun: it counts from there.
fn passes(threshold_n: f64, from_n: f64, to_n: f64) -> Option<f64> {
    (from_n > 0.0 && (from_n > threshold_n) != (to_n > threshold_n)).then(|| (threshold_n - from_n) / (to_n - from_n))
}

impl<const K: usize> Pieces<K> {
    /// Pieces in which a contact presses while its normal force exceeds this, N. The force is linear between two samples without an event
    /// of the contact.
    pub fn above(threshold_n: f64) -> Self {
        Self::new(Some(threshold_n))
    }

    fn new(threshold_n: Option<f64>) -> Self {
        Pieces { last: None, contacts: [Pressing::default(); K], events: Vec::new(), cuts_s: Vec::new(), threshold_n }
    }

    /// Whether a contact presses at a time between two samples.
    fn presses(&self, contact: usize, last: &Sample, next: &Sample, time_s: f64, lifts_off: bool) -> bool {
        let threshold_n = self.threshold_n.filter(|_| self.events.iter().all(|event| event.contact != contact));
        let Some(threshold_n) = threshold_n else {
            return self.contacts[contact].presses_until(&next.contacts[contact], lifts_off);
        };
        let [from_n, to_n] = [last, next].map(|sample| sample.contacts[contact].normal_n);
        let part = if from_n > 0.0 { (time_s - last.time_s) / (next.time_s - last.time_s) } else { 1.0 };
        from_n + part * (to_n - from_n) > threshold_n
    }

    pub fn last(&self) -> Option<&Sample> {
        self.last.as_ref()
    }

    pub fn event(&mut self, event: &Event) {
        if event.contact < K && !event.kind.is_of_friction() {
            self.events.push(*event);
        }
    }

    pub fn sample(&mut self, sample: &Sample, judge: &mut impl Judge<K>) {
        let Some(mut last) = self.last.take() else {
            for (state, contact) in self.contacts.iter_mut().zip(&sample.contacts) {
                if contact.gap_m < 0.0 {
                    state.touch_down();
                }
            }
            self.take(sample);
            judge.begin(sample);
            self.last = Some(sample.clone());
            return;
        };
        if sample.time_s > last.time_s {
            self.step(&last, sample, judge);
        } else {
            // A second sample of the same instant (before and after an event): the later one holds.
            for event in self.events.drain(..) {
                self.contacts[event.contact].change(event.kind);
            }
            self.take(sample);
        }
        last.clone_from(sample);
        self.last = Some(last);
    }

    fn take(&mut self, sample: &Sample) {
        self.contacts.iter_mut().zip(&sample.contacts).for_each(|(state, contact)| state.take(contact));
    }

    /// The step from the last sample to `next`.
    fn step(&mut self, last: &Sample, next: &Sample, judge: &mut impl Judge<K>) {
        let mut cuts_s = std::mem::take(&mut self.cuts_s);
        cuts_s.clear();
        let path = judge.path(last, next, &mut cuts_s);
        cuts_s.extend(self.events.iter().map(|event| event.time_s.clamp(last.time_s, next.time_s)));
        if let Some(threshold_n) = self.threshold_n {
            let forces = last.contacts.iter().zip(&next.contacts).take(K);
            let parts = forces.filter_map(|(from, to)| passes(threshold_n, from.normal_n, to.normal_n));
            cuts_s.extend(parts.map(|part| last.time_s + part * (next.time_s - last.time_s)));
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
                let pressing =
                    std::array::from_fn(|contact| self.presses(contact, last, next, middle_s, lifts_off(contact)));
                let touched = self.contacts.map(|contact| contact.touched);
                judge.judge(&path, &Piece { from_s, to_s, next, touched, pressing });
                from_s = to_s;
            }
        }
        for event in pending {
            self.contacts[event.contact].change(event.kind);
        }
        self.events.clear();
        self.cuts_s = cuts_s;
        self.take(next);
    }
}
