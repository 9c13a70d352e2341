//! Content of the channels of a log, determined from schema and topic.

use std::collections::HashMap;

use foxglove::Encode;
use foxglove::messages::{FrameTransforms, Log, SceneUpdate};

use super::record::{ChannelRecord, SchemaRecord};
use crate::messages::{Contact, Disc, Energy, Impact, Limit, LimitImpact, Slip, State};
use crate::schema::current_name;
use phalanx_core::scene::keywords::SceneKind;
use phalanx_core::scene::{self, Side};
use phalanx_core::trace::{ContactChannel, FingerContact, Layout};

/// Content of a channel. Indices are those of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChannelContent {
    Finger(usize),
    Body(usize),
    Contact(usize),
    /// A contact whose gap is an angle.
    Limit(usize),
    Impact(usize),
    Slip(usize),
    Energy,
    Lines,
    /// 3-D view, derived from the other channels.
    Picture,
}

/// Returns the index of a component of a sample: fingers, bodies, contacts, energies.
pub fn component_index(layout: &Layout, content: ChannelContent) -> Option<usize> {
    let (fingers, bodies) = (layout.fingers.len(), layout.bodies.len());
    match content {
        ChannelContent::Finger(index) => Some(index),
        ChannelContent::Body(index) => Some(fingers + index),
        ChannelContent::Contact(index) | ChannelContent::Limit(index) => Some(fingers + bodies + index),
        ChannelContent::Energy => Some(fingers + bodies + layout.contacts.len()),
        ChannelContent::Impact(_) | ChannelContent::Slip(_) | ChannelContent::Lines | ChannelContent::Picture => None,
    }
}

/// Known schemas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Schema {
    State,
    Contact,
    Limit,
    Energy,
    Impact,
    LimitImpact,
    Slip,
    Disc,
    Log,
    Picture,
}

/// Channels found so far.
pub struct Channels {
    /// Kind of the logged scene.
    kind: SceneKind,
    known: Vec<(String, Schema)>,
    schemas: HashMap<u16, Schema>,
    content_by_channel: HashMap<u16, Option<ChannelContent>>,
    /// Id, topic and content of every known channel, in file order.
    topics: Vec<(u16, String, ChannelContent)>,
    layout: Layout,
}

impl Channels {
    /// Creates the channels for a kind of scene; `layout` is the known part of the layout of the samples.
    pub fn new(kind: SceneKind, layout: Layout) -> Self {
        let known = [
            (State::get_schema(), Schema::State),
            (Contact::get_schema(), Schema::Contact),
            (Limit::get_schema(), Schema::Limit),
            (Energy::get_schema(), Schema::Energy),
            (Impact::get_schema(), Schema::Impact),
            (LimitImpact::get_schema(), Schema::LimitImpact),
            (Slip::get_schema(), Schema::Slip),
            (Disc::get_schema(), Schema::Disc),
            (Log::get_schema(), Schema::Log),
            (FrameTransforms::get_schema(), Schema::Picture),
            (SceneUpdate::get_schema(), Schema::Picture),
        ];
        Channels {
            kind,
            known: known
                .into_iter()
                .filter_map(|(schema, kind)| Some((current_name(&schema?.name).into_owned(), kind)))
                .collect(),
            schemas: HashMap::new(),
            content_by_channel: HashMap::new(),
            topics: Vec::new(),
            layout,
        }
    }

    /// Adds a schema; unknown ones are ignored.
    pub fn schema(&mut self, schema: &SchemaRecord<'_>) {
        let current = current_name(schema.name);
        let known = self.known.iter().find(|(name, _)| schema.encoding == "protobuf" && *name == current);
        if let Some(&(_, found)) = known {
            self.schemas.insert(schema.id, found);
        }
    }

    /// Adds a channel; returns `true` if it is new and unknown.
    pub fn channel(&mut self, channel: &ChannelRecord<'_>) -> bool {
        let schema = self.schemas.get(&channel.schema).copied().filter(|_| channel.encoding == "protobuf");
        let content = schema.and_then(|schema| match self.kind {
            SceneKind::Finger => finger_content(schema, channel.topic),
            SceneKind::Bodies => self.disc_scene_content(schema, channel.topic),
            SceneKind::Gripper => gripper_content(schema, channel.topic),
        });
        let topic = channel.topic.to_string();
        self.topics.extend(content.map(|content| (channel.id, topic, content)));
        self.content_by_channel.insert(channel.id, content).is_none() && content.is_none()
    }

    /// Returns id, topic and content of the known channels.
    pub fn topics(&self) -> &[(u16, String, ChannelContent)] {
        &self.topics
    }

    pub fn content(&self, channel: u16) -> Option<ChannelContent> {
        self.content_by_channel.get(&channel).copied().flatten()
    }

