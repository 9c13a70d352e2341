//! The normal impulse of every impact of a phalanx, measured as a run goes by.

use crate::trace::{ContactSample, Event, EventKind, Sample, Sink, SinkError, Site};

/// How long after its touch-down the impulse of an impact is taken. The force of an impact of these grippers has done its
/// work after some 10 µs; what the motor and the spring press into the object in 20 µs is below a hundredth of it.
pub const IMPACT_S: f64 = 20e-6;

/// One touch-down of a phalanx and the normal impulse of the time after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    pub site: Site,
    /// Time of the touch-down.
    pub time_s: f64,
    /// Normal impulse of the run up to the touch-down, once known.
    before_n_s: Option<f64>,
    /// Normal impulse of the run up to [`IMPACT_S`] later, once known; of its last sample if it ends earlier.
    after_n_s: f64,
    over: bool,
}

impl Impact {
    fn new(site: Site, time_s: f64) -> Self {
        Impact { site, time_s, before_n_s: None, after_n_s: 0.0, over: false }
    }

    /// Normal impulse in the [`IMPACT_S`] after the touch-down.
    pub fn impulse_n_s(&self) -> f64 {
        self.before_n_s.map_or(0.0, |before| self.after_n_s - before)
    }

    /// Looks at the interval from one sample to the next.
    fn look(&mut self, from: &Sample, to: &Sample) {
        if self.over || to.time_s < self.time_s {
            return;
        }
        let at = |time_s: f64| impulse(from, to, self.site, time_s);
        let end_s = self.time_s + IMPACT_S;
        self.before_n_s = self.before_n_s.or(Some(at(self.time_s)));
        self.after_n_s = at(end_s);
        self.over = to.time_s >= end_s;
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
            self.all.push(Impact::new(event.site, event.time_s));
        }
        Ok(())
    }
}

/// Normal impulse since the start of the run at a time between two samples.
fn impulse(from: &Sample, to: &Sample, site: Site, time_s: f64) -> f64 {
    let (before, after) = (contact(from, site).impulse_n_s, contact(to, site).impulse_n_s);
    let length = to.time_s - from.time_s;
    if length <= 0.0 {
        return after;
    }
    before + ((time_s - from.time_s) / length).clamp(0.0, 1.0) * (after - before)
}

/// The contact of one phalanx.
fn contact(sample: &Sample, site: Site) -> &ContactSample {
    match site {
        Site::Proximal => &sample.proximal,
        Site::Distal | Site::Limit => &sample.distal,
    }
}
