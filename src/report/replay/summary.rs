//! What the samples and events of a run say in sum.

use crate::criteria::{Rebound, Rebounds};
use crate::scene::Scene;
use crate::trace::{ContactSummary, Event, EventKind, Layout, Outcome, Sample, Sink, SinkError};

/// A [`Sink`] that keeps of a run what its samples and events say in sum.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    pub layout: Layout,
    outcome: Outcome,
    /// Of the pairs of bodies.
    rebounds: Option<Rebounds>,
    any: bool,
}

impl Summary {
    /// Of samples of this layout.
    /// `scene`: of a log of bodies, where it is known, for their masses.
    pub fn new(layout: Layout, scene: Option<&Scene>) -> Self {
        let contacts = vec![ContactSummary::default(); layout.contacts.len()];
        let of_scene =
            scene.map(|scene| Rebounds::of(&scene.system)).filter(|found| found.pairs().len() == contacts.len());
        let rebounds = layout.fingers.is_empty().then(|| of_scene.unwrap_or_else(|| Rebounds::new(contacts.len())));
        Summary { layout, outcome: Outcome { contacts, ..Outcome::default() }, rebounds, any: false }
    }

    /// The summary, unless there was no sample. What a run costs is not known from its samples.
    pub fn outcome(&self) -> Option<&Outcome> {
        self.any.then_some(&self.outcome)
    }

    /// Of the pairs of bodies; empty where there is a finger.
    pub fn rebounds(&self) -> &[Rebound] {
        self.rebounds.as_ref().map_or(&[], Rebounds::pairs)
    }
}

impl Sink for Summary {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.any = true;
        self.outcome.last.clone_from(sample);
        for (summary, contact) in self.outcome.contacts.iter_mut().zip(&sample.contacts) {
            summary.take(contact.pressed());
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
