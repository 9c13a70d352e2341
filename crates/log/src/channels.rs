//! Channels of a log: their topics, which part of a sample each one contains, and the writer of their messages.

use std::io::Write;

use foxglove::Encode;
use foxglove::messages::{Log, log::Level};

use super::lines::{GraspState, describe_event};
use super::messages::{
    CONTACT, DISC, ENERGY, IMPACT, LIMIT, LIMIT_IMPACT, MessageType, SLIP, STATE, contact_numbers, disc_numbers,
    event_flags, limit_numbers, state_numbers,
};
use super::pictures::Pictures;
use super::writer::{ChannelId, LogWriter};
use phalanx_core::drawing::{self, Drawing};
use phalanx_core::scene::{self, Scene, System};
use phalanx_core::trace::{BodyState, Channels as _, Event, FingerState, Layout, Sample, SinkError};

/// Content of a channel. Indices are those of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelContent {
    Finger(usize),
    Body(usize),
    Contact(usize),
    /// A contact whose gap is an angle.
    Limit(usize),
    Impact(usize),
    LimitImpact(usize),
    Slip(usize),
    Energy,
    /// Event lines, or the whole run.
    Lines,
    /// 3-D view, derived from the other channels.
    Picture,
}

impl ChannelContent {
    /// Type of the messages; `None` for messages of Foxglove.
    pub fn message_type(self) -> Option<&'static MessageType> {
        match self {
            ChannelContent::Finger(_) => Some(&STATE),
            ChannelContent::Body(_) => Some(&DISC),
            ChannelContent::Contact(_) => Some(&CONTACT),
            ChannelContent::Limit(_) => Some(&LIMIT),
            ChannelContent::Impact(_) => Some(&IMPACT),
            ChannelContent::LimitImpact(_) => Some(&LIMIT_IMPACT),
            ChannelContent::Slip(_) => Some(&SLIP),
            ChannelContent::Energy => Some(&ENERGY),
            ChannelContent::Lines | ChannelContent::Picture => None,
        }
    }

    /// Index of the contact that the channel is about.
    pub fn contact(self) -> Option<usize> {
        match self {
            ChannelContent::Contact(index)
            | ChannelContent::Limit(index)
            | ChannelContent::Impact(index)
            | ChannelContent::LimitImpact(index)
            | ChannelContent::Slip(index) => Some(index),
            _ => None,
        }
    }

    /// Index of the component of a sample that the channel contains: fingers, bodies, contacts, energies.
    pub fn component(self, layout: &Layout) -> Option<usize> {
        let (fingers, bodies) = (layout.fingers.len(), layout.bodies.len());
        match self {
            ChannelContent::Finger(index) => Some(index),
            ChannelContent::Body(index) => Some(fingers + index),
            ChannelContent::Contact(index) | ChannelContent::Limit(index) => Some(fingers + bodies + index),
            ChannelContent::Energy => Some(fingers + bodies + layout.contacts.len()),
            _ => None,
        }
    }
}

/// Returns topic and content of the channels with figures, in the order of their registration, which the bytes of
/// existing logs depend on. `contacts` tells for each contact whether it has a slip channel; `None`: it does not exist.
pub fn channel_list(layout: &Layout, contacts: &[Option<bool>]) -> Vec<(String, ChannelContent)> {
    let is_single_finger = layout.fingers.len() == 1;
    let finger_topic = |name: &String| if name.is_empty() { "/state".to_string() } else { format!("/state/{name}") };
    let folder = if layout.fingers.is_empty() { "/disc/" } else { "/" };
    let fingers = layout.fingers.iter().enumerate().map(|(k, name)| (finger_topic(name), ChannelContent::Finger(k)));
    let bodies = layout.bodies.iter().enumerate().map(|(k, name)| (format!("{folder}{name}"), ChannelContent::Body(k)));
    let mut list: Vec<_> = fingers.chain(bodies).collect();
    let present = layout.contacts.iter().zip(contacts).enumerate().filter_map(|(k, (contact, has_slip))| {
        let name = &contact.name;
        let (samples, impact) = match contact.is_angular {
            false => ((format!("/contact/{name}"), ChannelContent::Contact(k)), ChannelContent::Impact(k)),
            true => {
                let topic = name.strip_suffix("_limit").map_or("/limit".to_string(), |side| format!("/limit/{side}"));
                ((topic, ChannelContent::Limit(k)), ChannelContent::LimitImpact(k))
            }
        };
        let slip = (*has_slip)?.then(|| (format!("/slip/{name}"), ChannelContent::Slip(k)));
        Some((samples, [Some((format!("/impact/{name}"), impact)), slip]))
    });
    let energy = ("/energy".to_string(), ChannelContent::Energy);
    // For a single finger, all samples come before all events.
    if is_single_finger {
        let (samples, events): (Vec<_>, Vec<_>) = present.unzip();
        list.extend(samples.into_iter().chain([energy]).chain(events.into_iter().flatten().flatten()));
    } else {
        let contacts = present.flat_map(|(samples, events)| [Some(samples)].into_iter().chain(events).flatten());
        list.extend(contacts.chain([energy]));
    }
    list
}

