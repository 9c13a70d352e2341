//! What the channels of a log carry, told by their schema and topic.

use std::collections::HashMap;

use foxglove::Encode;
use foxglove::messages::{FrameTransforms, Log, SceneUpdate};

use super::record::{ChannelRecord, SchemaRecord};
use crate::messages::{Contact, Disc, Energy, Impact, Limit, LimitImpact, Slip, State};
use crate::schema::current_name;
use phalanx_core::scene::words::SceneKind;
use phalanx_core::scene::{self, Side};
use phalanx_core::trace::{Layout, Place, Site};

/// What a channel carries. Indices are those of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carries {
    Finger(usize),
    Body(usize),
    Contact(usize),
    /// A contact whose gap is an angle.
    Stop(usize),
    Impact(usize),
    Slip(usize),
    Energy,
    Lines,
    /// What is drawn: it follows from the rest.
    Picture,
}

/// The places of the parts of a sample: fingers, bodies, contacts, energies.
pub fn part(layout: &Layout, carries: Carries) -> Option<usize> {
    let (fingers, bodies) = (layout.fingers.len(), layout.bodies.len());
    match carries {
        Carries::Finger(index) => Some(index),
        Carries::Body(index) => Some(fingers + index),
        Carries::Contact(index) | Carries::Stop(index) => Some(fingers + bodies + index),
        Carries::Energy => Some(fingers + bodies + layout.contacts.len()),
        Carries::Impact(_) | Carries::Slip(_) | Carries::Lines | Carries::Picture => None,
    }
}

/// The schemas of phalanx.
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

/// The channels that have been announced so far.
pub struct Channels {
    /// Of the scene of the log.
    kind: SceneKind,
    known: Vec<(String, Schema)>,
    schemas: HashMap<u16, Schema>,
    carried: HashMap<u16, Option<Carries>>,
    /// Topic of every channel that is known, in the order in which they were announced.
    topics: Vec<(u16, String, Carries)>,
    layout: Layout,
}

impl Channels {
    /// Of a log of this kind; `layout` is what its samples consist of as far as that is known.
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
                .filter_map(|(schema, of)| Some((current_name(&schema?.name).into_owned(), of)))
                .collect(),
            schemas: HashMap::new(),
            carried: HashMap::new(),
            topics: Vec::new(),
            layout,
        }
    }

    /// Takes note of a schema; one that is not of phalanx is forgotten.
    pub fn schema(&mut self, schema: &SchemaRecord<'_>) {
        let called = current_name(schema.name);
        let known = self.known.iter().find(|(name, _)| schema.encoding == "protobuf" && *name == called);
        if let Some(&(_, found)) = known {
            self.schemas.insert(schema.id, found);
        }
    }

    /// Takes note of a channel; true if it is new and unknown.
    pub fn channel(&mut self, channel: &ChannelRecord<'_>) -> bool {
        let schema = self.schemas.get(&channel.schema).copied().filter(|_| channel.encoding == "protobuf");
        let carries = schema.and_then(|schema| match self.kind {
            SceneKind::Finger => of_finger(schema, channel.topic),
            SceneKind::Bodies => self.of_discs(schema, channel.topic),
            SceneKind::Gripper => of_gripper(schema, channel.topic),
        });
        let topic = channel.topic.to_string();
        self.topics.extend(carries.map(|carries| (channel.id, topic, carries)));
        self.carried.insert(channel.id, carries).is_none() && carries.is_none()
    }

    /// Channels that are known, with their topics.
    pub fn topics(&self) -> &[(u16, String, Carries)] {
        &self.topics
    }

    pub fn carries(&self, channel: u16) -> Option<Carries> {
        self.carried.get(&channel).copied().flatten()
    }

    /// What samples consist of.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    fn of_discs(&mut self, schema: Schema, topic: &str) -> Option<Carries> {
        let Layout { bodies, contacts, .. } = &mut self.layout;
        let mut pair = |topic: &str, prefix: &str| {
            let name = topic.strip_prefix(prefix).filter(|name| is_pair(name))?;
            let place = || Place { name: name.to_string(), angular: false };
            Some(index(contacts, |known| known.name == name, place))
        };
        match schema {
            Schema::Disc => {
                let name = topic.strip_prefix("/disc/").filter(|name| is_name(name))?;
                Some(Carries::Body(index(bodies, |known| known == name, || name.to_string())))
            }
            Schema::Contact => pair(topic, "/contact/").map(Carries::Contact),
            Schema::Impact => pair(topic, "/impact/").map(Carries::Impact),
            Schema::Slip => pair(topic, "/slip/").map(Carries::Slip),
            _ => of_both(schema, topic),
        }
    }
}

