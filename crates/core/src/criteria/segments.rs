//! Splits a run into time segments within which no contact changes, independent of the spacing of samples.

use crate::law::{NormalLaw, normal_force};
use crate::trace::{Event, EventKind, Sample};

/// A segment of time, with the activity of some contacts of a sample. Contacts that it does not contain are not active.
#[derive(Clone, Copy, Debug)]
pub struct Segment<'a> {
    pub from_s: f64,
    pub to_s: f64,
    /// The sample at or before the start.
    pub last: &'a Sample,
    /// The sample at or after the end.
    pub next: &'a Sample,
    /// For each contact, whether it has been closed before the end of the segment.
    pub has_touched: &'a [bool],
    /// For each contact, whether it is active: whether its normal force is positive, or above the threshold.
    pub is_active: &'a [bool],
}

/// Observer of the segments of a run, in order of time.
pub(crate) trait SegmentObserver {
    /// Interpolant of the coordinates between two samples.
    type Interpolant;

    /// Receives the first sample of the run.
    fn begin(&mut self, _first: &Sample) {}

    /// Interpolates between two samples. Appends times of changes other than contact changes to `cuts_s`, in any order.
    fn interpolate(&mut self, last: &Sample, next: &Sample, cuts_s: &mut Vec<f64>) -> Self::Interpolant;

    fn observe(&mut self, interpolant: &Self::Interpolant, segment: &Segment<'_>);
}

/// Splits a run into segments; stores only the last sample and the contact changes since. Contacts change at the times
/// of their events. Between two samples of a closed contact, the normal force counts as positive if it is positive at
/// both; the zero at the touch-down is ignored.
#[derive(Clone, Debug)]
pub(crate) struct SegmentSplitter {
    last: Option<Sample>,
    /// Indices of the contacts in a sample, and their status.
    indices: Vec<usize>,
    contacts: Vec<ContactStatus>,
    /// Normal forces of the contacts at the last sample and at the next one, N; 0 of those that a sample does not have.
    last_n: Vec<f64>,
    next_n: Vec<f64>,
    /// Buffers of the flags of a segment; reused.
    has_touched: Vec<bool>,
    is_active: Vec<bool>,
    /// Contact changes since the last sample, by the places of the contacts in `indices`.
    events: Vec<Event>,
    /// Ends of the segments of the current step; reused.
    cuts_s: Vec<f64>,
    /// Normal force above which a contact is active, N, interpolated linearly; `None`: active at any positive force.
    threshold_n: Option<f64>,
    /// Laws of the contacts, which give a force that rises from zero; without them it counts as active from its start.
    laws: Vec<NormalLaw>,
}

/// Bisections of the time at which a rising force crosses the threshold: to 1e-12 of a step.
const BISECTIONS: usize = 40;

/// The normal force of a contact between two samples, by its law and the cubic Hermite interpolant of its gap.
#[derive(Clone, Copy, Debug)]
struct RisingForce {
    law: NormalLaw,
    gap: Hermite,
    from_s: f64,
    to_s: f64,
}

impl RisingForce {
    fn at(&self, time_s: f64) -> f64 {
        normal_force(&self.law, -self.gap.value(time_s), -self.gap.rate(time_s)).force
    }

    /// Time at which the force crosses the threshold; `None` if it is above it from its start.
    fn crossing_s(&self, threshold_n: f64) -> Option<f64> {
        let (mut below, mut above) = (self.from_s, self.to_s);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (below + above);
            if self.at(middle) > threshold_n { above = middle } else { below = middle }
        }
        (below > self.from_s && above < self.to_s).then_some(above)
    }
}

/// Returns the fraction of the step at which a force crosses the threshold; `None` if it does not. A force that rises
/// from zero counts from the start of the step.
fn threshold_crossing(threshold_n: f64, from_n: f64, to_n: f64) -> Option<f64> {
    (from_n > 0.0 && (from_n > threshold_n) != (to_n > threshold_n)).then(|| (threshold_n - from_n) / (to_n - from_n))
}

