//! Channels of a log: their topics, and which part of a sample each one contains.

use super::messages::{CONTACT, DISC, ENERGY, IMPACT, LIMIT, LIMIT_IMPACT, MessageType, SLIP, STATE};
use phalanx_core::scene::System;
use phalanx_core::trace::Layout;

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
    pub(crate) fn message_type(self) -> Option<&'static MessageType> {
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
pub(crate) fn channel_list(layout: &Layout, contacts: &[Option<bool>]) -> Vec<(String, ChannelContent)> {
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
pub(crate) fn contacts_of(system: &System) -> Vec<Option<bool>> {
    let gripper_contacts = system.gripper_contacts();
    let of_gripper = gripper_contacts.iter().map(|&id| system.has_contact(id).then(|| system.bristle(id).is_some()));
    let others = system.contact_ids().into_iter().skip(gripper_contacts.len()).map(|id| {
        let (_, friction) = system.contact_laws(id)?;
        Some(friction.is_some_and(|friction| friction.bristle.is_some()))
    });
    of_gripper.chain(others).collect()
}
