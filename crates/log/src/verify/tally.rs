//! What two runs differ in, in sum: how often, and by how much at most, field by field.

use std::collections::BTreeMap;

use prost_reflect::MessageDescriptor;

use super::again::{Channel, Message};
use super::fields::{FieldDifference, Leaf, descriptor, differences, timestamp_s};

/// Fields that are told apart; what differs beyond is counted as messages only.
const MOST_FIELDS: usize = 10_000;

/// A difference of one field.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Time of the message, unrounded where it says so itself.
    pub time_s: f64,
    pub channel: String,
    pub field: String,
    pub log: Leaf,
    pub again: Leaf,
}

impl Difference {
    /// |log − again|, if both are numbers.
    pub fn absolute(&self) -> Option<f64> {
        Some((self.log.number()? - self.again.number()?).abs())
    }

    /// The same relative to the larger of the two.
    pub fn relative(&self) -> Option<f64> {
        let scale = self.log.number()?.abs().max(self.again.number()?.abs());
        self.absolute().filter(|_| scale > 0.0).map(|absolute| absolute / scale)
    }
}

/// The differences of one field of a channel, of all list entries together.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldTally {
    /// Messages that differ in it.
    pub messages: u64,
    /// The one that is largest, as far as they are numbers.
    pub largest: Difference,
}

/// All differences by channel and field.
#[derive(Debug, Default)]
pub struct Tally {
    pub fields: BTreeMap<(String, String), FieldTally>,
    descriptors: BTreeMap<String, [Option<MessageDescriptor>; 2]>,
}

impl Tally {
    /// Takes two messages of a channel that are not the same; the first field in which they differ.
    pub fn take(&mut self, [log, again]: [&Message; 2], [ours, theirs]: [&Channel; 2]) -> Difference {
        let topic = &ours.topic;
        let descriptors = self
            .descriptors
            .entry(topic.clone())
            .or_insert_with(|| [ours, theirs].map(|channel| descriptor(&channel.schema.name, &channel.schema.data)));
        let mut time_s = log.log_time_ns as f64 * 1e-9;
        let mut found = Vec::new();
        if log.data != again.data {
            found = match descriptors {
                [Some(a), Some(b)] => {
                    time_s = timestamp_s(a, &log.data).unwrap_or(time_s);
                    differences((a, &log.data), (b, &again.data)).unwrap_or_default()
                }
                _ => Vec::new(),
            };
            if found.is_empty() {
                let [ours, theirs] = [log, again].map(|message| Leaf::Bytes(message.data.clone()));
                found.push(FieldDifference { field: "(bytes of the message)".to_string(), ours, theirs });
            }
        }
        for (field, a, b) in [
            ("(publish time, ns)", log.publish_time_ns, again.publish_time_ns),
            ("(sequence number)", log.sequence.into(), again.sequence.into()),
        ] {
            // A number of messages too many shifts all that follow: that says nothing about these.
            if a != b && found.is_empty() {
                let [ours, theirs] = [a, b].map(|value| Leaf::Whole(value.into()));
                found.push(FieldDifference { field: field.to_string(), ours, theirs });
            }
        }
        let all = found.into_iter().map(|FieldDifference { field, ours, theirs }| Difference {
            time_s,
            channel: topic.clone(),
            field,
            log: ours,
            again: theirs,
        });
        let all: Vec<Difference> = all.collect();
        self.count(&all);
        all.into_iter().next().unwrap_or_else(|| Difference {
            time_s,
            channel: topic.clone(),
            field: String::new(),
            log: Leaf::Absent,
            again: Leaf::Absent,
        })
    }

    fn count(&mut self, all: &[Difference]) {
        let mut counted: Vec<String> = Vec::new();
        for difference in all {
            let name = without_indices(&difference.field);
            let key = (difference.channel.clone(), name.clone());
            if self.fields.len() >= MOST_FIELDS && !self.fields.contains_key(&key) {
                continue;
            }
            let tally =
                self.fields.entry(key).or_insert_with(|| FieldTally { messages: 0, largest: difference.clone() });
            if difference.absolute() > tally.largest.absolute() {
                tally.largest = difference.clone();
            }
            // Entries of one list in one message count once.
            if !counted.contains(&name) {
                tally.messages += 1;
                counted.push(name);
            }
        }
    }
}

/// `transforms[3].rotation.z` as `transforms[].rotation.z`.
fn without_indices(field: &str) -> String {
    let mut name = String::with_capacity(field.len());
    let mut inside = false;
    for letter in field.chars() {
        inside &= letter != ']';
        if !inside {
            name.push(letter);
        }
        inside |= letter == '[';
    }
    name
}
