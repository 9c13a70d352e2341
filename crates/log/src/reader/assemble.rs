//! Assembles the messages of one log time into samples and events.
//!
//! In the write order of phalanx, the messages of a sample are consecutive and events are between samples. This order
//! is preserved. In any other order, messages are matched by channel, their own time and sequence number; a sample and
//! an event of one instant are in the order in which the model writes them.

use std::collections::{BTreeMap, HashMap, HashSet};

use foxglove::Decode;
use foxglove::messages::Log;
use prost::DecodeError;

use super::messages::Message;
use super::missing::{KnownChannel, MissingTracker, has_duplicates};
use super::scan::{MAX_RECORD_BYTES, Scan};
use super::summary::{Defect, LogSink, LogSummary, Loss, RunEnd};
use crate::channels::{ChannelContent, EVENT_TOPIC, subject_channels};
use crate::lines::is_friction_line;
use crate::messages::{decode, decode_event};
use phalanx_core::scene::keywords::SceneKind;
use phalanx_core::scene::parse_any;
use phalanx_core::trace::schema::{State as _, Subject, SubjectKind};
use phalanx_core::trace::{ContactName, ContactSample, Event, EventKind, Sample, Schema, SinkError};

/// Assembles messages, which arrive grouped by log time.
pub(crate) struct Assembler {
    schema: Schema,
    subjects: Vec<Subject>,
    /// Known channels, by id.
    channels: BTreeMap<u16, KnownChannel>,
    /// Topics that the log of such a run should have.
    expected: Vec<(String, ChannelContent)>,
    is_engine: bool,
    has_duplicates: bool,
    /// Subjects that the log has, in write order.
    present: Vec<usize>,
    /// A sample without any message: all required values are NaN.
    missing_sample: Sample,
    sample: Sample,
    summary: LogSummary,
    tracker: MissingTracker,
}

/// A message about a sample or an event.
struct Part<'a> {
    sequence: u32,
    time_s: f64,
    /// Subject and payload, or the event.
    content: Result<(usize, &'a [u8]), Event>,
}

/// Indices of the messages of a sample, or the index of an event.
type Item = Vec<usize>;

impl Assembler {
    /// Creates an assembler after the first pass; takes over its summary.
    pub fn new(scan: &mut Scan) -> Self {
        let mut summary = std::mem::take(&mut scan.summary);
        let kind = summary.kind();
        let scene = summary.scene.as_ref().filter(|(_, text)| text.len() < MAX_RECORD_BYTES);
        let scene = scene.and_then(|(name, text)| parse_any(text, name).ok()).filter(|scene| scene.kind() == kind);
        let mut found: Vec<_> = scan.index.channels.values().collect();
        found.sort_by_key(|channel| channel.id);
        let mut schema = Schema::from_kind(kind);
        if let Some(scene) = &scene {
            schema = Schema::from_scene(scene);
            if kind == SceneKind::Bodies {
                // Contacts that the scene does not have are omitted.
                schema.contacts.retain(|contact| contact.exists);
            }
        }
        let existing = subject_channels(&schema).into_iter().filter(|(.., exists)| *exists);
        let mut expected: Vec<(String, ChannelContent)> =
            existing.map(|(topic, content, _)| (topic, content)).collect();
        expected.push((EVENT_TOPIC.to_string(), ChannelContent::Events));
        expected.push(("/events".to_string(), ChannelContent::Lines));
        if kind == SceneKind::Bodies {
            found.iter().for_each(|channel| add_disc_topic(&mut schema, &channel.topic));
        }
        let all = subject_channels(&schema);
        // Added discs and pairs change the indices of subjects.
        for (topic, content) in &mut expected {
            *content = all.iter().find(|(other, ..)| other == topic).map_or(*content, |(_, content, _)| *content);
        }
        let events = (EVENT_TOPIC.to_string(), ChannelContent::Events);
        let known: BTreeMap<String, ChannelContent> =
            all.into_iter().map(|(topic, content, _)| (topic, content)).chain([events]).collect();
        let mut channels = BTreeMap::new();
        for channel in found {
            let message_schema = channel.schema.as_ref().filter(|schema| schema.encoding == "protobuf");
            let is_protobuf = channel.message_encoding == "protobuf";
            let name = message_schema.filter(|_| is_protobuf).map_or("", |schema| &schema.name);
            let content = match name {
                "foxglove.FrameTransforms" | "foxglove.SceneUpdate" => Some(ChannelContent::Picture),
                "foxglove.Log" if channel.topic == "/events" => Some(ChannelContent::Lines),
                name => known.get(&channel.topic).copied().filter(|content| content.message_name() == Some(name)),
            };
            match content {
                None => summary.unknown_channels += 1,
                Some(content) => {
                    let known_channel = KnownChannel { id: channel.id, topic: channel.topic.clone(), content };
                    channels.insert(channel.id, known_channel);
                }
            }
        }
        let with_messages = channels.values().filter(|channel| scan.sequences.contains_key(&channel.id));
        let mut present: Vec<usize> = with_messages.filter_map(|channel| channel.content.subject()).collect();
        present.sort_unstable();
        present.dedup();
        let required: HashSet<usize> =
            expected.iter().filter_map(|(_, content)| content.subject()).chain(present.clone()).collect();
        let subjects = schema.subjects();
        let mut missing_sample = Sample::new(f64::NAN, schema.counts());
        for (index, Subject { kind, first, .. }) in subjects.iter().enumerate() {
            let is_required = required.contains(&index);
            match kind {
                SubjectKind::Contact | SubjectKind::Limit if !is_required => {
                    let contact = index + 1 + schema.contacts.len() - subjects.len();
                    missing_sample.set_contact(contact, &ContactSample::NONE);
                }
                _ => kind.quantities().for_each(|(k, _)| missing_sample.values_mut()[first + k] = f64::NAN),
            }
        }
        Assembler {
            is_engine: summary.metadata.get("model").is_some_and(|model| model == "engine"),
            has_duplicates: has_duplicates(&scan.sequences),
            tracker: MissingTracker::new(subjects.len(), schema.contacts.len()),
            sample: missing_sample.clone(),
            schema,
            subjects,
            channels,
            expected,
            present,
            missing_sample,
            summary,
        }
    }