    /// Layout of the samples.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    fn disc_scene_content(&mut self, schema: Schema, topic: &str) -> Option<ChannelContent> {
        let Layout { bodies, contacts, .. } = &mut self.layout;
        let mut pair = |topic: &str, prefix: &str| {
            let name = topic.strip_prefix(prefix).filter(|name| is_valid_pair(name))?;
            let new_contact = || ContactChannel { name: name.to_string(), is_angular: false };
            Some(find_or_insert(contacts, |known| known.name == name, new_contact))
        };
        match schema {
            Schema::Disc => {
                let name = topic.strip_prefix("/disc/").filter(|name| is_valid_name(name))?;
                Some(ChannelContent::Body(find_or_insert(bodies, |known| known == name, || name.to_string())))
            }
            Schema::Contact => pair(topic, "/contact/").map(ChannelContent::Contact),
            Schema::Impact => pair(topic, "/impact/").map(ChannelContent::Impact),
            Schema::Slip => pair(topic, "/slip/").map(ChannelContent::Slip),
            _ => common_content(schema, topic),
        }
    }
}

/// Returns the index of the matching element, appending a new one if necessary.
fn find_or_insert<T>(all: &mut Vec<T>, matches: impl Fn(&T) -> bool, new: impl Fn() -> T) -> usize {
    all.iter().position(matches).unwrap_or_else(|| {
        all.push(new());
        all.len() - 1
    })
}

fn finger_content(schema: Schema, topic: &str) -> Option<ChannelContent> {
    match (schema, topic) {
        (Schema::State, "/state") => Some(ChannelContent::Finger(0)),
        (Schema::Contact, "/contact/proximal") => Some(ChannelContent::Contact(FingerContact::Proximal as usize)),
        (Schema::Contact, "/contact/distal") => Some(ChannelContent::Contact(FingerContact::Distal as usize)),
        (Schema::Limit, "/limit") => Some(ChannelContent::Limit(FingerContact::Limit as usize)),
        (Schema::Impact, "/impact/proximal") => Some(ChannelContent::Impact(FingerContact::Proximal as usize)),
        (Schema::Impact, "/impact/distal") => Some(ChannelContent::Impact(FingerContact::Distal as usize)),
        (Schema::LimitImpact, "/impact/limit") => Some(ChannelContent::Impact(FingerContact::Limit as usize)),
        (Schema::Slip, "/slip/proximal") => Some(ChannelContent::Slip(FingerContact::Proximal as usize)),
        (Schema::Slip, "/slip/distal") => Some(ChannelContent::Slip(FingerContact::Distal as usize)),
        _ => common_content(schema, topic),
    }
}

fn gripper_content(schema: Schema, topic: &str) -> Option<ChannelContent> {
    let side = |prefix: &str| {
        let side_name = topic.strip_prefix(prefix)?;
        Side::BOTH.into_iter().find(|side| side.name() == side_name)
    };
    let contact_index = |prefix: &str, stop: bool| {
        let name = topic.strip_prefix(prefix)?;
        scene::GripperContact::ALL.into_iter().position(|contact| contact.is_stop() == stop && contact.name() == name)
    };
    match schema {
        Schema::State => side("/state/").map(|side| ChannelContent::Finger(side as usize)),
        Schema::Disc => (topic == "/object").then_some(ChannelContent::Body(0)),
        Schema::Contact => contact_index("/contact/", false).map(ChannelContent::Contact),
        Schema::Limit => {
            let stop = scene::GripperContact::Finger(side("/limit/")?, FingerContact::Limit);
            scene::GripperContact::ALL.into_iter().position(|contact| contact == stop).map(ChannelContent::Limit)
        }
        Schema::Impact => contact_index("/impact/", false).map(ChannelContent::Impact),
        Schema::LimitImpact => contact_index("/impact/", true).map(ChannelContent::Impact),
        Schema::Slip => contact_index("/slip/", false).map(ChannelContent::Slip),
        _ => common_content(schema, topic),
    }
}

fn common_content(schema: Schema, topic: &str) -> Option<ChannelContent> {
    match (schema, topic) {
        (Schema::Energy, "/energy") => Some(ChannelContent::Energy),
        (Schema::Log, "/events") => Some(ChannelContent::Lines),
        (Schema::Picture, _) => Some(ChannelContent::Picture),
        _ => None,
    }
}

/// Whether a name is valid for a disc in a scene. Other names could not become a column or a key.
fn is_valid_name(name: &str) -> bool {
    name.starts_with(|first: char| first.is_ascii_alphabetic())
        && name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}

fn is_valid_pair(name: &str) -> bool {
    name.split_once('-').is_some_and(|(disc, partner)| is_valid_name(disc) && is_valid_name(partner))
}
