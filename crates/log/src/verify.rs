//! Compares a log with the log of a new simulation, log time by log time, so memory does not grow with the log.
//!
//! Messages of one log time are compared per channel in any order: times, sequence number, every byte. Unmatched
//! messages are counted. A log without sequence numbers (all 0, as some tools write) is compared without them, and
//! channels without messages are ignored. Differing messages are decoded by their schemas to name the fields.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::io::{Read, Seek};
use std::sync::Arc;

use prost_reflect::{DescriptorPool, DynamicMessage, MessageDescriptor, ReflectMessage, Value as FieldValue};
use serde::Serialize;
use serde_json::Value;

use super::reader::{Message, Messages, ReadError, scan};
use phalanx_core::trace::SinkError;

/// Maximum number of fields reported separately; differences in further fields count only as differing messages.
const MAX_FIELDS: usize = 10_000;
/// Maximum number of reported differences of schemas and channels.
const MAX_SCHEMA_DIFFERENCES: usize = 100;

/// Entries that identify the program that wrote a log; they may differ.
const VERSIONS: [&str; 4] = ["phalanx_version", "mcap_version", "libm_version", "rapier_version"];

/// Range of the log to compare.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComparisonOptions {
    /// Messages from this log time on are not compared, because an interrupt ended the run there.
    pub before_ns: Option<u64>,
    /// Whether the log contains the end of its run: the new run must end there too.
    pub has_run_end: bool,
}

/// Result of a comparison.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Verification {
    pub channels: u64,
    /// Number of compared pairs of messages.
    pub messages_compared: u64,
    pub messages_differing: u64,
    pub messages_only_in_log: u64,
    pub messages_only_in_new_run: u64,
    /// Identical messages in a different order within the same log time. The order is not compared.
    pub messages_reordered: u64,
    /// Messages without a sequence number in the log; the number is not compared.
    pub messages_unnumbered: u64,
    /// Messages at the end of an interrupted run, which are not compared.
    pub messages_not_compared: u64,
    /// Log time of the last message that was compared.
    pub compared_to_s: Option<f64>,
    pub first_difference: Option<Difference>,
    /// The largest difference of every channel and field; entries of a list are combined.
    pub fields: Vec<FieldTally>,
    /// Differences of schemas and channels, as sentences.
    #[serde(rename = "structure")]
    pub schema_differences: Vec<String>,
    /// Metadata entries that differ.
    pub metadata: Vec<EntryDifference>,
}

/// A difference of one field of one message.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Time of the message; unrounded if it has a field `timestamp`.
    pub time_s: f64,
    pub channel: String,
    /// Name of the field; nested fields have names such as `transforms[2].rotation.z`.
    pub field: String,
    /// Value in the log: numbers as numbers (null if not finite), others as text; null if absent.
    pub log: Value,
    /// Value in the new run.
    pub new_run: Value,
    /// Absolute difference in the unit of the field; null if the values are not numbers.
    pub absolute: Option<f64>,
    /// Difference relative to the larger value.
    pub relative: Option<f64>,
}

/// A field in which messages differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldTally {
    /// Number of messages that differ in this field.
    pub messages: u64,
    #[serde(flatten)]
    pub largest: Difference,
}

/// A metadata entry that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EntryDifference {
    pub key: String,
    pub log: Option<String>,
    pub new_run: Option<String>,
}

impl Verification {
    /// Whether all compared data is identical, bit for bit.
    pub fn is_same(&self) -> bool {
        self.messages_differing + self.messages_only_in_log + self.messages_only_in_new_run == 0
            && self.schema_differences.is_empty()
            && self.metadata.iter().all(|entry| VERSIONS.contains(&entry.key.as_str()))
    }
}

impl Difference {
    fn new(time_s: f64, channel: &str, field: String, [log, new_run]: [Value; 2]) -> Self {
        let numbers = log.as_f64().zip(new_run.as_f64());
        let absolute = numbers.map(|(a, b)| (a - b).abs());
        let scale = numbers.map_or(0.0, |(a, b)| a.abs().max(b.abs()));
        let relative = absolute.filter(|_| scale > 0.0).map(|absolute| absolute / scale);
        Difference { time_s, channel: channel.to_string(), field, log, new_run, absolute, relative }
    }
}

