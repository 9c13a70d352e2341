//! Assembles the messages of one log time into samples and events.
//!
//! In the write order of phalanx, the messages of a sample are consecutive and events are between samples. This order
//! is preserved. In any other order, messages are matched by channel, their own time and sequence number; a sample and
//! an event of one instant are in the order in which the model writes them.

use std::collections::{BTreeMap, HashMap, HashSet};

use foxglove::Decode;
use foxglove::messages::Log;
use mcap::records::MessageHeader;

use super::messages::{MAX_OPEN_BYTES, too_much_memory};
use super::missing::{MissingTracker, has_duplicates};
use super::scan::Scan;
use super::schema::read_schema;
use super::summary::{Defect, LogSink, LogSummary, Loss, MissingData, RunEnd, Stop};
use crate::channels::{ChannelContent, Topic, is_own_message, topics};
use crate::lines::is_friction_line;
use crate::messages::{decode, decode_event};
use phalanx_core::trace::{Event, EventKind, Sample, Schema};

/// Assembles messages, which arrive in order of log time.
pub(crate) struct Assembler {
    schema: Schema,
    topics: Vec<Topic>,
    /// Index of the topic of every known channel; `None` for 3-D views.
    channels: BTreeMap<u16, Option<usize>>,
    /// Indices of the contacts, by name.
    contacts: HashMap<String, usize>,
    /// For each subject, the indices of the numbers of its messages in a sample.
    indices: Vec<Vec<usize>>,
    is_engine: bool,
    has_duplicates: bool,
    /// Subjects that the log has, in write order.
    present: Vec<usize>,
    /// Topics with messages of phalanx that belong to no subject.
    unreadable: Vec<String>,
    /// A sample without any message: all required values are NaN.
    missing_sample: Sample,
    sample: Sample,
    summary: LogSummary,
    tracker: MissingTracker,
    group: Group,
}

/// Messages of one log time; its allocations are reused.
#[derive(Default)]
struct Group {
    time_ns: u64,
    parts: Vec<Part>,
    /// Numbers of all subjects.
    numbers: Vec<f64>,
    /// Received messages, if messages are repeated in the log.
    seen: HashSet<(u16, u32, Vec<u8>)>,
    bytes: usize,
}

/// A message about a sample or an event.
#[derive(Clone, Copy)]
struct Part {
    sequence: u32,
    time_s: f64,
    content: PartContent,
}

#[derive(Clone, Copy)]
enum PartContent {
    /// A subject, and the index of the first of its numbers in the group.
    Subject(usize, usize),
    Event(Event),
}

impl Part {
    fn subject(&self) -> Option<usize> {
        match self.content {
            PartContent::Subject(subject, _) => Some(subject),
            PartContent::Event(_) => None,
        }
    }
}

impl Assembler {
    /// Creates an assembler after the first pass, and takes over the summary of this pass.
    pub fn new(scan: &mut Scan) -> Self {
        let mut summary = std::mem::take(&mut scan.summary);
        let found: BTreeMap<_, _> = scan.index.channels.iter().collect();
        let schema = read_schema(&mut summary, scan, found.values().map(|channel| &***channel));
        let mut topics = topics(&schema);
        let by_name: HashMap<String, usize> =
            topics.iter().enumerate().map(|(index, topic)| (topic.name.clone(), index)).collect();
        let (mut channels, mut unreadable) = (BTreeMap::new(), Vec::new());
        for (&id, channel) in found {
            let message_schema = channel.schema.as_ref().filter(|schema| schema.encoding == "protobuf");
            let is_protobuf = channel.message_encoding == "protobuf";
            let name = message_schema.filter(|_| is_protobuf).map_or("", |schema| &schema.name);
            let topic = by_name.get(&channel.topic).filter(|&&topic| topics[topic].content.message_name() == name);
            match topic {
                Some(&topic) => {
                    topics[topic].channels.push(id);
                    channels.insert(id, Some(topic));
                }
                None if ["foxglove.FrameTransforms", "foxglove.SceneUpdate"].contains(&name) => {
                    channels.insert(id, None);
                }
                None => {
                    summary.unknown_channels += 1;
                    if is_own_message(name) {
                        unreadable.push(channel.topic.clone());
                    }
                }
            }
        }
        let subjects = schema.subjects();
        let mut missing_sample = Sample::new(f64::NAN, schema.counts());
        let mut present = Vec::new();
        for Topic { content, channels, .. } in &topics {
            let ChannelContent::Subject { index, .. } = *content else { continue };
            let has_messages = channels.iter().any(|id| scan.sequences.contains_key(id));
            present.extend(has_messages.then_some(index));
            subjects[index].quantities().for_each(|(k, _)| missing_sample.values_mut()[k] = f64::NAN);
        }
        let contact_names = schema.contacts.iter().enumerate();
        Assembler {
            is_engine: summary.metadata.get("model").is_some_and(|model| model == "engine"),
            has_duplicates: has_duplicates(&scan.sequences),
            tracker: MissingTracker::new(subjects.len(), schema.contacts.len()),
            sample: missing_sample.clone(),
            contacts: contact_names.map(|(index, contact)| (contact.name.clone(), index)).collect(),
            indices: subjects.iter().map(|subject| subject.independent().map(|(index, _)| index).collect()).collect(),
            schema,
            topics,
            channels,
            unreadable,
            present,
            missing_sample,
            summary,
            group: Group::default(),
        }
    }

