//! Summary of a run from its samples and events.

use crate::criteria::{Rebound, Rebounds};
use crate::scene::Scene;
use crate::trace::{ContactSummary, Event, EventKind, Outcome, Sample, Schema, Sink, SinkError};

/// A [`Sink`] that summarises the samples and events of a run.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    pub layout: Schema,
    outcome: Outcome,
    /// Rebounds of the pairs of bodies.
    rebounds: Option<Rebounds>,
    has_sample: bool,
}

impl Summary {
    /// Creates a summary for samples of this layout. `scene` is the scene of a log of bodies, if known; it provides the
    /// masses for the rebounds.
    pub fn new(layout: Schema, scene: Option<&Scene>) -> Self {
        let contacts = vec![ContactSummary::default(); layout.contacts.len()];
        let rebounds_of_scene = scene
            .map(|scene| Rebounds::for_system(&scene.system))
            .filter(|found| found.pairs().len() == contacts.len());
        let rebounds =
            layout.fingers.is_empty().then(|| rebounds_of_scene.unwrap_or_else(|| Rebounds::new(contacts.len())));
        Summary { layout, outcome: Outcome { contacts, ..Outcome::default() }, rebounds, has_sample: false }
    }

    /// Returns the summary; `None` without samples. It contains no computational cost, which samples do not record.
    pub fn outcome(&self) -> Option<&Outcome> {
        self.has_sample.then_some(&self.outcome)
    }

    /// Returns the rebounds of the pairs of bodies; empty for scenes with fingers.
    pub fn rebounds(&self) -> &[Rebound] {
        self.rebounds.as_ref().map_or(&[], Rebounds::pairs)
    }
}

impl Sink for Summary {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.has_sample = true;
        self.outcome.last.clone_from(sample);
        for (summary, contact) in self.outcome.contacts.iter_mut().zip(sample.contacts()) {
            summary.update(contact.force_and_penetration());
            summary.impulse_n_s = contact.impulse_n_s;
        }
        self.rebounds.sample(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        let contact = &mut self.outcome.contacts[event.contact];
        if event.kind == EventKind::TouchDown {
            contact.first_s.get_or_insert(event.time_s);
            contact.touchdowns = contact.touchdowns.saturating_add(1);
        }
        contact.slips = contact.slips.saturating_add(u32::from(event.kind == EventKind::Slips));
        self.rebounds.event(event)
    }
}