/// Compares a log with the log of a new run. `check` is called with every log time, ns; its error ends the comparison.
///
/// # Errors
/// Returns [`ReadError`] if a log cannot be read.
pub fn verify(
    mut log: impl Read + Seek,
    mut new_run: impl Read + Seek,
    options: &ComparisonOptions,
    check: &dyn Fn(u64) -> Result<(), SinkError>,
) -> Result<Verification, ReadError> {
    let scans = [scan(&mut log, false)?, scan(&mut new_run, false)?];
    let mut comparison = Comparison {
        channels: scans.each_ref().map(|scan| scan.index.channels.clone()),
        descriptors: HashMap::new(),
        fields: BTreeMap::new(),
        result: Verification::default(),
    };
    let has_run_end = options.has_run_end && options.before_ns.is_none();
    let (mut log, mut new_run) = (Messages::new(log, &scans[0])?, Messages::new(new_run, &scans[1])?);
    while let Some(log_ns) = log.next_time_ns() {
        check(log_ns)?;
        if options.before_ns.is_some_and(|before_ns| log_ns >= before_ns) {
            comparison.result.messages_not_compared += log.next_group()?.len() as u64;
            continue;
        }
        while new_run.next_time_ns().is_some_and(|new_ns| new_ns < log_ns) {
            comparison.count_extra(&new_run.next_group()?);
        }
        let simultaneous = if new_run.next_time_ns() == Some(log_ns) { new_run.next_group()? } else { Vec::new() };
        let unmatched = comparison.compare_group(&log.next_group()?, simultaneous);
        // A truncated log may lack messages of its last log time.
        if log.next_time_ns().is_some() || has_run_end {
            comparison.count_extra(&unmatched);
        }
    }
    while has_run_end && new_run.next_time_ns().is_some() {
        comparison.count_extra(&new_run.next_group()?);
    }
    let mut result = comparison.result;
    result.fields = comparison.fields.into_values().collect();
    result.channels = scans[0].index.channels.len() as u64;
    let active = scans.each_ref().map(|scan| {
        let channels = scan.index.channels.values();
        let found =
            channels.map(|channel| (channel.topic.as_str(), (channel, scan.sequences.contains_key(&channel.id))));
        found.collect::<BTreeMap<_, _>>()
    });
    result.schema_differences = compare_channels(&active);
    let [entries, new_entries] = scans.each_ref().map(|scan| &scan.summary.metadata);
    let mut keys: Vec<&String> = entries.keys().chain(new_entries.keys()).collect();
    keys.sort();
    keys.dedup();
    result.metadata = keys
        .into_iter()
        .map(|key| EntryDifference {
            key: key.clone(),
            log: entries.get(key).cloned(),
            new_run: new_entries.get(key).cloned(),
        })
        .filter(|entry| entry.log != entry.new_run)
        .collect();
    Ok(result)
}

type Channels = HashMap<u16, Arc<mcap::Channel<'static>>>;

/// State of a comparison; arrays have an element for the log and one for the new run.
struct Comparison {
    channels: [Channels; 2],
    descriptors: HashMap<(usize, u16), Option<MessageDescriptor>>,
    /// Differences by channel and field.
    fields: BTreeMap<(String, String), FieldTally>,
    result: Verification,
}

impl Comparison {
    fn topic(&self, side: usize, message: &Message) -> &str {
        self.channels[side].get(&message.header.channel_id).map_or("", |channel| &channel.topic)
    }

