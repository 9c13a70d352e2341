//! The log of a scene of discs: its channels, samples and events.

use std::io::Write;

use mcap::McapError;

use super::core::{ChannelId, Core, Severity};
use super::finger::change_text;
use super::messages::{Contact, Disc, Energy, Impact};
use super::pictures::Pictures;
use super::writer::{Channels, Writer};
use crate::drawing;
use crate::scene::BodiesScene;
use crate::trace::bodies::{BodiesEvent, BodiesSample, DiscState};
use crate::trace::{Sink, SinkError};

/// One channel for every disc, two for every pair.
pub struct BodiesChannels {
    discs: Vec<ChannelId>,
    pairs: Vec<PairChannels>,
    energy: ChannelId,
    pictures: Option<Pictures>,
    /// Where its bodies are.
    scene: BodiesScene,
}

struct PairChannels {
    name: String,
    contact: ChannelId,
    impact: ChannelId,
}

impl Channels for BodiesChannels {
    type Scene = BodiesScene;
    type Sample = BodiesSample;
    type Event = BodiesEvent;

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
        let energy = core.channel::<Energy>("/energy")?;
        let at_start = scene.discs.iter().map(|disc| DiscState { centre_m: disc.centre_m, ..DiscState::default() });
        let poses = drawing::disc_poses(scene, &BodiesSample { discs: at_start.collect(), ..BodiesSample::default() });
        let pictures = Pictures::register(core, &drawing::discs(scene), &poses, scene.log.picture_hz)?;
        Ok(BodiesChannels { discs, pairs, energy, pictures, scene: scene.clone() })
    }

    fn sample<W: Write>(&mut self, core: &mut Core<W>, sample: &BodiesSample) -> Result<(), McapError> {
        let log_time = core.tick(sample.time_s);
        for (channel, disc) in self.discs.iter().zip(&sample.discs) {
            core.put(*channel, log_time, &Disc::new(sample.time_s, disc))?;
        }
        for (pair, contact) in self.pairs.iter().zip(&sample.contacts) {
            core.put(pair.contact, log_time, &Contact::new(sample.time_s, contact))?;
        }
        core.put(self.energy, log_time, &Energy::new(sample.time_s, &sample.energy))?;
        match &mut self.pictures {
            Some(pictures) => {
                let poses = || drawing::disc_poses(&self.scene, sample);
                pictures.sample(core, sample.time_s, poses, sample.contacts.iter())
            }
            None => Ok(()),
        }
    }

    fn event<W: Write>(&mut self, core: &mut Core<W>, lines: ChannelId, event: &BodiesEvent) -> Result<(), McapError> {
        let pair = &self.pairs[event.pair];
        let log_time = core.tick(event.time_s);
        core.put(pair.impact, log_time, &Impact::from(event))?;
        let figures = [event.approach_m_s, event.impulse_n_s];
        let text = change_text(&pair.name, event.kind, event.time_s, figures, ["m/s", "N·s"]);
        core.line(lines, event.time_s, Severity::Info, &pair.name, &text)
    }
}

impl<W: Write> Sink<BodiesSample> for Writer<W, BodiesChannels> {
    fn sample(&mut self, sample: &BodiesSample) -> Result<(), SinkError> {
        self.take(sample)
    }

    fn extreme(&mut self, sample: &BodiesSample) -> Result<(), SinkError> {
        self.take(sample)
    }

    fn event(&mut self, event: &BodiesEvent) -> Result<(), SinkError> {
        self.take_event(event)
    }
}
