//! What the samples and events of a run say in sum.

use crate::criteria::{Rebound, Rebounds};
use crate::log::Names;
use crate::trace::bodies::{BodiesEvent, BodiesOutcome, BodiesSample};
use crate::trace::{Event, EventKind, Outcome, Sample, Sink, SinkError, SiteSummary};

/// A [`Sink`] that keeps of a run of a finger what its samples and events say in sum.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    outcome: Outcome,
    any: bool,
}

impl Summary {
    /// The summary, unless there was no sample. What a run costs is not known from its samples.
    pub fn outcome(&self) -> Option<&Outcome> {
        self.any.then_some(&self.outcome)
    }
}

/// Takes the force, gap and impulse of a contact at a sample.
fn take(site: &mut SiteSummary, [force, gap, impulse]: [f64; 3]) {
    site.take((force, -gap));
    site.impulse_n_s = impulse;
}

fn touch(site: &mut SiteSummary, kind: EventKind, time_s: f64) {
    if kind == EventKind::TouchDown {
        site.first_s.get_or_insert(time_s);
        site.touchdowns = site.touchdowns.saturating_add(1);
    }
}

impl Sink for Summary {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.any = true;
        self.outcome.last = *sample;
        let (proximal, distal, limit) = (&sample.proximal, &sample.distal, &sample.limit);
        let now = [
            [proximal.normal_n, proximal.gap_m, proximal.impulse_n_s],
            [distal.normal_n, distal.gap_m, distal.impulse_n_s],
            [limit.normal_n, limit.gap_m, limit.impulse_n_s],
        ];
        self.outcome.sites.iter_mut().zip(now).for_each(|(site, now)| take(site, now));
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        touch(&mut self.outcome.sites[event.site as usize], event.kind, event.time_s);
        Ok(())
    }
}

/// A sink that does the same of a run of discs.
#[derive(Clone, Debug, Default)]
pub struct DiscsSummary {
    pub names: Names,
    outcome: BodiesOutcome,
    rebounds: Rebounds,
    any: bool,
}

impl DiscsSummary {
    pub fn new(names: Names) -> Self {
        let pairs = names.pairs.len();
        let outcome = BodiesOutcome { pairs: vec![SiteSummary::default(); pairs], ..BodiesOutcome::default() };
        DiscsSummary { names, outcome, rebounds: Rebounds::new(pairs), any: false }
    }

    /// The summary, unless there was no sample.
    pub fn outcome(&self) -> Option<&BodiesOutcome> {
        self.any.then_some(&self.outcome)
    }

    pub fn rebounds(&self) -> &[Rebound] {
        self.rebounds.pairs()
    }
}

impl Sink<BodiesSample> for DiscsSummary {
    fn sample(&mut self, sample: &BodiesSample) -> Result<(), SinkError> {
        self.any = true;
        self.outcome.last.clone_from(sample);
        for (pair, contact) in self.outcome.pairs.iter_mut().zip(&sample.contacts) {
            take(pair, [contact.normal_n, contact.gap_m, contact.impulse_n_s]);
        }
        self.rebounds.sample(sample)
    }

    fn event(&mut self, event: &BodiesEvent) -> Result<(), SinkError> {
        touch(&mut self.outcome.pairs[event.pair], event.kind, event.time_s);
        self.rebounds.event(event)
    }
}