impl SegmentSplitter {
    /// Creates a splitter for the contacts with these indices. A contact is active while its normal force exceeds
    /// `threshold_n`, N; `None` is 0.
    pub fn new(indices: impl IntoIterator<Item = usize>, threshold_n: Option<f64>) -> Self {
        let indices: Vec<usize> = indices.into_iter().collect();
        let count = indices.len();
        SegmentSplitter {
            last: None,
            indices,
            contacts: vec![ContactStatus::default(); count],
            last_n: vec![0.0; count],
            next_n: vec![0.0; count],
            has_touched: Vec::with_capacity(count),
            is_active: Vec::with_capacity(count),
            events: Vec::new(),
            cuts_s: Vec::new(),
            threshold_n,
            laws: Vec::new(),
        }
    }

    /// Sets the laws of the contacts.
    #[must_use]
    pub fn with_laws(mut self, laws: Vec<NormalLaw>) -> Self {
        self.laws = laws;
        self
    }

    /// Whether the force of a contact with a law is zero at the last sample, and the contact does not change up to the next one.
    fn is_unloaded(&self, contact: usize, last: &Sample) -> bool {
        let changes = |event: &Event| event.contact == contact && event.time_s > last.time_s;
        contact < self.laws.len() && self.last_n[contact] == 0.0 && !self.events.iter().any(changes)
    }

    /// The force of an unloaded contact that exceeds the threshold at the next sample; `None` for other contacts.
    fn rising_force(&self, contact: usize, last: &Sample, next: &Sample) -> Option<(RisingForce, f64)> {
        let (threshold_n, index) = (self.threshold_n?, self.indices[contact]);
        (self.next_n[contact] > threshold_n && self.is_unloaded(contact, last)).then(|| {
            let [from, to] = [last, next].map(|sample| sample.gap(index));
            let gap = Hermite::new((last.time_s, from[0], from[1]), (next.time_s, to[0], to[1]));
            let law = self.laws[contact];
            (RisingForce { law, gap, from_s: last.time_s, to_s: next.time_s }, threshold_n)
        })
    }

    /// Returns whether a contact is active at a time between two samples.
    fn is_active(&self, contact: usize, last: &Sample, next: &Sample, time_s: f64, lifts_off: bool) -> bool {
        let [from_n, to_n] = [self.last_n[contact], self.next_n[contact]];
        // Most contacts are open.
        if self.events.is_empty() && to_n == 0.0 && from_n == 0.0 {
            return false;
        }
        if self.threshold_n.is_some() && self.is_unloaded(contact, last) {
            let force = self.rising_force(contact, last, next);
            return force.is_some_and(|(force, threshold_n)| force.at(time_s) > threshold_n);
        }
        let threshold_n = self.threshold_n.filter(|_| self.events.iter().all(|event| event.contact != contact));
        let Some(threshold_n) = threshold_n else {
            return self.contacts[contact].is_active_until(to_n, lifts_off);
        };
        let fraction = if from_n > 0.0 { (time_s - last.time_s) / (next.time_s - last.time_s) } else { 1.0 };
        from_n + fraction * (to_n - from_n) > threshold_n
    }

    pub fn last(&self) -> Option<&Sample> {
        self.last.as_ref()
    }

    /// Adds an event; friction events are ignored.
    pub fn event(&mut self, event: &Event) {
        let place = self.indices.iter().position(|index| *index == event.contact);
        if let Some(contact) = place.filter(|_| !event.kind.is_friction_event()) {
            self.events.push(Event { contact, ..*event });
        }
    }

    /// Adds a sample, and passes the segments up to its time to the observer.
    pub fn sample(&mut self, sample: &Sample, observer: &mut impl SegmentObserver) {
        let Some(mut last) = self.last.take() else {
            for (state, index) in self.contacts.iter_mut().zip(&self.indices) {
                if *index < sample.counts().contacts && sample.contact(*index).gap_m < 0.0 {
                    state.touch_down();
                }
            }
            self.read_forces(sample);
            self.update();
            observer.begin(sample);
            self.last = Some(sample.clone());
            return;
        };
        self.read_forces(sample);
        if sample.time_s > last.time_s {
            self.step(&last, sample, observer);
        } else {
            // Two samples of the same instant, before and after an event: the later one applies.
            for event in self.events.drain(..) {
                self.contacts[event.contact].change(event.kind);
            }
            self.update();
        }
        last.clone_from(sample);
        self.last = Some(last);
    }

    /// Reads the normal forces of the next sample.
    fn read_forces(&mut self, next: &Sample) {
        let count = next.counts().contacts;
        for (force_n, index) in self.next_n.iter_mut().zip(&self.indices).filter(|(_, index)| **index < count) {
            *force_n = next.normal_n(*index);
        }
    }