    /// Counts messages that only the new run has.
    fn count_extra<'a>(&mut self, messages: impl IntoIterator<Item = &'a Message>) {
        for message in messages {
            self.result.messages_only_in_new_run += 1;
            self.record_unmatched(1, message);
        }
    }

    /// Records an unmatched message as the first difference, if there is none yet.
    fn record_unmatched(&mut self, side: usize, message: &Message) {
        let (topic, time_s) = (self.topic(side, message).to_string(), seconds(message));
        let mut values = [Value::Null, Value::Null];
        values[side] = format!("{topic} at {time_s:.9} s").into();
        let difference = Difference::new(time_s, &topic, "(which message comes next)".to_string(), values);
        self.result.first_difference.get_or_insert(difference);
    }

    /// Matches the messages of one log time; returns those that only the new run has.
    fn compare_group(&mut self, log: &[Message], new_run: Vec<Message>) -> VecDeque<Message> {
        let mut unmatched: VecDeque<(usize, Message)> = new_run.into_iter().enumerate().collect();
        let mut max_rank = 0;
        for message in log {
            let same_topic = |other: &Message| self.topic(0, message) == self.topic(1, other);
            let find = |matches: &dyn Fn(&Message) -> bool| {
                unmatched.iter().position(|(_, other)| matches(other) && same_topic(other))
            };
            // Same bytes, or same sequence number, or else the first.
            let same_number = |other: &Message| other.header.sequence == message.header.sequence;
            let index = find(&|other| same_number(other) && other.data == message.data)
                .or_else(|| find(&|other| other.data == message.data))
                .or_else(|| find(&same_number))
                .or_else(|| find(&|_| true));
            match index.and_then(|index| unmatched.remove(index)) {
                None => {
                    self.result.messages_only_in_log += 1;
                    self.record_unmatched(0, message);
                }
                Some((rank, other)) => {
                    // In the new run it precedes a message that is earlier in the log.
                    self.result.messages_reordered += u64::from(rank < max_rank);
                    max_rank = max_rank.max(rank);
                    self.compare(message, &other);
                }
            }
        }
        unmatched.into_iter().map(|(_, message)| message).collect()
    }

    /// Compares two messages of one channel and one log time.
    fn compare(&mut self, log: &Message, new_run: &Message) {
        self.result.messages_compared += 1;
        self.result.compared_to_s = Some(seconds(log));
        let numbers = [log, new_run].map(|message| message.header.sequence);
        let unnumbered = numbers[0] == 0 && numbers[1] != 0;
        self.result.messages_unnumbered += u64::from(unnumbered);
        // After a missing message all later sequence numbers differ; these differences are not counted.
        let has_same_number = unnumbered || self.result.first_difference.is_some() || numbers[0] == numbers[1];
        let times = [log, new_run].map(|message| message.header.publish_time);
        if log.data == new_run.data && times[0] == times[1] && has_same_number {
            return;
        }
        self.result.messages_differing += 1;
        let topic = self.topic(0, log).to_string();
        let (mut time_s, mut found) = (seconds(log), Vec::new());
        if log.data != new_run.data {
            let decoded = [self.decode(0, log), self.decode(1, new_run)];
            if let [Some(log), Some(new_run)] = &decoded {
                let timestamp = log.get_field_by_name("timestamp").and_then(|value| value.as_f64());
                time_s = timestamp.filter(|time_s| time_s.is_finite()).unwrap_or(time_s);
                found = differing_fields(log, new_run);
            }
            if found.is_empty() {
                let values = [log, new_run].map(|message| format!("{} bytes", message.data.len()).into());
                found.push(("(bytes of the message)".to_string(), values));
            }
        } else if times[0] != times[1] {
            found.push(("(publish time, ns)".to_string(), times.map(Value::from)));
        } else {
            found.push(("(sequence number)".to_string(), numbers.map(Value::from)));
        }
        let mut counted_names: Vec<String> = Vec::new();
        for (field, values) in found {
            let name = without_indices(&field);
            let difference = Difference::new(time_s, &topic, field, values);
            self.result.first_difference.get_or_insert_with(|| difference.clone());
            let key = (topic.clone(), name.clone());
            if self.fields.len() >= MAX_FIELDS && !self.fields.contains_key(&key) {
                continue;
            }
            let largest = Difference { field: name.clone(), ..difference };
            let tally = self.fields.entry(key).or_insert_with(|| FieldTally { messages: 0, largest: largest.clone() });
            if largest.absolute > tally.largest.absolute {
                tally.largest = largest;
            }
            // Entries of one list in a message count once.
            if !counted_names.contains(&name) {
                tally.messages += 1;
                counted_names.push(name);
            }
        }
    }

    /// Decodes a message by the schema in its log.
    fn decode(&mut self, side: usize, message: &Message) -> Option<DynamicMessage> {
        let id = message.header.channel_id;
        let channel = self.channels[side].get(&id);
        let descriptor = self.descriptors.entry((side, id)).or_insert_with(|| descriptor(channel?));
        DynamicMessage::decode(descriptor.clone()?, message.data.as_slice()).ok()
    }
}

fn seconds(message: &Message) -> f64 {
    message.header.log_time as f64 * 1e-9
}

/// Returns the descriptor of the messages of a channel; `None` if the schema is invalid or does not contain it.
fn descriptor(channel: &mcap::Channel<'_>) -> Option<MessageDescriptor> {
    let schema = channel.schema.as_ref()?;
    DescriptorPool::decode(&*schema.data).ok()?.get_message_by_name(&schema.name)
}

/// Returns names and values of the fields that differ, bit for bit.
fn differing_fields(log: &DynamicMessage, new_run: &DynamicMessage) -> Vec<(String, [Value; 2])> {
    let [mut log_fields, mut new_fields] = [Vec::new(), Vec::new()];
    flatten_message(log, "", &mut log_fields);
    flatten_message(new_run, "", &mut new_fields);
    let mut unmatched: HashMap<&str, &FieldValue> =
        new_fields.iter().map(|(name, value)| (name.as_str(), value)).collect();
    let mut found = Vec::new();
    for (name, value) in &log_fields {
        let other = unmatched.remove(name.as_str());
        if !other.is_some_and(|other| is_same(value, other)) {
            found.push((name.clone(), [to_json(value), other.map_or(Value::Null, to_json)]));
        }
    }
    let only_new = new_fields.iter().filter(|(name, _)| unmatched.contains_key(name.as_str()));
    found.extend(only_new.map(|(name, value)| (name.clone(), [Value::Null, to_json(value)])));
    found
}