    /// Schema of the samples.
    pub fn schema(&self) -> &Schema {
        &self.schema
    }

    /// Returns the summary, including lost and missing data, after the last message.
    pub fn finish(self, scan: &Scan) -> LogSummary {
        let Assembler { mut summary, tracker, expected, schema, channels, .. } = self;
        if let Some((at_byte, defect)) = &scan.damage {
            summary.losses.push(Loss::new(*at_byte, summary.bytes, defect, summary.last_s));
        }
        let channels: Vec<KnownChannel> = channels.into_values().collect();
        summary.missing = tracker.missing(&summary, &expected, &schema, &channels, &scan.sequences);
        summary
    }

    /// Passes the samples and events of one log time to a sink.
    pub fn group(&mut self, messages: &[Message], sink: &mut impl LogSink) -> Result<Result<(), Defect>, SinkError> {
        let parts = match self.parts(messages) {
            Ok(parts) => parts,
            Err(defect) => return Ok(Err(defect)),
        };
        let is_at_start = self.summary.samples == 0;
        let items = items_in_write_order(&parts, &self.present)
            .unwrap_or_else(|| reconstruct_order(&parts, self.is_engine, is_at_start));
        for item in items {
            match item.first().map(|&first| &parts[first]) {
                Some(Part { content: Err(event), .. }) => {
                    self.tracker.count_event(event.contact, event.kind.is_friction_event());
                    self.summary.events += 1;
                    sink.event(event)?;
                }
                Some(Part { time_s, .. }) => {
                    if *time_s < self.summary.last_s.unwrap_or(0.0) {
                        let reason = "the time of a sample decreases although its log time does not";
                        return Ok(Err(Defect::damaged(reason)));
                    }
                    if let Err(error) = self.assemble(*time_s, item.iter().map(|&index| &parts[index])) {
                        return Ok(Err(Defect::damaged(describe(&error))));
                    }
                    sink.sample(&self.sample)?;
                    self.summary.samples += 1;
                    self.summary.first_s.get_or_insert(*time_s);
                    self.summary.last_s = Some(*time_s);
                }
                None => {}
            }
        }
        Ok(Ok(()))
    }

