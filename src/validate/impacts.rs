//! The normal impulse of every impact of a phalanx, measured as a run goes by.

use crate::trace::{ContactSample, Event, EventKind, Sample, Sink, SinkError, Site};

/// How long after its touch-down the impulse of a contact that stays is taken. The force of an impact of these grippers has done
/// its work after some 10 µs; what the motor and the spring press into the object in 20 µs is below a hundredth of it.
pub const IMPACT_S: f64 = 20e-6;

/// One touch-down of a phalanx and the normal impulse of the time after it.
///
/// In the step in which the surfaces meet, the impulse counts as given at once, but for what presses at its end: a step
/// knows no finer, and what it holds is the impact. In later steps it is interpolated, rising as steeply as the forces
/// say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    pub site: Site,
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
            true => impulse(from, to, self.site, end_s),
            false => self.first(contact(to, self.site), to.time_s - end_s),
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
    /// The impacts of one phalanx.
    pub fn of(&self, site: Site) -> impl Iterator<Item = &Impact> {
        self.all.iter().filter(move |impact| impact.site == site)
    }
}

impl Sink for Impacts {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let from = self.last.replace(*sample).unwrap_or(*sample);
        for impact in &mut self.all[self.open..] {
            impact.look(&from, sample);
        }
        while self.all.get(self.open).is_some_and(|impact| impact.over) {
            self.open += 1;
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        if event.kind == EventKind::TouchDown && event.site != Site::Limit {
            let before_n_s = self.last.map_or(0.0, |last| contact(&last, event.site).impulse_n_s);
            self.all.push(Impact {
                site: event.site,
                time_s: event.time_s,
                before_n_s,
                after_n_s: before_n_s,
                met: false,
                over: false,
                lift: None,
            });
        }
        if let Some(impact) = self.all.iter_mut().rfind(|impact| impact.site == event.site) {
            match event.kind {
                EventKind::LiftOff => impact.lift = Some((event.time_s, event.impulse)),
                EventKind::TouchDown | EventKind::Reload => impact.lift = None,
            }
        }
        Ok(())
    }
}

/// Normal impulse since the start of the run at a time between two samples: cubic, with the forces as slopes as far as
/// it stays monotone (Fritsch and Carlson 1980: slopes up to three times the mean one).
fn impulse(from: &Sample, to: &Sample, site: Site, time_s: f64) -> f64 {
    let (a, b) = (contact(from, site), contact(to, site));
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

/// The contact of one phalanx.
fn contact(sample: &Sample, site: Site) -> &ContactSample {
    match site {
        Site::Proximal => &sample.proximal,
        Site::Distal | Site::Limit => &sample.distal,
    }
}
