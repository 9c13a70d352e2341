//! The channels of a log: those that a scene needs, and what of a sample goes into each.

use std::io::Write;

use mcap::McapError;

use super::core::{ChannelId, Core, Severity};
use super::lines::{Grasp, change};
use super::messages::{Contact, Disc, Energy, Impact, Limit, LimitImpact, Slip, State};
use super::pictures::Pictures;
use phalanx_core::drawing::{self, Drawing};
use phalanx_core::law::Bristle;
use phalanx_core::scene::{AnyScene, BodiesScene, GripperScene, Place, Scene, Side};
use phalanx_core::trace::{BodyState, Event, FingerState, Sample, Simulated, Site};

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
    scene: AnyScene,
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
    pub fn register<W: Write>(core: &mut Core<W>, scene: Simulated<'_>) -> Result<Self, McapError> {
        match scene {
            Simulated::Finger(finger) => of_finger(core, finger),
            Simulated::Discs(discs) => of_discs(core, discs),
            Simulated::Gripper(gripper) => of_gripper(core, gripper),
        }
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

fn of_finger<W: Write>(core: &mut Core<W>, scene: &Scene) -> Result<Channels, McapError> {
    let fingers = vec![core.channel::<State>("/state")?];
    let there = |site: Site| if site == Site::Limit { scene.limit.is_some() } else { scene.object.is_some() };
    let mut samples = [None; Site::ALL.len()];
    for site in Site::ALL.into_iter().filter(|site| there(*site)) {
        samples[site as usize] = Some(match site {
            Site::Proximal | Site::Distal => core.channel::<Contact>(&format!("/contact/{}", site.name()))?,
            Site::Limit => core.channel::<Limit>("/limit")?,
        });
    }
    let energy = core.channel::<Energy>("/energy")?;
    let mut contacts = Vec::new();
    for site in Site::ALL {
        let Some(contact) = samples[site as usize] else {
            contacts.push(None);
            continue;
        };
        let (topic, angular) = (format!("/impact/{}", site.name()), site == Site::Limit);
        let impact = if angular { core.channel::<LimitImpact>(&topic) } else { core.channel::<Impact>(&topic) }?;
        let called = match site {
            Site::Proximal => "proximal phalanx",
            Site::Distal => "distal phalanx",
            Site::Limit => "joint limit",
        };
        let (name, called) = (site.name().to_string(), called.to_string());
        let slip = slip(core, &name, scene.bristle(site))?;
        contacts.push(Some(ContactChannels { name, called, angular, contact, impact, slip }));
    }
    let pictures = pictures(core, scene, &Sample::of_finger(), scene.log.picture_hz)?;
    let (grasp, scene) = (Some(Grasp::default()), AnyScene::Finger(Box::new(scene.clone())));
    Ok(Channels { fingers, bodies: Vec::new(), contacts, energy, pictures, grasp, scene })
}

fn of_gripper<W: Write>(core: &mut Core<W>, scene: &GripperScene) -> Result<Channels, McapError> {
    let mut fingers = Vec::with_capacity(Side::BOTH.len());
    for side in Side::BOTH {
        fingers.push(core.channel::<State>(&format!("/state/{}", side.word()))?);
    }
    let bodies = vec![core.channel::<Disc>("/object")?];
    let mut contacts = Vec::new();
    for place in Place::ALL {
        let there = match place {
            Place::Finger(side, Site::Limit) => scene.finger(side).limit.is_some(),
            Place::Finger(..) => true,
            Place::Palm => scene.palm.is_some(),
            Place::Table => scene.table.is_some(),
        };
        if !there {
            contacts.push(None);
            continue;
        }
        let (name, angular) = (place.name(), place.is_stop());
        let contact = match place {
            Place::Finger(side, Site::Limit) => core.channel::<Limit>(&format!("/limit/{}", side.word()))?,
            _ => core.channel::<Contact>(&format!("/contact/{name}"))?,
        };
        let topic = format!("/impact/{name}");
        let impact = if angular { core.channel::<LimitImpact>(&topic) } else { core.channel::<Impact>(&topic) }?;
        let called = match place {
            Place::Finger(side, Site::Proximal) => format!("{} proximal phalanx", side.word()),
            Place::Finger(side, Site::Distal) => format!("{} distal phalanx", side.word()),
            Place::Finger(side, Site::Limit) => format!("{} joint limit", side.word()),
            Place::Palm | Place::Table => format!("object on the {name}"),
        };
        let slip = slip(core, &name, scene.bristle(place))?;
        contacts.push(Some(ContactChannels { name, called, angular, contact, impact, slip }));
    }
    let energy = core.channel::<Energy>("/energy")?;
    let object =
        BodyState { centre_m: scene.object.centre_m, angle_rad: scene.object.angle_rad, ..BodyState::default() };
    let start = Sample { fingers: vec![FingerState::default(); 2], bodies: vec![object], ..Sample::default() };
    let pictures = pictures(core, scene, &start, scene.log.picture_hz)?;
    let scene = AnyScene::Gripper(Box::new(scene.clone()));
    Ok(Channels { fingers, bodies, contacts, energy, pictures, grasp: None, scene })
}

fn of_discs<W: Write>(core: &mut Core<W>, scene: &BodiesScene) -> Result<Channels, McapError> {
    let mut bodies = Vec::with_capacity(scene.discs.len());
    for disc in &scene.discs {
        bodies.push(core.channel::<Disc>(&format!("/disc/{}", disc.name))?);
    }
    let mut contacts = Vec::new();
    for pair in scene.pairs() {
        let name = scene.pair_name(pair);
        let contact = core.channel::<Contact>(&format!("/contact/{name}"))?;
        let impact = core.channel::<Impact>(&format!("/impact/{name}"))?;
        let slip = slip(core, &name, scene.contact.bristle())?;
        contacts.push(Some(ContactChannels { called: name.clone(), name, angular: false, contact, impact, slip }));
    }
    let energy = core.channel::<Energy>("/energy")?;
    let at_start = scene.discs.iter().map(|disc| BodyState { centre_m: disc.centre_m, ..BodyState::default() });
    let start = Sample { bodies: at_start.collect(), ..Sample::default() };
    let pictures = pictures(core, scene, &start, scene.log.picture_hz)?;
    let scene = AnyScene::Bodies(Box::new(scene.clone()));
    Ok(Channels { fingers: Vec::new(), bodies, contacts, energy, pictures, grasp: None, scene })
}

fn pictures<'a, W: Write>(
    core: &mut Core<W>,
    scene: impl Into<Simulated<'a>>,
    start: &Sample,
    picture_hz: f64,
) -> Result<Option<Pictures>, McapError> {
    let scene = scene.into();
    Pictures::register(core, &Drawing::of(scene), &drawing::poses(scene, start), picture_hz)
}