    /// Classifies messages. Pictures, unknown messages and duplicates are omitted; event lines are only counted.
    fn parts<'a>(&mut self, messages: &'a [Message]) -> Result<Vec<Part<'a>>, Defect> {
        let mut parts = Vec::with_capacity(messages.len());
        let mut seen = HashSet::new();
        for Message { header, data } in messages {
            let Some(KnownChannel { content, .. }) = self.channels.get(&header.channel_id) else {
                self.summary.messages += 1;
                self.summary.unknown_messages += 1;
                continue;
            };
            self.summary.messages += 1;
            if *content == ChannelContent::Picture {
                continue;
            }
            if self.has_duplicates && !seen.insert((header.channel_id, header.sequence, data)) {
                self.tracker.count_duplicate(header.channel_id);
                continue;
            }
            let part = match *content {
                ChannelContent::Lines => {
                    let line = Log::decode(data.as_slice())
                        .map_err(|_| Defect::damaged("a line of the log is not protobuf"))?;
                    if line.name == "run" {
                        self.summary.run_end = Some(RunEnd::new(header.log_time as f64 * 1e-9, line.message));
                    } else if let Some(contact) = self.schema.contacts.iter().position(|c| c.name == line.name) {
                        self.tracker.count_line(contact, is_friction_line(&line.message));
                    }
                    continue;
                }
                ChannelContent::Events => match decode_event(data) {
                    Ok(None) => {
                        self.summary.unknown_messages += 1;
                        continue;
                    }
                    Ok(Some((event, [subject, subject_kind]))) => {
                        let is_subject =
                            |contact: &ContactName| contact.name == subject && contact.kind().name() == subject_kind;
                        let Some(contact) = self.schema.contacts.iter().position(is_subject) else {
                            self.summary.unknown_messages += 1;
                            continue;
                        };
                        Ok((event.time_s, Err(Event { contact, ..event })))
                    }
                    Err(error) => Err(error),
                },
                content => {
                    let subject = content.subject().unwrap_or(usize::MAX);
                    decode(data, &mut []).map(|time_s| (time_s, Ok((subject, data.as_slice()))))
                }
            };
            let (time_s, content) = part.map_err(|error| Defect::damaged(describe(&error)))?;
            if !time_s.is_finite() {
                return Err(Defect::damaged("the time of a message is not a number"));
            }
            if (time_s - header.log_time as f64 * 1e-9).abs() > MAX_TIME_DIFFERENCE_S {
                return Err(Defect::damaged("the time of a message differs from its log time"));
            }
            parts.push(Part { sequence: header.sequence, time_s, content });
        }
        Ok(parts)
    }

    fn assemble<'a>(&mut self, time_s: f64, parts: impl Iterator<Item = &'a Part<'a>>) -> Result<(), DecodeError> {
        self.sample.clone_from(&self.missing_sample);
        self.sample.time_s = time_s;
        self.tracker.start_sample(time_s);
        let mut numbers = [0.0; MAX_QUANTITIES];
        for part in parts {
            let Ok((index, data)) = part.content else { continue };
            self.tracker.count_component(index);
            let Subject { kind, first, .. } = self.subjects[index];
            decode(data, &mut numbers)?;
            let values = &mut self.sample.values_mut()[first..];
            if kind == SubjectKind::Limit {
                // It has no slip, friction, contact point or normal.
                values[..ContactSample::QUANTITIES.len()].fill(0.0);
            }
            kind.quantities().zip(numbers).for_each(|((k, _), number)| values[k] = number);
        }
        Ok(())
    }
}

/// Largest difference between the time of a message and its log time, which is a whole number of nanoseconds and never
/// decreases.
const MAX_TIME_DIFFERENCE_S: f64 = 1e-3;

/// No subject has more numbers.
const MAX_QUANTITIES: usize = 16;

fn describe(error: &DecodeError) -> String {
    format!("a message is not protobuf ({error})")
}

/// Adds the disc or the pair of discs of a topic to the schema. Names that could not become a column are ignored.
fn add_disc_topic(schema: &mut Schema, topic: &str) {
    let is_valid = |name: &str| {
        name.starts_with(|first: char| first.is_ascii_alphabetic())
            && name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
    };
    let is_new_disc = |name: &&str| is_valid(name) && !schema.bodies.iter().any(|known| known == name);
    if let Some(name) = topic.strip_prefix("/body/").filter(is_new_disc) {
        schema.bodies.push(name.to_string());
    }
    let is_new_pair = |name: &&str| {
        let is_pair = name.split_once('-').is_some_and(|(disc, partner)| is_valid(disc) && is_valid(partner));
        is_pair && !schema.contacts.iter().any(|known| known.name == *name)
    };
    if let Some(name) = topic.strip_prefix("/contact/").filter(is_new_pair) {
        schema.contacts.push(ContactName { name: name.to_string(), is_angular: false, exists: true });
    }
}