/// Returns for each contact of a system's samples whether it has a slip channel, which only friction with stiction has;
/// `None` for a contact that the scene does not have.
pub fn contacts_of(system: &System) -> Vec<Option<bool>> {
    let gripper_contacts = system.gripper_contacts();
    let of_gripper = gripper_contacts.iter().map(|&id| system.has_contact(id).then(|| system.bristle(id).is_some()));
    let others = system.contact_ids().into_iter().skip(gripper_contacts.len()).map(|id| {
        let (_, friction) = system.contact_laws(id)?;
        Some(friction.is_some_and(|friction| friction.bristle.is_some()))
    });
    of_gripper.chain(others).collect()
}

/// Writer of the channels of a run.
pub struct Channels {
    list: Vec<(ChannelId, ChannelContent)>,
    layout: Layout,
    /// Contacts drawn in pictures.
    drawn_contacts: Vec<usize>,
    pictures: Option<Pictures>,
    /// Grasp state; `None` unless the scene is a single finger.
    grasp: Option<GraspState>,
    /// Channel of the event lines.
    pub lines: ChannelId,
    /// Scene whose bodies are drawn.
    scene: Scene,
}

impl Channels {
    /// Registers the channels when a log starts.
    pub fn register<W: Write>(out: &mut LogWriter<W>, scene: &Scene) -> Result<Self, SinkError> {
        let system = &scene.system;
        let (layout, contacts) = (Layout::from_system(system), contacts_of(system));
        let mut list = Vec::new();
        for (topic, content) in channel_list(&layout, &contacts) {
            let schema = content.message_type().map(MessageType::schema);
            list.push((out.register(&topic, schema)?, content));
        }
        let start = Sample {
            fingers: vec![FingerState::default(); system.fingers.len()],
            bodies: system.reported_discs().iter().map(initial_state).collect(),
            ..Sample::default()
        };
        let pictures =
            Pictures::register(out, &Drawing::from_scene(scene), &drawing::poses(scene, &start), scene.log.picture_hz)?;
        let lines = out.register("/events", Log::get_schema())?;
        let drawn_contacts = layout.surfaces().filter(|&contact| contacts[contact].is_some()).collect();
        let grasp = (system.fingers.len() == 1).then(GraspState::default);
        Ok(Channels { list, layout, drawn_contacts, pictures, grasp, lines, scene: scene.clone() })
    }

    /// Writes a sample.
    pub fn sample<W: Write>(&mut self, out: &mut LogWriter<W>, sample: &Sample) -> Result<(), SinkError> {
        let Sample { time_s, fingers, bodies, contacts, energy } = sample;
        for (channel, content) in &self.list {
            let numbers: &[f64] = match *content {
                ChannelContent::Finger(index) => &state_numbers(&fingers[index]),
                ChannelContent::Body(index) => &disc_numbers(&bodies[index]),
                ChannelContent::Contact(index) => &contact_numbers(&contacts[index]),
                ChannelContent::Limit(index) => &limit_numbers(&contacts[index]),
                ChannelContent::Energy => &energy.values(),
                _ => continue,
            };
            out.write_numbers(*channel, *time_s, &[], numbers)?;
        }
        let Some(pictures) = &mut self.pictures else { return Ok(()) };
        let poses = || drawing::poses(&self.scene, sample);
        pictures.sample(out, *time_s, poses, self.drawn_contacts.iter().map(|&contact| &contacts[contact]))
    }

    /// Writes an event as a message and as text.
    pub fn event<W: Write>(&mut self, out: &mut LogWriter<W>, event: &Event) -> Result<(), SinkError> {
        let about_contact = || self.list.iter().filter(|(_, content)| content.contact() == Some(event.contact));
        if about_contact().next().is_some() {
            let is_friction = event.kind.is_friction_event();
            for (channel, content) in about_contact() {
                let numbers: &[f64] = match content {
                    ChannelContent::Slip(_) if is_friction => &[],
                    ChannelContent::Impact(_) | ChannelContent::LimitImpact(_) if !is_friction => {
                        &[event.approach_speed, event.impulse]
                    }
                    _ => continue,
                };
                out.write_numbers(*channel, event.time_s, event_flags(event.kind), numbers)?;
            }
            let contact = &self.layout.contacts[event.contact];
            let display_name = match event.contact < self.scene.system.gripper_contacts().len() {
                true => display_name(&contact.name),
                false => contact.name.clone(),
            };
            let text = describe_event(event, &display_name, contact.is_angular);
            out.write_line(self.lines, event.time_s, Level::Info, &contact.name, &text)?;
        }
        match self.grasp.as_mut().and_then(|grasp| grasp.update(event)) {
            Some(text) => out.write_line(self.lines, event.time_s, Level::Info, "grasp", &text),
            None => Ok(()),
        }
    }
}

fn initial_state(disc: &scene::Disc) -> BodyState {
    BodyState { centre_m: disc.centre_m, angle_rad: disc.angle_rad, ..BodyState::default() }
}

/// Name of a contact of a finger, the palm or the table in the text of event lines.
fn display_name(name: &str) -> String {
    match name.rsplit('_').next() {
        Some("palm" | "table") => format!("object on the {name}"),
        Some("limit") => name.replace('_', " ").replace("limit", "joint limit"),
        _ => format!("{} phalanx", name.replace('_', " ")),
    }
}