/// The place of one among those that are known; one that is new goes behind them.
fn index<T>(all: &mut Vec<T>, is_it: impl Fn(&T) -> bool, new: impl Fn() -> T) -> usize {
    all.iter().position(is_it).unwrap_or_else(|| {
        all.push(new());
        all.len() - 1
    })
}

fn of_finger(schema: Schema, topic: &str) -> Option<Carries> {
    match (schema, topic) {
        (Schema::State, "/state") => Some(Carries::Finger(0)),
        (Schema::Contact, "/contact/proximal") => Some(Carries::Contact(Site::Proximal as usize)),
        (Schema::Contact, "/contact/distal") => Some(Carries::Contact(Site::Distal as usize)),
        (Schema::Limit, "/limit") => Some(Carries::Stop(Site::Limit as usize)),
        (Schema::Impact, "/impact/proximal") => Some(Carries::Impact(Site::Proximal as usize)),
        (Schema::Impact, "/impact/distal") => Some(Carries::Impact(Site::Distal as usize)),
        (Schema::LimitImpact, "/impact/limit") => Some(Carries::Impact(Site::Limit as usize)),
        (Schema::Slip, "/slip/proximal") => Some(Carries::Slip(Site::Proximal as usize)),
        (Schema::Slip, "/slip/distal") => Some(Carries::Slip(Site::Distal as usize)),
        _ => of_both(schema, topic),
    }
}

fn of_gripper(schema: Schema, topic: &str) -> Option<Carries> {
    let side = |prefix: &str| {
        let word = topic.strip_prefix(prefix)?;
        Side::BOTH.into_iter().find(|side| side.word() == word)
    };
    let place = |prefix: &str, stop: bool| {
        let name = topic.strip_prefix(prefix)?;
        scene::Place::ALL.into_iter().position(|place| place.is_stop() == stop && place.name() == name)
    };
    match schema {
        Schema::State => side("/state/").map(|side| Carries::Finger(side as usize)),
        Schema::Disc => (topic == "/object").then_some(Carries::Body(0)),
        Schema::Contact => place("/contact/", false).map(Carries::Contact),
        Schema::Limit => {
            let stop = scene::Place::Finger(side("/limit/")?, Site::Limit);
            scene::Place::ALL.into_iter().position(|place| place == stop).map(Carries::Stop)
        }
        Schema::Impact => place("/impact/", false).map(Carries::Impact),
        Schema::LimitImpact => place("/impact/", true).map(Carries::Impact),
        Schema::Slip => place("/slip/", false).map(Carries::Slip),
        _ => of_both(schema, topic),
    }
}

fn of_both(schema: Schema, topic: &str) -> Option<Carries> {
    match (schema, topic) {
        (Schema::Energy, "/energy") => Some(Carries::Energy),
        (Schema::Log, "/events") => Some(Carries::Lines),
        (Schema::Picture, _) => Some(Carries::Picture),
        _ => None,
    }
}

/// As scenes name their discs: what else stands in a topic cannot become a column or a key.
fn is_name(name: &str) -> bool {
    name.starts_with(|first: char| first.is_ascii_alphabetic())
        && name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}

fn is_pair(name: &str) -> bool {
    name.split_once('-').is_some_and(|(disc, partner)| is_name(disc) && is_name(partner))
}
