//! Channels of a log: which ones a scene needs and which part of a sample each one contains.

use std::io::Write;

use mcap::McapError;

use super::lines::{GraspState, describe_event};
use super::mcap_writer::{ChannelId, McapWriter, Severity};
use super::messages::{Contact, Disc, Energy, Impact, Limit, LimitImpact, Slip, State};
use super::pictures::Pictures;
use phalanx_core::drawing::{self, Drawing};
use phalanx_core::law::Bristle;
use phalanx_core::scene::{self, GripperContact, Scene, Side, System};
use phalanx_core::trace::{BodyState, Event, FingerContact, FingerState, Sample};

/// Channels of a log: one per finger and body, two or three per contact.
pub struct Channels {
    fingers: Vec<ChannelId>,
    bodies: Vec<ChannelId>,
    /// Channels in the order of a sample's contacts; `None` for a contact that the scene does not have.
    contacts: Vec<Option<ContactChannels>>,
    energy: ChannelId,
    pictures: Option<Pictures>,
    /// Grasp state; `None` unless the scene is a single finger.
    grasp: Option<GraspState>,
    /// Scene whose bodies are drawn.
    scene: Scene,
}

struct ContactChannels {
    /// Name in topics and as the source of event lines.
    name: String,
    /// Name in the text of event lines.
    display_name: String,
    /// Whether the gap is an angle.
    angular: bool,
    contact: ChannelId,
    impact: ChannelId,
    /// Slip channel; `None` for friction without stiction.
    slip: Option<ChannelId>,
}

/// Registers the slip channel of a contact if its friction has stiction.
fn register_slip<W: Write>(
    out: &mut McapWriter<W>,
    name: &str,
    bristle: Option<Bristle>,
) -> Result<Option<ChannelId>, McapError> {
    bristle.map(|_| out.register_channel::<Slip>(&format!("/slip/{name}"))).transpose()
}

impl Channels {
    /// Registers the channels when a log starts. Their order is fixed: the bytes of existing logs depend on it.
    pub fn register<W: Write>(out: &mut McapWriter<W>, scene: &Scene) -> Result<Self, McapError> {
        let system = &scene.system;
        let is_single_finger = system.fingers.len() == 1;
        let topics = topics(system);
        let fingers =
            topics.fingers.iter().map(|topic| out.register_channel::<State>(topic)).collect::<Result<_, _>>()?;
        let bodies = topics.bodies.iter().map(|topic| out.register_channel::<Disc>(topic)).collect::<Result<_, _>>()?;
        let descriptions = describe_contacts(system);
        let mut contacts = Vec::with_capacity(descriptions.len());
        // For a single finger, all contact sample channels and the energy channel come first.
        let mut early_channels = Vec::new();
        let mut energy = None;
        if is_single_finger {
            for description in descriptions.iter().flatten() {
                early_channels.push(description.register_samples(out)?);
            }
            energy = Some(out.register_channel::<Energy>("/energy")?);
        }
        let mut early_channels = early_channels.into_iter();
        for description in descriptions {
            let Some(description) = description else {
                contacts.push(None);
                continue;
            };
            let contact = early_channels.next().map_or_else(|| description.register_samples(out), Ok)?;
            let topic = format!("/impact/{}", description.name);
            let impact = if description.angular {
                out.register_channel::<LimitImpact>(&topic)
            } else {
                out.register_channel::<Impact>(&topic)
            }?;
            let slip = register_slip(out, &description.name, description.bristle)?;
            let ContactDescription { name, display_name, angular, .. } = description;
            contacts.push(Some(ContactChannels { name, display_name, angular, contact, impact, slip }));
        }
        let energy = energy.map_or_else(|| out.register_channel::<Energy>("/energy"), Ok)?;
        let start = Sample {
            fingers: vec![FingerState::default(); system.fingers.len()],
            bodies: system.reported_discs().iter().map(initial_state).collect(),
            ..Sample::default()
        };
        let pictures =
            Pictures::register(out, &Drawing::from_scene(scene), &drawing::poses(scene, &start), scene.log.picture_hz)?;
        let grasp = is_single_finger.then(GraspState::default);
        Ok(Channels { fingers, bodies, contacts, energy, pictures, grasp, scene: scene.clone() })
    }

    /// Writes a sample.
    pub fn sample<W: Write>(&mut self, out: &mut McapWriter<W>, sample: &Sample) -> Result<(), McapError> {
        let Sample { time_s, fingers, bodies, contacts, energy } = sample;
        let log_time = out.log_time_ns(*time_s);
        for (channel, finger) in self.fingers.iter().zip(fingers) {
            out.write_message(*channel, log_time, &State::new(*time_s, finger))?;
        }
        for (channel, body) in self.bodies.iter().zip(bodies) {
            out.write_message(*channel, log_time, &Disc::new(*time_s, body))?;
        }
        for (channels, contact) in self.contacts.iter().zip(contacts) {
            match channels {
                Some(ids) if ids.angular => out.write_message(ids.contact, log_time, &Limit::new(*time_s, contact))?,
                Some(ids) => out.write_message(ids.contact, log_time, &Contact::new(*time_s, contact))?,
                None => {}
            }
        }
        out.write_message(self.energy, log_time, &Energy::new(*time_s, energy))?;
        let Some(pictures) = &mut self.pictures else { return Ok(()) };
        let drawn_contacts = self.contacts.iter().zip(contacts).filter_map(|(channels, contact)| {
            let has_surfaces = channels.as_ref().is_some_and(|channels| !channels.angular);
            has_surfaces.then_some(contact)
        });
        let poses = || drawing::poses(&self.scene, sample);
        pictures.sample(out, *time_s, poses, drawn_contacts)
    }