    /// Schema of the samples.
    pub fn schema(&self) -> &Schema {
        &self.schema
    }

    /// Log time of the last message, ns.
    pub fn time_ns(&self) -> u64 {
        self.group.time_ns
    }

    /// Returns the summary, including lost and missing data, after the last message.
    pub fn finish(self, scan: &Scan) -> LogSummary {
        let Assembler { mut summary, tracker, schema, topics, channels, unreadable, .. } = self;
        if let Some((at_byte, defect)) = &scan.damage {
            summary.losses.push(Loss::new(*at_byte, summary.bytes, defect, summary.last_s));
        }
        let known = channels.keys().filter_map(|id| Some((*id, *scan.sequences.get(id)?))).collect();
        summary.missing = tracker.missing(&summary, topics, &schema, &known);
        summary.missing.extend(unreadable.into_iter().map(MissingData::unreadable));
        summary
    }

    /// Receives a message. The first message with another log time ends the previous group.
    pub fn message(&mut self, header: &MessageHeader, data: &[u8], sink: &mut impl LogSink) -> Result<(), Stop> {
        if header.log_time != self.group.time_ns {
            self.end_group(sink)?;
            self.group.time_ns = header.log_time;
        }
        self.summary.messages += 1;
        let topic = match self.channels.get(&header.channel_id) {
            Some(&Some(topic)) => topic,
            // Views are derived from samples.
            Some(None) => return Ok(()),
            None => {
                self.summary.unknown_messages += 1;
                return Ok(());
            }
        };
        let group = &mut self.group;
        group.bytes += data.len() + size_of::<Part>();
        if group.bytes > MAX_OPEN_BYTES {
            return Err(Stop::Error(too_much_memory()));
        }
        if self.has_duplicates && !group.seen.insert((header.channel_id, header.sequence, data.to_vec())) {
            self.tracker.count_duplicate(header.channel_id);
            return Ok(());
        }
        let (time_s, content) = match self.topics[topic].content {
            ChannelContent::Lines => {
                let line = Log::decode(data).map_err(|_| Defect::damaged("a line of the log is not protobuf"))?;
                if line.name == "run" {
                    self.summary.run_end = Some(RunEnd::new(header.log_time as f64 * 1e-9, line.message));
                } else if let Some(&contact) = self.contacts.get(&line.name) {
                    self.tracker.count_line(contact, is_friction_line(&line.message));
                }
                return Ok(());
            }
            ChannelContent::Events => {
                let known = decode_event(data)?.and_then(|(event, [subject, subject_kind])| {
                    let contact = *self.contacts.get(&subject)?;
                    let has_kind = self.schema.contacts[contact].kind().name() == subject_kind;
                    has_kind.then_some(Event { contact, ..event })
                });
                let Some(event) = known else {
                    self.summary.unknown_messages += 1;
                    return Ok(());
                };
                (event.time_s, PartContent::Event(event))
            }
            ChannelContent::Subject { index, .. } => {
                let first = group.numbers.len();
                group.numbers.resize(first + self.indices[index].len(), 0.0);
                (decode(data, &mut group.numbers[first..])?, PartContent::Subject(index, first))
            }
        };
        if !time_s.is_finite() {
            return Err(Defect::damaged("the time of a message is not a number").into());
        }
        if (time_s - header.log_time as f64 * 1e-9).abs() > MAX_TIME_DIFFERENCE_S {
            return Err(Defect::damaged("the time of a message differs from its log time").into());
        }
        group.parts.push(Part { sequence: header.sequence, time_s, content });
        Ok(())
    }

    /// Passes the samples and events of the last log time to a sink.
    pub fn end_group(&mut self, sink: &mut impl LogSink) -> Result<(), Stop> {
        let mut parts = std::mem::take(&mut self.group.parts);
        if !is_in_write_order(&parts, &self.present) {
            restore_write_order(&mut parts, self.is_engine, self.summary.samples == 0);
        }
        let mut rest = parts.as_slice();
        while let Some(first) = rest.first() {
            // The subjects of a sample are in their order.
            let is_same_sample =
                |pair: &&[Part]| pair[0].time_s == pair[1].time_s && pair[0].subject() < pair[1].subject();
            let count = match first.content {
                PartContent::Subject(..) => 1 + rest.windows(2).take_while(is_same_sample).count(),
                PartContent::Event(event) => {
                    self.tracker.count_event(event.contact, event.kind.is_friction_event());
                    self.summary.events += 1;
                    sink.event(&event)?;
                    1
                }
            };
            let (item, after) = rest.split_at(count);
            if first.subject().is_some() {
                self.assemble(first.time_s, item)?;
                sink.sample(&self.sample)?;
            }
            rest = after;
        }
        parts.clear();
        self.group.numbers.clear();
        self.group.seen.clear();
        (self.group.parts, self.group.bytes) = (parts, 0);
        Ok(())
    }

