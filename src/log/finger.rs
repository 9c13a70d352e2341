//! The log of a finger: its channels, samples and events.

use std::io::Write;

use mcap::McapError;

use super::core::{ChannelId, Core, Severity};
use super::messages::{Contact, Energy, Impact, Limit, LimitImpact, State};
use super::pictures::Pictures;
use super::writer::{Channels, Writer};
use crate::drawing;
use crate::scene::Scene;
use crate::trace::{Event, EventKind, Sample, Sink, SinkError, Site};

/// The channels that a scene needs; `None` where it has no such thing.
pub struct FingerChannels {
    state: ChannelId,
    contacts: Option<[ChannelId; 2]>,
    limit: Option<ChannelId>,
    energy: ChannelId,
    impacts: [Option<ChannelId>; 3],
    pictures: Option<Pictures>,
    grasp: Grasp,
    /// Where its bodies are.
    scene: Scene,
}

impl Channels for FingerChannels {
    type Scene = Scene;
    type Sample = Sample;
    type Event = Event;

    fn register<W: Write>(core: &mut Core<W>, scene: &Scene) -> Result<Self, McapError> {
        let object = scene.object.is_some();
        let limit = scene.limit.is_some();
        let poses = drawing::finger_poses(scene, &Sample::default());
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
            pictures: Pictures::register(core, &drawing::finger(scene), &poses, scene.log.picture_hz)?,
            grasp: Grasp::default(),
            scene: scene.clone(),
        })
    }

    fn sample<W: Write>(&mut self, core: &mut Core<W>, sample: &Sample) -> Result<(), McapError> {
        let log_time = core.tick(sample.time_s);
        core.put(self.state, log_time, &State::from(sample))?;
        if let Some(contacts) = self.contacts {
            for (channel, contact) in contacts.into_iter().zip([&sample.proximal, &sample.distal]) {
                core.put(channel, log_time, &Contact::new(sample.time_s, contact))?;
            }
        }
        if let Some(limit) = self.limit {
            core.put(limit, log_time, &Limit::from(sample))?;
        }
        core.put(self.energy, log_time, &Energy::new(sample.time_s, &sample.energy))?;
        if let Some(pictures) = &mut self.pictures {
            let contacts = [&sample.proximal, &sample.distal];
            let drawn = if self.contacts.is_some() { &contacts[..] } else { &[] };
            let poses = || drawing::finger_poses(&self.scene, sample);
            pictures.sample(core, sample.time_s, poses, drawn.iter().copied())?;
        }
        Ok(())
    }

    fn event<W: Write>(&mut self, core: &mut Core<W>, lines: ChannelId, event: &Event) -> Result<(), McapError> {
        let log_time = core.tick(event.time_s);
        match (self.impacts[event.site as usize], event.site) {
            (Some(channel), Site::Proximal | Site::Distal) => core.put(channel, log_time, &Impact::from(event))?,
            (Some(channel), Site::Limit) => core.put(channel, log_time, &LimitImpact::from(event))?,
            (None, _) => {}
        }
        core.line(lines, event.time_s, Severity::Info, event.site.name(), &event_text(event))?;
        match self.grasp.change(event) {
            Some(text) => core.line(lines, event.time_s, Severity::Info, "grasp", &text),
            None => Ok(()),
        }
    }
}

impl<W: Write> Sink for Writer<W> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.take(sample)
    }

    fn extreme(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.take(sample)
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.take_event(event)
    }
}

/// Which phalanges press.
#[derive(Clone, Copy, Debug, Default)]
struct Grasp {
    pressed: [bool; 2],
}

impl Grasp {
    /// What an event means for the grasp, if anything.
    fn change(&mut self, event: &Event) -> Option<String> {
        let held = self.pressed == [true; 2];
        match event.site {
            Site::Proximal => self.pressed[0] = event.kind != EventKind::LiftOff,
            Site::Distal => self.pressed[1] = event.kind != EventKind::LiftOff,
            Site::Limit => return None,
        }
        let time_ms = event.time_s * 1e3;
        match (held, self.pressed == [true; 2]) {
            (false, true) => Some(format!("both phalanges hold the object from {time_ms:.6} ms")),
            (true, false) => Some(format!("no longer held by both phalanges from {time_ms:.6} ms")),
            _ => None,
        }
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
