//! The normal impulse of every impact of two surfaces, measured as a run goes by.

use crate::trace::{ContactSample, Event, EventKind, Sample, Sink, SinkError};

/// How long after its touch-down the impulse of a contact that stays is taken. The force of an impact of these grippers has done
/// its work after some 10 µs; what the motor and the spring press into the object in 20 µs is below a hundredth of it.
pub const IMPACT_S: f64 = 20e-6;

/// One touch-down and the normal impulse of the time after it.
///
/// In the step in which the surfaces meet, the impulse counts as given at once, but for what presses at its end: a step
/// knows no finer, and what it holds is the impact. In later steps it is interpolated, rising as steeply as the forces
/// say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Index among the contacts of a sample.
    pub contact: usize,
    /// Time of the touch-down.
    pub time_s: f64,
    /// Normal impulse of the run at the last sample before the touch-down: nothing pressed since.
    before_n_s: f64,
    /// Normal impulse of the run up to [`IMPACT_S`] later, as far as the run has come.
    after_n_s: f64,
    met: bool,
    over: bool,
    /// Time of the lift-off that ends the contact, and its normal impulse; `None` while it lasts.
    lift: Option<(f64, f64)>,
}

impl Impact {
    /// Normal impulse up to the lift-off; of a contact that stays, in the [`IMPACT_S`] after the touch-down.
    pub fn impulse_n_s(&self) -> f64 {
        self.lift.map_or(self.after_n_s - self.before_n_s, |(_, impulse_n_s)| impulse_n_s)
    }

    /// End of what [`Impact::impulse_n_s`] takes in.
    pub fn end_s(&self) -> f64 {
        self.lift.map_or(self.time_s + IMPACT_S, |(end_s, _)| end_s)
    }

    /// Looks at the interval from one sample to the next.
    fn look(&mut self, from: &Sample, to: &Sample) {
        let end_s = self.time_s + IMPACT_S;
        if self.over || to.time_s <= self.time_s {
            return;
        }
        self.after_n_s = match self.met {
            true => impulse(from, to, self.contact, end_s),
            false => self.first(&to.contacts[self.contact], to.time_s - end_s),
        };
        (self.met, self.over) = (true, to.time_s >= end_s);
    }

    /// Normal impulse up to the end of what is measured, by the first sample after the touch-down, so much later than
    /// that end.
    fn first(&self, contact: &ContactSample, late_s: f64) -> f64 {
        (contact.impulse_n_s - contact.normal_n * late_s.max(0.0)).max(self.before_n_s)
    }
}

/// A [`Sink`] that measures impacts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Impacts {
    /// In order of their touch-downs.
    pub all: Vec<Impact>,
    last: Option<Sample>,
    /// Impacts before this one are over.
    open: usize,
}

impl Impacts {
    /// The impacts of one contact.
    pub fn of(&self, contact: usize) -> impl Iterator<Item = &Impact> {
        self.all.iter().filter(move |impact| impact.contact == contact)
    }
}

impl Sink for Impacts {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let from = self.last.as_ref().unwrap_or(sample);
        for impact in &mut self.all[self.open..] {
            impact.look(from, sample);
        }
        while self.all.get(self.open).is_some_and(|impact| impact.over) {
            self.open += 1;
        }
        match &mut self.last {
            Some(last) => last.clone_from(sample),
            None => self.last = Some(sample.clone()),
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        let contact = event.contact;
        let stop = self.last.as_ref().is_some_and(|last| last.is_stop(contact));
        if event.kind == EventKind::TouchDown && !stop {
            let before_n_s = self.last.as_ref().map_or(0.0, |last| last.contacts[contact].impulse_n_s);
            self.all.push(Impact {
                contact,
                time_s: event.time_s,
                before_n_s,
                after_n_s: before_n_s,
                met: false,
                over: false,
                lift: None,
            });
        }
        if let Some(impact) = self.all.iter_mut().rfind(|impact| impact.contact == contact) {
            match event.kind {
                EventKind::LiftOff => impact.lift = Some((event.time_s, event.impulse)),
                EventKind::TouchDown | EventKind::Reload => impact.lift = None,
                EventKind::Slips | EventKind::Sticks => {}
            }
        }
        Ok(())
    }
}

/// Normal impulse since the start of the run at a time between two samples: cubic, with the forces as slopes as far as
/// it stays monotone (Fritsch and Carlson 1980: slopes up to three times the mean one).
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