    /// Updates the contacts by the forces of the next sample, which becomes the last one.
    fn update(&mut self) {
        self.contacts.iter_mut().zip(&self.next_n).for_each(|(state, force_n)| state.update(*force_n));
        std::mem::swap(&mut self.last_n, &mut self.next_n);
    }

    fn step(&mut self, last: &Sample, next: &Sample, observer: &mut impl SegmentObserver) {
        let mut cuts_s = std::mem::take(&mut self.cuts_s);
        cuts_s.clear();
        let interpolant = observer.interpolate(last, next, &mut cuts_s);
        cuts_s.extend(self.events.iter().map(|event| event.time_s.clamp(last.time_s, next.time_s)));
        if let Some(threshold_n) = self.threshold_n {
            for (contact, (from_n, to_n)) in self.last_n.iter().zip(&self.next_n).enumerate() {
                // An open contact has no crossing.
                if *from_n == 0.0 && *to_n == 0.0 {
                    continue;
                }
                let fraction = threshold_crossing(threshold_n, *from_n, *to_n);
                cuts_s.extend(fraction.map(|fraction| last.time_s + fraction * (next.time_s - last.time_s)));
                let rising = self.rising_force(contact, last, next);
                cuts_s.extend(rising.and_then(|(force, threshold_n)| force.crossing_s(threshold_n)));
            }
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
                let (mut has_touched, mut is_active) =
                    (std::mem::take(&mut self.has_touched), std::mem::take(&mut self.is_active));
                has_touched.clear();
                is_active.clear();
                has_touched.extend(self.contacts.iter().map(|contact| contact.has_touched));
                is_active.extend(
                    (0..self.indices.len())
                        .map(|contact| self.is_active(contact, last, next, middle_s, lifts_off(contact))),
                );
                let (of_touched, of_active) = (&has_touched[..], &is_active[..]);
                let segment = Segment { from_s, to_s, last, next, has_touched: of_touched, is_active: of_active };
                observer.observe(&interpolant, &segment);
                (self.has_touched, self.is_active) = (has_touched, is_active);
                from_s = to_s;
            }
        }
        for event in pending {
            self.contacts[event.contact].change(event.kind);
        }
        self.events.clear();
        self.cuts_s = cuts_s;
        self.update();
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
    /// Whether the normal law clamped the force to zero at the last sample, after the contact had been loaded.
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
    fn update(&mut self, normal_n: f64) {
        if normal_n > 0.0 {
            *self = ContactStatus { is_closed: true, has_touched: true, was_loaded: true, is_slack: false };
        } else {
            self.is_slack = self.is_closed && self.was_loaded;
        }
    }

    /// Returns whether the normal force is positive up to the next sample: the contact is closed, was loaded at the
    /// last sample or has just touched down, and is loaded at the next sample or lifts off before it.
    fn is_active_until(&self, next_n: f64, lifts_off: bool) -> bool {
        self.is_closed && !self.is_slack && (next_n > 0.0 || lifts_off)
    }
}

/// The cubic Hermite interpolant of one coordinate over one step.
#[derive(Clone, Copy, Debug)]
pub struct Hermite {
    start_s: f64,
    length_s: f64,
    /// Coefficients of 1, x, x², x³ with x = (t − start)/length in [0, 1].
    coefficients: [f64; 4],
}

/// Tolerance of crossing times, s.
pub(crate) const CROSSING_TOLERANCE_S: f64 = 1e-9;

impl Hermite {
    /// Creates the interpolant through (t0, q0) with rate v0 and (t1, q1) with rate v1; t1 > t0.
    pub fn new((t0, q0, v0): (f64, f64, f64), (t1, q1, v1): (f64, f64, f64)) -> Self {
        let length_s = t1 - t0;
        let (m0, m1) = (v0 * length_s, v1 * length_s);
        let rise = q1 - q0;
        Hermite { start_s: t0, length_s, coefficients: [q0, m0, 3.0 * rise - 2.0 * m0 - m1, m0 + m1 - 2.0 * rise] }
    }

    pub fn value(&self, time_s: f64) -> f64 {
        self.evaluate((time_s - self.start_s) / self.length_s)
    }

    pub fn rate(&self, time_s: f64) -> f64 {
        let (x, [_, b, c, d]) = ((time_s - self.start_s) / self.length_s, self.coefficients);
        (b + x * (2.0 * c + x * 3.0 * d)) / self.length_s
    }