    fn assemble(&mut self, time_s: f64, parts: &[Part]) -> Result<(), Defect> {
        if time_s < self.summary.last_s.unwrap_or(0.0) {
            return Err(Defect::damaged("the time of a sample decreases although its log time does not"));
        }
        self.sample.clone_from(&self.missing_sample);
        self.sample.time_s = time_s;
        self.tracker.start_sample(time_s);
        let values = self.sample.values_mut();
        for part in parts {
            if let PartContent::Subject(subject, first) = part.content {
                self.tracker.count_component(subject);
                let numbers = self.indices[subject].iter().zip(&self.group.numbers[first..]);
                numbers.for_each(|(&index, &number)| values[index] = number);
            }
        }
        self.sample.derive();
        self.summary.samples += 1;
        self.summary.first_s.get_or_insert(time_s);
        self.summary.last_s = Some(time_s);
        Ok(())
    }
}

/// Largest difference between the time of a message and its log time, which is a whole number of nanoseconds and never
/// decreases.
const MAX_TIME_DIFFERENCE_S: f64 = 1e-3;

/// Whether messages are in write order. `present` are the subjects of a sample of this log, in order.
fn is_in_write_order(parts: &[Part], present: &[usize]) -> bool {
    let (mut next, mut latest_s, mut latest_event) = (0, f64::NEG_INFINITY, 0);
    let is_ordered = parts.iter().all(|part| {
        let Some(subject) = part.subject() else {
            return next == 0 && std::mem::replace(&mut latest_event, part.sequence) <= part.sequence;
        };
        let is_next =
            present.get(next) == Some(&subject) && (part.time_s == latest_s || next == 0 && part.time_s > latest_s);
        (next, latest_s) = ((next + 1) % present.len().max(1), part.time_s);
        is_next
    });
    is_ordered && next == 0
}

/// Sorts messages of any order as they were written.
fn restore_write_order(parts: &mut Vec<Part>, is_engine: bool, is_at_start: bool) {
    parts.sort_by_key(|part| part.sequence);
    // Of two samples of one instant, the first gets the first message of every subject.
    let mut counts: HashMap<(usize, u64), usize> = HashMap::new();
    let (mut samples, mut events) = (Vec::new(), Vec::new());
    for part in parts.drain(..) {
        match part.content {
            PartContent::Event(event) => events.push((event, part)),
            PartContent::Subject(subject, _) => {
                let count = counts.entry((subject, part.time_s.to_bits())).or_default();
                samples.push(((part.time_s, *count), part));
                *count += 1;
            }
        }
    }
    samples.sort_by(|((a_s, a), first), ((b_s, b), second)| {
        a_s.total_cmp(b_s).then(a.cmp(b)).then(first.subject().cmp(&second.subject()))
    });
    // Without sequence numbers, the order of simultaneous events is that of their contacts.
    let order = |part: &Part, event: &Event| (part.sequence, event.contact);
    events
        .sort_by(|(a, first), (b, second)| a.time_s.total_cmp(&b.time_s).then(order(first, a).cmp(&order(second, b))));
    let samples: Vec<&[_]> = samples.chunk_by(|(a, _), (b, _)| a == b).collect();
    let mut emitted = 0;
    // First sample of the current instant and number of its events so far.
    let (mut first_sample, mut occurrence) = (usize::MAX, 0);
    for (event, part) in events {
        let is_simultaneous = |sample: &&&[((f64, usize), Part)]| is_same_instant(sample[0].1.time_s, event.time_s);
        let before = samples.partition_point(|sample| sample[0].1.time_s < event.time_s && !is_simultaneous(&sample));
        let simultaneous = samples[before..].iter().take_while(is_simultaneous).count();
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
        let due = emitted..after.max(emitted);
        parts.extend(samples[due].iter().copied().flatten().map(|(_, part)| *part));
        emitted = emitted.max(after);
        parts.push(part);
    }
    parts.extend(samples[emitted..].iter().copied().flatten().map(|(_, part)| *part));
}

/// Whether two times denote the same instant: the model may compute it in two ways with different rounding.
fn is_same_instant(a_s: f64, b_s: f64) -> bool {
    (a_s - b_s).abs() <= 4.0 * f64::EPSILON * a_s.abs().max(b_s.abs())
}