fn is_same(a: &FieldValue, b: &FieldValue) -> bool {
    match (a, b) {
        (FieldValue::F64(a), FieldValue::F64(b)) => a.to_bits() == b.to_bits(),
        _ => a == b,
    }
}

fn to_json(value: &FieldValue) -> Value {
    match value {
        FieldValue::F64(value) => (*value).into(),
        FieldValue::F32(value) => (*value).into(),
        FieldValue::I32(value) | FieldValue::EnumNumber(value) => (*value).into(),
        FieldValue::I64(value) => (*value).into(),
        FieldValue::U32(value) => (*value).into(),
        FieldValue::U64(value) => (*value).into(),
        FieldValue::Bool(value) => (*value).into(),
        FieldValue::String(text) => text.as_str().into(),
        FieldValue::Bytes(bytes) => format!("{} bytes", bytes.len()).into(),
        other => format!("{other:?}").into(),
    }
}

fn flatten_message(message: &DynamicMessage, path: &str, found: &mut Vec<(String, FieldValue)>) {
    let descriptor = message.descriptor();
    let mut fields: Vec<_> = descriptor.fields().collect();
    fields.sort_by_key(|field| field.number());
    for field in fields.iter().filter(|field| !field.supports_presence() || message.has_field(field)) {
        flatten_value(&message.get_field(field), format!("{path}{}", field.name()), found);
    }
}

fn flatten_value(value: &FieldValue, name: String, found: &mut Vec<(String, FieldValue)>) {
    match value {
        FieldValue::Message(message) => flatten_message(message, &format!("{name}."), found),
        FieldValue::List(values) => {
            for (index, value) in values.iter().enumerate() {
                flatten_value(value, format!("{name}[{index}]"), found);
            }
        }
        value => found.push((name, value.clone())),
    }
}

/// Removes list indices: `transforms[3].rotation.z` becomes `transforms[].rotation.z`.
fn without_indices(field: &str) -> String {
    let mut parts = field.split('[');
    let first = parts.next().unwrap_or_default().to_string();
    parts.fold(first, |name, part| name + "[" + part.trim_start_matches(|letter: char| letter != ']'))
}

/// Channels by topic, and whether they have messages.
type ActiveChannels<'a> = BTreeMap<&'a str, (&'a Arc<mcap::Channel<'static>>, bool)>;

/// Describes the differences of the channels of the log and the new run.
fn compare_channels([log, new_run]: &[ActiveChannels<'_>; 2]) -> Vec<String> {
    let mut differences = Vec::new();
    for (topic, (channel, has_messages)) in log {
        let Some((other, _)) = new_run.get(topic) else {
            differences.extend(has_messages.then(|| format!("only the log has the channel {topic}")));
            continue;
        };
        let aspects = [
            ("schema", has_same_schema(channel, other)),
            ("encoding of the messages", channel.message_encoding == other.message_encoding),
            ("metadata", channel.metadata == other.metadata),
        ];
        let differing = aspects.into_iter().filter(|(_, same)| !same);
        differences.extend(differing.map(|(aspect, _)| format!("the {aspect} of the channel {topic} differs")));
    }
    // A log without messages may have lost its channel records.
    if log.values().any(|(_, has_messages)| *has_messages) {
        let missing = new_run.iter().filter(|(topic, (_, has_messages))| *has_messages && !log.contains_key(*topic));
        differences.extend(missing.map(|(topic, _)| format!("only the new run has the channel {topic}")));
    }
    differences.sort();
    differences.truncate(MAX_SCHEMA_DIFFERENCES);
    differences
}

/// Whether two channels have the same schema. Older logs have the same messages in other packages.
fn has_same_schema(a: &mcap::Channel<'_>, b: &mcap::Channel<'_>) -> bool {
    let [Some(first), Some(second)] = [&a.schema, &b.schema] else { return a.schema.is_none() && b.schema.is_none() };
    let is_identical = (&first.name, &first.encoding, &first.data) == (&second.name, &second.encoding, &second.data);
    let is_equivalent = || {
        let [Some(a), Some(b)] = [descriptor(a), descriptor(b)] else { return false };
        first.encoding == second.encoding && a.descriptor_proto() == b.descriptor_proto()
    };
    is_identical || second.name.starts_with("phalanx.") && is_equivalent()
}