/// Returns the samples and events of messages in write order; `None` in any other order. `subjects` are those
/// of a sample of this log, in order.
fn items_in_write_order(parts: &[Part<'_>], subjects: &[usize]) -> Option<Vec<Item>> {
    let mut items: Vec<Item> = Vec::new();
    let (mut next, mut latest_s) = (0, f64::NEG_INFINITY);
    for (index, part) in parts.iter().enumerate() {
        match part.content {
            Ok((subject, _)) => {
                if next == 0 {
                    items.push(Vec::with_capacity(subjects.len()));
                    if part.time_s < latest_s {
                        return None;
                    }
                    latest_s = part.time_s;
                }
                if subjects.get(next) != Some(&subject) || part.time_s != latest_s {
                    return None;
                }
                items.last_mut()?.push(index);
                next = (next + 1) % subjects.len();
            }
            Err(_) if next > 0 => return None,
            Err(_) => items.push(vec![index]),
        }
    }
    (next == 0).then_some(items)
}

/// Returns the samples and events of messages in any order.
fn reconstruct_order(parts: &[Part<'_>], is_engine: bool, is_at_start: bool) -> Vec<Item> {
    let mut by_sequence: Vec<usize> = (0..parts.len()).collect();
    by_sequence.sort_by_key(|&index| parts[index].sequence);
    // Of two samples of one instant, the first gets the first message of every channel.
    let mut counts: HashMap<(usize, u64), usize> = HashMap::new();
    let mut samples: BTreeMap<(u64, usize), Item> = BTreeMap::new();
    let mut events: Vec<(usize, &Event)> = Vec::new();
    for index in by_sequence {
        match &parts[index].content {
            Ok((subject, _)) => {
                let time_bits = parts[index].time_s.to_bits();
                let count = counts.entry((*subject, time_bits)).or_default();
                samples.entry((time_bits, *count)).or_default().push(index);
                *count += 1;
            }
            Err(event) => events.push((index, event)),
        }
    }
    events.sort_by(|(_, a), (_, b)| a.time_s.total_cmp(&b.time_s).then(a.contact.cmp(&b.contact)));
    let mut samples: Vec<(f64, Item)> =
        samples.into_iter().map(|((time_bits, _), indices)| (f64::from_bits(time_bits), indices)).collect();
    samples.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    let mut items = Vec::new();
    let mut emitted = 0;
    // First sample of the current instant and number of its events so far.
    let (mut first_sample, mut occurrence) = (usize::MAX, 0);
    for (index, event) in events {
        let before = samples.partition_point(|(at_s, _)| *at_s < event.time_s && !is_same_instant(*at_s, event.time_s));
        let simultaneous =
            samples[before..].iter().take_while(|(at_s, _)| is_same_instant(*at_s, event.time_s)).count();
        (first_sample, occurrence) = if first_sample == before { (first_sample, occurrence + 1) } else { (before, 1) };
        let after = match (simultaneous, is_engine) {
            (0, _) => before,
            // Events of contacts closed at the start precede the first sample.
            (_, false) if is_at_start && before == 0 && !event.kind.is_friction_event() => before,
            // Each of two samples of one instant is followed by an event.
            (_, false) => before + occurrence.min(simultaneous),
            // In the engine, every event except a touch-down precedes the sample at the end of its step.
            (_, true) if event.kind == EventKind::TouchDown => before + 1,
            (_, true) => before + simultaneous - 1,
        };
        while emitted < after {
            items.push(samples[emitted].1.clone());
            emitted += 1;
        }
        items.push(vec![index]);
    }
    items.extend(samples.drain(emitted..).map(|(_, indices)| indices));
    items
}

/// Whether two times denote the same instant: the model may compute it in two ways with different rounding.
fn is_same_instant(a_s: f64, b_s: f64) -> bool {
    (a_s - b_s).abs() <= 4.0 * f64::EPSILON * a_s.abs().max(b_s.abs())
}
