//! Total differences of two runs by field: number of messages and largest difference.

use std::collections::BTreeMap;

use prost_reflect::MessageDescriptor;

use super::fields::{FieldDifference, FieldValue, descriptor, differences, timestamp_s};
use super::rerun::{Channel, Message};

/// Maximum number of fields reported separately; differences in further fields count only as differing messages.
const MAX_FIELDS: usize = 10_000;

/// A difference of one field.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Time of the message; unrounded if it has a field `timestamp`.
    pub time_s: f64,
    pub channel: String,
    pub field: String,
    pub log: FieldValue,
    pub rerun: FieldValue,
}

impl Difference {
    /// |log − again|, if both are numbers.
    pub fn absolute(&self) -> Option<f64> {
        Some((self.log.number()? - self.rerun.number()?).abs())
    }

    /// Returns the absolute difference relative to the larger of the two.
    pub fn relative(&self) -> Option<f64> {
        let scale = self.log.number()?.abs().max(self.rerun.number()?.abs());
        self.absolute().filter(|_| scale > 0.0).map(|absolute| absolute / scale)
    }
}

/// Differences of one field of a channel, over all list entries.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldTally {
    /// Number of messages that differ in this field.
    pub messages: u64,
    /// Largest difference, if the values are numbers.
    pub largest: Difference,
}

/// All differences by channel and field.
#[derive(Debug, Default)]
pub struct Tally {
    pub fields: BTreeMap<(String, String), FieldTally>,
    descriptors: BTreeMap<String, [Option<MessageDescriptor>; 2]>,
}

impl Tally {
    /// Counts the differences of two differing messages of a channel and returns the first one.
    pub fn compare(&mut self, [log, rerun]: [&Message; 2], [log_channel, rerun_channel]: [&Channel; 2]) -> Difference {
        let topic = &log_channel.topic;
        let descriptors = self.descriptors.entry(topic.clone()).or_insert_with(|| {
            [log_channel, rerun_channel].map(|channel| descriptor(&channel.schema.name, &channel.schema.data))
        });
        let mut time_s = log.log_time_ns as f64 * 1e-9;
        let mut found = Vec::new();
        if log.data != rerun.data {
            found = match descriptors {
                [Some(a), Some(b)] => {
                    time_s = timestamp_s(a, &log.data).unwrap_or(time_s);
                    differences((a, &log.data), (b, &rerun.data)).unwrap_or_default()
                }
                _ => Vec::new(),
            };
            if found.is_empty() {
                let [log_value, rerun_value] = [log, rerun].map(|message| FieldValue::Bytes(message.data.clone()));
                found.push(FieldDifference { field: "(bytes of the message)".to_string(), log_value, rerun_value });
            }
        }
        for (field, a, b) in [
            ("(publish time, ns)", log.publish_time_ns, rerun.publish_time_ns),
            ("(sequence number)", log.sequence.into(), rerun.sequence.into()),
        ] {
            // A surplus message shifts all later sequence numbers; this is not a difference of the fields.
            if a != b && found.is_empty() {
                let [log_value, rerun_value] = [a, b].map(|value| FieldValue::Integer(value.into()));
                found.push(FieldDifference { field: field.to_string(), log_value, rerun_value });
            }
        }
        let all = found.into_iter().map(|FieldDifference { field, log_value, rerun_value }| Difference {
            time_s,
            channel: topic.clone(),
            field,
            log: log_value,
            rerun: rerun_value,
        });
        let all: Vec<Difference> = all.collect();
        self.count(&all);
        all.into_iter().next().unwrap_or_else(|| Difference {
            time_s,
            channel: topic.clone(),
            field: String::new(),
            log: FieldValue::Missing,
            rerun: FieldValue::Missing,
        })
    }

    fn count(&mut self, all: &[Difference]) {
        let mut counted_names: Vec<String> = Vec::new();
        for difference in all {
            let name = without_indices(&difference.field);
            let key = (difference.channel.clone(), name.clone());
            if self.fields.len() >= MAX_FIELDS && !self.fields.contains_key(&key) {
                continue;
            }
            let tally =
                self.fields.entry(key).or_insert_with(|| FieldTally { messages: 0, largest: difference.clone() });
            if difference.absolute() > tally.largest.absolute() {
                tally.largest = difference.clone();
            }
            // Entries of one list in a message count once.
            if !counted_names.contains(&name) {
                tally.messages += 1;
                counted_names.push(name);
            }
        }
    }
}

/// Removes list indices: `transforms[3].rotation.z` becomes `transforms[].rotation.z`.
fn without_indices(field: &str) -> String {
    let mut name = String::with_capacity(field.len());
    let mut is_inside_brackets = false;
    for letter in field.chars() {
        is_inside_brackets &= letter != ']';
        if !is_inside_brackets {
            name.push(letter);
        }
        is_inside_brackets |= letter == '[';
    }
    name
}