    /// Writes an event as a message and as text on the channel `lines`.
    pub fn event<W: Write>(
        &mut self,
        out: &mut McapWriter<W>,
        lines: ChannelId,
        event: &Event,
    ) -> Result<(), McapError> {
        let log_time = out.log_time_ns(event.time_s);
        if let Some(channels) = &self.contacts[event.contact] {
            match channels.angular {
                _ if event.kind.is_friction_event() => {
                    channels.slip.map_or(Ok(()), |slip| out.write_message(slip, log_time, &Slip::from(event)))?;
                }
                false => out.write_message(channels.impact, log_time, &Impact::from(event))?,
                true => out.write_message(channels.impact, log_time, &LimitImpact::from(event))?,
            }
            let text = describe_event(event, &channels.display_name, channels.angular);
            out.write_line(lines, event.time_s, Severity::Info, &channels.name, &text)?;
        }
        match self.grasp.as_mut().and_then(|grasp| grasp.update(event)) {
            Some(text) => out.write_line(lines, event.time_s, Severity::Info, "grasp", &text),
            None => Ok(()),
        }
    }
}

fn initial_state(disc: &scene::Disc) -> BodyState {
    BodyState { centre_m: disc.centre_m, angle_rad: disc.angle_rad, ..BodyState::default() }
}

/// Names, topic and friction of a contact.
struct ContactDescription {
    name: String,
    display_name: String,
    /// Topic of the contact samples.
    topic: String,
    angular: bool,
    bristle: Option<Bristle>,
}

impl ContactDescription {
    fn register_samples<W: Write>(&self, out: &mut McapWriter<W>) -> Result<ChannelId, McapError> {
        if self.angular {
            out.register_channel::<Limit>(&self.topic)
        } else {
            out.register_channel::<Contact>(&self.topic)
        }
    }
}

/// Topics of a log by content, in the order of a sample.
pub struct Topics {
    pub fingers: Vec<String>,
    pub bodies: Vec<String>,
    /// `None` for a contact that the scene does not have.
    pub contacts: Vec<Option<ContactTopics>>,
}

/// Topics of one contact.
pub struct ContactTopics {
    pub samples: String,
    pub impact: String,
    /// Topic of the slip; `None` for friction without stiction.
    pub slip: Option<String>,
}

/// Returns the topics in the log of a system.
pub fn topics(system: &System) -> Topics {
    let is_single_finger = system.fingers.len() == 1;
    let finger = |side: Side| if is_single_finger { "/state".to_string() } else { format!("/state/{}", side.name()) };
    let folder = if system.fingers.is_empty() { "/disc/" } else { "/" };
    let contact = |description: ContactDescription| ContactTopics {
        impact: format!("/impact/{}", description.name),
        slip: description.bristle.map(|_| format!("/slip/{}", description.name)),
        samples: description.topic,
    };
    Topics {
        fingers: system.fingers_by_side().map(|(side, _)| finger(side)).collect(),
        bodies: system.reported_discs().iter().map(|disc| format!("{folder}{}", disc.name)).collect(),
        contacts: describe_contacts(system).into_iter().map(|description| description.map(contact)).collect(),
    }
}

/// Descriptions in the order of a sample's contacts; `None` for a contact that the scene does not have.
fn describe_contacts(system: &System) -> Vec<Option<ContactDescription>> {
    let gripper_contacts = system.gripper_contacts().iter().map(|contact| describe_contact(system, *contact));
    let other_contacts = system.contact_ids().into_iter().skip(system.gripper_contacts().len()).map(|id| {
        let (_, friction) = system.contact_laws(id)?;
        let name = system.contact_name(id);
        let topic = format!("/contact/{name}");
        let bristle = friction.and_then(|friction| friction.bristle);
        Some(ContactDescription { display_name: name.clone(), name, topic, angular: false, bristle })
    });
    gripper_contacts.chain(other_contacts).collect()
}

fn describe_contact(system: &System, contact: GripperContact) -> Option<ContactDescription> {
    let name = system.gripper_contact_name(contact);
    let side_prefix = |side: Side| if system.fingers.len() == 1 { String::new() } else { format!("{} ", side.name()) };
    let display_name = match contact {
        GripperContact::Finger(side, FingerContact::Proximal) => side_prefix(side) + "proximal phalanx",
        GripperContact::Finger(side, FingerContact::Distal) => side_prefix(side) + "distal phalanx",
        GripperContact::Finger(side, FingerContact::Limit) => side_prefix(side) + "joint limit",
        GripperContact::Palm | GripperContact::Table => format!("object on the {name}"),
    };
    let topic = match contact {
        GripperContact::Finger(side, FingerContact::Limit) if system.fingers.len() > 1 => {
            format!("/limit/{}", side.name())
        }
        GripperContact::Finger(_, FingerContact::Limit) => "/limit".to_string(),
        _ => format!("/contact/{name}"),
    };
    system.has_contact(contact).then(|| ContactDescription {
        name,
        display_name,
        topic,
        angular: contact.is_stop(),
        bristle: system.bristle(contact),
    })
}
