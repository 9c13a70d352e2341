//! The normal impulse of every impact of two surfaces, measured during a run.

use crate::trace::{ContactSample, Event, EventKind, Sample, Sink, SinkError};

/// Time after the touch-down over which the impulse of a lasting contact is measured, s. The impact force of these
/// grippers has decayed after about 10 µs; the impulse of the motor and the spring over 20 µs is below a hundredth of
/// it.
pub const IMPACT_S: f64 = 20e-6;

/// One touch-down and the normal impulse after it.
///
/// Within the step that contains the touch-down, the impulse is taken as instantaneous, minus the contribution of the
/// normal force at the end of the step, because the step does not resolve the impact. In later steps the impulse is
/// interpolated with the normal forces as slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Index among the contacts of a sample.
    pub contact: usize,
    /// Time of the touch-down.
    pub time_s: f64,
    /// Cumulative normal impulse at the last sample before the touch-down; the contact force is zero from then on until
    /// the touch-down.
    before_n_s: f64,
    /// Cumulative normal impulse [`IMPACT_S`] after the touch-down, or at the latest sample if that is earlier.
    after_n_s: f64,
    /// Whether there is a sample after the touch-down.
    has_sample: bool,
    /// Whether [`IMPACT_S`] have passed since the touch-down.
    is_complete: bool,
    /// Time of the lift-off that ends the contact, and the normal impulse of the contact; `None` while it lasts.
    lift_off: Option<(f64, f64)>,
}

impl Impact {
    /// Normal impulse up to the lift-off, or of a lasting contact in the [`IMPACT_S`] after the touch-down.
    pub fn impulse_n_s(&self) -> f64 {
        self.lift_off.map_or(self.after_n_s - self.before_n_s, |(_, impulse_n_s)| impulse_n_s)
    }

    /// End of the interval covered by [`Impact::impulse_n_s`].
    pub fn end_s(&self) -> f64 {
        self.lift_off.map_or(self.time_s + IMPACT_S, |(end_s, _)| end_s)
    }

    /// Updates the impulse up to the sample `to`, which follows `from`.
    fn update(&mut self, from: &Sample, to: &Sample) {
        let end_s = self.time_s + IMPACT_S;
        if self.is_complete || to.time_s <= self.time_s {
            return;
        }
        self.after_n_s = match self.has_sample {
            true => impulse(from, to, self.contact, end_s),
            false => self.impulse_at_first_sample(&to.contacts[self.contact], to.time_s - end_s),
        };
        (self.has_sample, self.is_complete) = (true, to.time_s >= end_s);
    }

    /// Cumulative normal impulse at the end of the measured interval, from the first sample after the touch-down, which
    /// is `late_s` after that end.
    fn impulse_at_first_sample(&self, contact: &ContactSample, late_s: f64) -> f64 {
        (contact.impulse_n_s - contact.normal_n * late_s.max(0.0)).max(self.before_n_s)
    }
}

/// A [`Sink`] that measures impacts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Impacts {
    /// Impacts in the order of their touch-downs.
    pub all: Vec<Impact>,
    last: Option<Sample>,
    /// Impacts before this index are complete.
    first_open: usize,
}

impl Impacts {
    /// Iterates over the impacts of one contact.
    pub fn of_contact(&self, contact: usize) -> impl Iterator<Item = &Impact> {
        self.all.iter().filter(move |impact| impact.contact == contact)
    }
}

impl Sink for Impacts {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let from = self.last.as_ref().unwrap_or(sample);
        for impact in &mut self.all[self.first_open..] {
            impact.update(from, sample);
        }
        while self.all.get(self.first_open).is_some_and(|impact| impact.is_complete) {
            self.first_open += 1;
        }
        match &mut self.last {
            Some(last) => last.clone_from(sample),
            None => self.last = Some(sample.clone()),
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        let contact = event.contact;
        let is_stop = self.last.as_ref().is_some_and(|last| last.is_stop(contact));
        if event.kind == EventKind::TouchDown && !is_stop {
            let before_n_s = self.last.as_ref().map_or(0.0, |last| last.contacts[contact].impulse_n_s);
            self.all.push(Impact {
                contact,
                time_s: event.time_s,
                before_n_s,
                after_n_s: before_n_s,
                has_sample: false,
                is_complete: false,
                lift_off: None,
            });
        }
        if let Some(impact) = self.all.iter_mut().rfind(|impact| impact.contact == contact) {
            match event.kind {
                EventKind::LiftOff => impact.lift_off = Some((event.time_s, event.impulse)),
                EventKind::TouchDown | EventKind::Reload => impact.lift_off = None,
                EventKind::Slips | EventKind::Sticks => {}
            }
        }
        Ok(())
    }
}

/// Cumulative normal impulse at a time between two samples: cubic Hermite interpolation with the normal forces as
/// slopes. The slopes are limited to three times the mean slope to keep it monotone (Fritsch and Carlson 1980).
fn impulse(from: &Sample, to: &Sample, contact: usize, time_s: f64) -> f64 {
    let (a, b) = (&from.contacts[contact], &to.contacts[contact]);
    let length = to.time_s - from.time_s;
    if length <= 0.0 || time_s >= to.time_s {
        return b.impulse_n_s;
    }
    let x = ((time_s - from.time_s) / length).clamp(0.0, 1.0);
    let rise = b.impulse_n_s - a.impulse_n_s;
    let slope = |normal_n: f64| (normal_n * length).min(3.0 * rise);
    let (x2, x3) = (x * x, x * x * x);
    a.impulse_n_s
        + rise * (3.0 * x2 - 2.0 * x3)
        + slope(a.normal_n) * (x3 - 2.0 * x2 + x)
        + slope(b.normal_n) * (x3 - x2)
}
