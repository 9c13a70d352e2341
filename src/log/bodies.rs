//! The log of a scene of discs: its channels, samples and events.

use std::io::Write;

use mcap::McapError;

use super::core::{ChannelId, Core, Severity};
use super::finger::change_text;
use super::messages::{Contact, Disc, Energy, Impact};
use super::writer::{Channels, Writer};
use crate::scene::BodiesScene;
use crate::trace::SinkError;
use crate::trace::bodies::{BodiesEvent, BodiesSample, BodiesSink};

/// One channel for every disc, two for every pair.
pub struct BodiesChannels {
    discs: Vec<ChannelId>,
    pairs: Vec<PairChannels>,
    energy: ChannelId,
}

struct PairChannels {
    name: String,
    contact: ChannelId,
    impact: ChannelId,
}

impl Channels<BodiesScene> for BodiesChannels {
    fn register<W: Write>(core: &mut Core<W>, scene: &BodiesScene) -> Result<Self, McapError> {
        let mut discs = Vec::with_capacity(scene.discs.len());
        for disc in &scene.discs {
            discs.push(core.channel::<Disc>(&format!("/disc/{}", disc.name))?);
        }
        let mut pairs = Vec::new();
        for pair in scene.pairs() {
            let name = scene.pair_name(pair);
            let contact = core.channel::<Contact>(&format!("/contact/{name}"))?;
            let impact = core.channel::<Impact>(&format!("/impact/{name}"))?;
            pairs.push(PairChannels { name, contact, impact });
        }
        Ok(BodiesChannels { discs, pairs, energy: core.channel::<Energy>("/energy")? })
    }
}

impl<W: Write> Writer<W, BodiesChannels> {
    fn put_sample(&mut self, sample: &BodiesSample) -> Result<(), McapError> {
        let (core, channels) = (&mut self.core, &self.channels);
        let log_time = core.tick(sample.time_s);
        for (channel, disc) in channels.discs.iter().zip(&sample.discs) {
            core.put(*channel, log_time, &Disc::new(sample.time_s, disc))?;
        }
        for (pair, contact) in channels.pairs.iter().zip(&sample.contacts) {
            core.put(pair.contact, log_time, &Contact::new(sample.time_s, contact))?;
        }
        core.put(channels.energy, log_time, &Energy::new(sample.time_s, &sample.energy))?;
        core.close_full_chunk()
    }

    fn put_event(&mut self, event: &BodiesEvent) -> Result<(), McapError> {
        let (core, pair) = (&mut self.core, &self.channels.pairs[event.pair]);
        let log_time = core.tick(event.time_s);
        core.put(pair.impact, log_time, &Impact::from(event))?;
        let figures = [event.approach_m_s, event.impulse_n_s];
        let text = change_text(&pair.name, event.kind, event.time_s, figures, ["m/s", "N·s"]);
        core.line(self.events, event.time_s, Severity::Info, &pair.name, &text)?;
        core.close_full_chunk()
    }
}

impl<W: Write> BodiesSink for Writer<W, BodiesChannels> {
    fn sample(&mut self, sample: &BodiesSample) -> Result<(), SinkError> {
        let written = self.put_sample(sample);
        self.named(written)
    }

    fn event(&mut self, event: &BodiesEvent) -> Result<(), SinkError> {
        let written = self.put_event(event);
        self.named(written)
    }
}
