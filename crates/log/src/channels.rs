//! The channels of a log: those that a scene needs, and what of a sample goes into each.

use std::io::Write;

use mcap::McapError;

use super::core::{ChannelId, Core, Severity};
use super::lines::{Grasp, change};
use super::messages::{Contact, Disc, Energy, Impact, Limit, LimitImpact, Slip, State};
use super::pictures::Pictures;
use phalanx_core::drawing::{self, Drawing};
use phalanx_core::law::Bristle;
use phalanx_core::scene::{self, Place, Scene, Side, System};
use phalanx_core::trace::{BodyState, Event, FingerState, Sample, Site};

/// One channel for every finger and body, two for every contact.
pub struct Channels {
    fingers: Vec<ChannelId>,
    bodies: Vec<ChannelId>,
    /// In the order of a sample's contacts; `None` where there is nothing to touch.
    contacts: Vec<Option<ContactChannels>>,
    energy: ChannelId,
    pictures: Option<Pictures>,
    /// Of a finger.
    grasp: Option<Grasp>,
    /// Where its bodies are.
    scene: Scene,
}

struct ContactChannels {
    /// In topics and as the source of lines, and what lines call it.
    name: String,
    called: String,
    /// Whether its gap is an angle.
    angular: bool,
    contact: ChannelId,
    impact: ChannelId,
    /// Where friction holds.
    slip: Option<ChannelId>,
}

/// The channel of a contact's friction, where that holds.
fn slip<W: Write>(core: &mut Core<W>, name: &str, bristle: Option<Bristle>) -> Result<Option<ChannelId>, McapError> {
    bristle.map(|_| core.channel::<Slip>(&format!("/slip/{name}"))).transpose()
}

impl Channels {
    /// Registers the channels when a log starts. Their order is that of the bytes of every log there is.
    pub fn register<W: Write>(core: &mut Core<W>, scene: &Scene) -> Result<Self, McapError> {
        let system = &scene.system;
        let alone = system.fingers.len() == 1;
        let topics = topics(system);
        let fingers = topics.fingers.iter().map(|topic| core.channel::<State>(topic)).collect::<Result<_, _>>()?;
        let bodies = topics.bodies.iter().map(|topic| core.channel::<Disc>(topic)).collect::<Result<_, _>>()?;
        let surfaces = surfaces(system);
        let mut contacts = Vec::with_capacity(surfaces.len());
        // Of one finger all samples and the energy come first.
        let mut early = Vec::new();
        let mut energy = None;
        if alone {
            for surface in surfaces.iter().flatten() {
                early.push(surface.samples(core)?);
            }
            energy = Some(core.channel::<Energy>("/energy")?);
        }
        let mut early = early.into_iter();
        for surface in surfaces {
            let Some(surface) = surface else {
                contacts.push(None);
                continue;
            };
            let contact = early.next().map_or_else(|| surface.samples(core), Ok)?;
            let topic = format!("/impact/{}", surface.name);
            let impact =
                if surface.angular { core.channel::<LimitImpact>(&topic) } else { core.channel::<Impact>(&topic) }?;
            let slip = slip(core, &surface.name, surface.bristle)?;
            let Surface { name, called, angular, .. } = surface;
            contacts.push(Some(ContactChannels { name, called, angular, contact, impact, slip }));
        }
        let energy = energy.map_or_else(|| core.channel::<Energy>("/energy"), Ok)?;
        let start = Sample {
            fingers: vec![FingerState::default(); system.fingers.len()],
            bodies: system.told_discs().iter().map(at_start).collect(),
            ..Sample::default()
        };
        let pictures =
            Pictures::register(core, &Drawing::of(scene), &drawing::poses(scene, &start), scene.log.picture_hz)?;
        let grasp = alone.then(Grasp::default);
        Ok(Channels { fingers, bodies, contacts, energy, pictures, grasp, scene: scene.clone() })
    }

    /// Writes a sample.
    pub fn sample<W: Write>(&mut self, core: &mut Core<W>, sample: &Sample) -> Result<(), McapError> {
        let Sample { time_s, fingers, bodies, contacts, energy } = sample;
        let log_time = core.tick(*time_s);
        for (channel, finger) in self.fingers.iter().zip(fingers) {
            core.put(*channel, log_time, &State::new(*time_s, finger))?;
        }
        for (channel, body) in self.bodies.iter().zip(bodies) {
            core.put(*channel, log_time, &Disc::new(*time_s, body))?;
        }
        for (channels, contact) in self.contacts.iter().zip(contacts) {
            match channels {
                Some(to) if to.angular => core.put(to.contact, log_time, &Limit::new(*time_s, contact))?,
                Some(to) => core.put(to.contact, log_time, &Contact::new(*time_s, contact))?,
                None => {}
            }
        }
        core.put(self.energy, log_time, &Energy::new(*time_s, energy))?;
        let Some(pictures) = &mut self.pictures else { return Ok(()) };
        let drawn = self.contacts.iter().zip(contacts).filter_map(|(channels, contact)| {
            let surfaces = channels.as_ref().is_some_and(|channels| !channels.angular);
            surfaces.then_some(contact)
        });
        let poses = || drawing::poses(&self.scene, sample);
        pictures.sample(core, *time_s, poses, drawn)
    }