    fn evaluate(&self, x: f64) -> f64 {
        let [a, b, c, d] = self.coefficients;
        a + x * (b + x * (c + x * d))
    }

    /// Appends all times within the step at which the cubic crosses `level`, to [`CROSSING_TOLERANCE_S`] or, in shorter
    /// steps, to the resolution of `f64`.
    ///
    /// The turning points split the step into monotone intervals, so bisection finds every crossing.
    pub fn crossings(&self, level: f64, times_s: &mut Vec<f64>) {
        let (turning_points, count) = self.turning_points();
        let mut from = 0.0;
        for &to in turning_points[..count].iter().chain(std::iter::once(&1.0)) {
            if let Some(x) = self.bisect(level, from, to) {
                times_s.push(self.start_s + x * self.length_s);
            }
            from = to;
        }
    }

    /// Returns the roots of the derivative b + 2c x + 3d x² in (0, 1) in ascending order, and their number.
    fn turning_points(&self) -> ([f64; 2], usize) {
        let [_, b, c, d] = self.coefficients;
        let mut roots = [f64::NAN; 2];
        let discriminant = c * c - 3.0 * b * d;
        if discriminant >= 0.0 {
            // Avoids differences of nearly equal numbers; d = 0 gives one root at infinity.
            let q = -(c + discriminant.sqrt().copysign(c));
            roots = [q / (3.0 * d), b / q];
        }
        let mut inside = [0.0; 2];
        let mut count = 0;
        for root in roots {
            if root > 0.0 && root < 1.0 {
                inside[count] = root;
                count += 1;
            }
        }
        inside[..count].sort_by(f64::total_cmp);
        (inside, count)
    }

    fn bisect(&self, level: f64, mut from: f64, mut to: f64) -> Option<f64> {
        let below_at_start = self.evaluate(from) < level;
        if below_at_start == (self.evaluate(to) < level) {
            return None;
        }
        let tolerance = (0.25 * CROSSING_TOLERANCE_S / self.length_s).max(f64::EPSILON);
        while to - from > tolerance {
            let middle = 0.5 * (from + to);
            if middle <= from || middle >= to {
                break;
            }
            if (self.evaluate(middle) < level) == below_at_start {
                from = middle;
            } else {
                to = middle;
            }
        }
        Some(0.5 * (from + to))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// q = (t − 1)(t − 2)(t − 3) and its rate; the interpolant must reproduce a cubic.
    fn cubic(t: f64) -> (f64, f64, f64) {
        let q = (t - 1.0) * (t - 2.0) * (t - 3.0);
        let v = (t - 2.0) * (t - 3.0) + (t - 1.0) * (t - 3.0) + (t - 1.0) * (t - 2.0);
        (t, q, v)
    }

    #[test]
    fn reproduces_a_cubic_and_finds_its_three_roots() {
        let hermite = Hermite::new(cubic(0.5), cubic(3.5));
        for t in [0.5, 0.9, 1.7, 2.2, 3.5] {
            assert!((hermite.value(t) - cubic(t).1).abs() < 1e-13);
        }
        let mut roots = Vec::new();
        hermite.crossings(0.0, &mut roots);
        assert_eq!(roots.len(), 3);
        for (root, expected) in roots.iter().zip([1.0, 2.0, 3.0]) {
            assert!((root - expected).abs() < CROSSING_TOLERANCE_S, "{root}");
        }
    }

    #[test]
    fn a_level_that_is_not_reached_has_no_crossing() {
        let mut roots = Vec::new();
        Hermite::new((0.0, 1.0, 0.0), (1.0, 1.0, 0.0)).crossings(0.5, &mut roots);
        Hermite::new((0.0, 1.0, 0.0), (1.0, 2.0, 0.0)).crossings(2.5, &mut roots);
        assert!(roots.is_empty());
    }

    #[test]
    fn a_minimum_between_samples_is_found() {
        // From 1 down and back to 1 within the step; the minimum 1 − 2/4 is in the middle.
        let mut roots = Vec::new();
        Hermite::new((0.0, 1.0, -2.0), (1.0, 1.0, 2.0)).crossings(0.75, &mut roots);
        assert_eq!(roots.len(), 2);
        assert!((roots[0] - (0.5 - 0.125f64.sqrt())).abs() < 1e-9);
        assert!((roots[1] - (0.5 + 0.125f64.sqrt())).abs() < 1e-9);
    }
}
