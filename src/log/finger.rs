//! The log of a finger: its channels, samples and events.

use std::io::Write;

use mcap::McapError;

use super::core::{ChannelId, Core, Severity};
use super::messages::{Contact, Energy, Impact, Limit, LimitImpact, State};
use super::writer::{Channels, Writer};
use crate::scene::Scene;
use crate::trace::{Event, EventKind, Sample, Sink, SinkError, Site};

/// The channels that a scene needs; `None` where it has no such thing.
pub struct FingerChannels {
    state: ChannelId,
    contacts: Option<[ChannelId; 2]>,
    limit: Option<ChannelId>,
    energy: ChannelId,
    impacts: [Option<ChannelId>; 3],
}

impl Channels<Scene> for FingerChannels {
    fn register<W: Write>(core: &mut Core<W>, scene: &Scene) -> Result<Self, McapError> {
        let object = scene.object.is_some();
        let limit = scene.limit.is_some();
        Ok(FingerChannels {
            state: core.channel::<State>("/state")?,
            contacts: match object {
                true => {
                    Some([core.channel::<Contact>("/contact/proximal")?, core.channel::<Contact>("/contact/distal")?])
                }
                false => None,
            },
            limit: limit.then(|| core.channel::<Limit>("/limit")).transpose()?,
            energy: core.channel::<Energy>("/energy")?,
            impacts: [
                object.then(|| core.channel::<Impact>("/impact/proximal")).transpose()?,
                object.then(|| core.channel::<Impact>("/impact/distal")).transpose()?,
                limit.then(|| core.channel::<LimitImpact>("/impact/limit")).transpose()?,
            ],
        })
    }
}

impl<W: Write> Writer<W> {
    fn put_sample(&mut self, sample: &Sample) -> Result<(), McapError> {
        let (core, channels) = (&mut self.core, &self.channels);
        let log_time = core.tick(sample.time_s);
        core.put(channels.state, log_time, &State::from(sample))?;
        if let Some(contacts) = channels.contacts {
            for (channel, contact) in contacts.into_iter().zip([&sample.proximal, &sample.distal]) {
                core.put(channel, log_time, &Contact::new(sample.time_s, contact))?;
            }
        }
        if let Some(limit) = channels.limit {
            core.put(limit, log_time, &Limit::from(sample))?;
        }
        core.put(channels.energy, log_time, &Energy::new(sample.time_s, &sample.energy))?;
        core.close_full_chunk()
    }

    fn put_event(&mut self, event: &Event) -> Result<(), McapError> {
        let core = &mut self.core;
        let log_time = core.tick(event.time_s);
        match (self.channels.impacts[event.site as usize], event.site) {
            (Some(channel), Site::Proximal | Site::Distal) => core.put(channel, log_time, &Impact::from(event))?,
            (Some(channel), Site::Limit) => core.put(channel, log_time, &LimitImpact::from(event))?,
            (None, _) => {}
        }
        core.line(self.events, event.time_s, Severity::Info, event.site.name(), &event_text(event))?;
        core.close_full_chunk()
    }
}

impl<W: Write> Sink for Writer<W> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let written = self.put_sample(sample);
        self.named(written)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        let written = self.put_event(event);
        self.named(written)
    }
}

/// An event in words and figures.
fn event_text(event: &Event) -> String {
    let site = match event.site {
        Site::Proximal => "proximal phalanx",
        Site::Distal => "distal phalanx",
        Site::Limit => "joint limit",
    };
    let units = match event.site {
        Site::Proximal | Site::Distal => ["m/s", "N·s"],
        Site::Limit => ["rad/s", "N·m·s"],
    };
    change_text(site, event.kind, event.time_s, [event.approach_speed, event.impulse], units)
}

/// A change of contact at `place`, with approach speed and impulse and their units.
pub(super) fn change_text(
    place: &str,
    kind: EventKind,
    time_s: f64,
    [speed, impulse]: [f64; 2],
    [speed_unit, impulse_unit]: [&str; 2],
) -> String {
    let time_ms = time_s * 1e3;
    match kind {
        EventKind::TouchDown => {
            format!("{place}: touch-down at {time_ms:.6} ms, approach speed {speed:.6} {speed_unit}")
        }
        EventKind::LiftOff => {
            format!("{place}: lift-off at {time_ms:.6} ms, impulse {impulse:.6e} {impulse_unit} since touch-down")
        }
        EventKind::Reload => format!("{place}: pressed again at {time_ms:.6} ms, before it had parted"),
    }
}