    /// Writes an event as figures, and as text on the channel `lines`.
    pub fn event<W: Write>(&mut self, core: &mut Core<W>, lines: ChannelId, event: &Event) -> Result<(), McapError> {
        let log_time = core.tick(event.time_s);
        if let Some(channels) = &self.contacts[event.contact] {
            match channels.angular {
                _ if event.kind.is_of_friction() => {
                    channels.slip.map_or(Ok(()), |slip| core.put(slip, log_time, &Slip::from(event)))?;
                }
                false => core.put(channels.impact, log_time, &Impact::from(event))?,
                true => core.put(channels.impact, log_time, &LimitImpact::from(event))?,
            }
            let text = change(event, &channels.called, channels.angular);
            core.line(lines, event.time_s, Severity::Info, &channels.name, &text)?;
        }
        match self.grasp.as_mut().and_then(|grasp| grasp.change(event)) {
            Some(text) => core.line(lines, event.time_s, Severity::Info, "grasp", &text),
            None => Ok(()),
        }
    }
}

fn at_start(disc: &scene::Disc) -> BodyState {
    BodyState { centre_m: disc.centre_m, angle_rad: disc.angle_rad, ..BodyState::default() }
}

/// What may press at a contact.
struct Surface {
    name: String,
    called: String,
    /// Of its samples.
    topic: String,
    angular: bool,
    bristle: Option<Bristle>,
}

impl Surface {
    fn samples<W: Write>(&self, core: &mut Core<W>) -> Result<ChannelId, McapError> {
        if self.angular { core.channel::<Limit>(&self.topic) } else { core.channel::<Contact>(&self.topic) }
    }
}

/// The topics of a log by what they carry, in the order of a sample.
pub struct Topics {
    pub fingers: Vec<String>,
    pub bodies: Vec<String>,
    /// `None` where there is nothing to touch.
    pub contacts: Vec<Option<ContactTopics>>,
}

/// The topics of one contact.
pub struct ContactTopics {
    pub samples: String,
    pub impact: String,
    /// Where friction holds.
    pub slip: Option<String>,
}

/// The topics that the log of a system has.
pub fn topics(system: &System) -> Topics {
    let alone = system.fingers.len() == 1;
    let finger = |side: Side| if alone { "/state".to_string() } else { format!("/state/{}", side.word()) };
    let folder = if system.fingers.is_empty() { "/disc/" } else { "/" };
    let contact = |surface: Surface| ContactTopics {
        impact: format!("/impact/{}", surface.name),
        slip: surface.bristle.map(|_| format!("/slip/{}", surface.name)),
        samples: surface.topic,
    };
    Topics {
        fingers: system.sided().map(|(side, _)| finger(side)).collect(),
        bodies: system.told_discs().iter().map(|disc| format!("{folder}{}", disc.name)).collect(),
        contacts: surfaces(system).into_iter().map(|surface| surface.map(contact)).collect(),
    }
}

/// In the order of a sample's contacts; `None` where there is nothing to touch.
fn surfaces(system: &System) -> Vec<Option<Surface>> {
    let places = system.places().iter().map(|place| surface(system, *place));
    let others = system.touching().into_iter().skip(system.places().len()).map(|touching| {
        let (_, friction) = system.laws(touching)?;
        let name = system.touching_name(touching);
        let topic = format!("/contact/{name}");
        let bristle = friction.and_then(|friction| friction.bristle);
        Some(Surface { called: name.clone(), name, topic, angular: false, bristle })
    });
    places.chain(others).collect()
}

fn surface(system: &System, place: Place) -> Option<Surface> {
    let name = system.place_name(place);
    let of_side = |side: Side| if system.fingers.len() == 1 { String::new() } else { format!("{} ", side.word()) };
    let called = match place {
        Place::Finger(side, Site::Proximal) => of_side(side) + "proximal phalanx",
        Place::Finger(side, Site::Distal) => of_side(side) + "distal phalanx",
        Place::Finger(side, Site::Limit) => of_side(side) + "joint limit",
        Place::Palm | Place::Table => format!("object on the {name}"),
    };
    let topic = match place {
        Place::Finger(side, Site::Limit) if system.fingers.len() > 1 => format!("/limit/{}", side.word()),
        Place::Finger(_, Site::Limit) => "/limit".to_string(),
        _ => format!("/contact/{name}"),
    };
    system.is_there(place).then(|| Surface {
        name,
        called,
        topic,
        angular: place.is_stop(),
        bristle: system.bristle(place),
    })
}
