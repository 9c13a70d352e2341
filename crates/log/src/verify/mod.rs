//! Compares a log with the log of a new simulation, message by message while streaming, so memory does not grow with
//! the log.
//!
//! Messages of one log time are compared per channel in any order: times, sequence number, every byte. Unmatched
//! messages are counted. A log without sequence numbers (all 0, as some tools write) is compared without them, and
//! channels without messages are ignored.
//!
//! | file | job |
//! |---|---|
//! | `rerun` | the log of the new run, message by message |
//! | `fields` | differences of two messages by field |
//! | `tally` | total differences |

mod fields;
mod rerun;
mod tally;

use std::collections::{BTreeMap, HashSet, VecDeque};
use std::io::{self, Read};

pub use self::fields::FieldValue;
use self::rerun::{Channel, Definitions, Message, RerunLog};
use self::tally::Tally;
pub use self::tally::{Difference, FieldTally};
use super::reader::{LogSink, Record};
use super::recovered::{Gap, ProgressCheck};
use phalanx_core::trace::SinkError;

/// Maximum number of messages of one log time that are matched at once; steps of an impact can share a log time.
const MAX_GROUP_MESSAGES: usize = 10_000;

/// Maximum number of reported differences of schemas and channels.
const MAX_SCHEMA_DIFFERENCES: usize = 100;

/// Range and properties of the log to compare.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComparisonOptions {
    /// Messages from this log time on are not compared, because an interrupt ended the run there.
    pub before_ns: Option<u64>,
    /// Whether the log contains the end of its run: the new run must end there too.
    pub has_run_end: bool,
    /// Gaps of a recovered log.
    pub gaps: Vec<Gap>,
}

/// Result of a comparison.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verification {
    /// Number of compared pairs of messages.
    pub compared: u64,
    /// Number of differing pairs.
    pub differing: u64,
    /// Unmatched messages.
    pub only_in_log: u64,
    pub only_in_rerun: u64,
    /// Messages in a different order in the log.
    pub reordered: u64,
    /// Messages without a sequence number in the log.
    pub unnumbered: u64,
    /// Messages at the end of the log that were not compared because of an interrupt.
    pub not_compared: u64,
    /// Messages of the new run in the gaps of a recovered log.
    pub in_gaps: u64,
    pub channels: u64,
    /// Log time of the last message that was compared.
    pub last_compared_s: Option<f64>,
    pub first: Option<Difference>,
    /// Tallies of the fields, by channel and field.
    pub fields: BTreeMap<(String, String), FieldTally>,
    /// Differences of schemas and channels, as sentences.
    pub schema_differences: Vec<String>,
    /// Entries of the metadata that differ: key, log, new run.
    pub metadata: Vec<(String, Option<String>, Option<String>)>,
}

/// Entries that identify the program that wrote a log; they may differ.
const VERSIONS: [&str; 4] = ["phalanx_version", "mcap_version", "libm_version", "rapier_version"];

impl Verification {
    /// Whether all compared data is identical, bit for bit.
    pub fn is_same(&self) -> bool {
        let settings = self.metadata.iter().filter(|(key, ..)| !VERSIONS.contains(&key.as_str())).count();
        self.differing + self.only_in_log + self.only_in_rerun == 0
            && self.schema_differences.is_empty()
            && settings == 0
    }
}

/// A [`LogSink`] that compares a log with the log of a new run.
pub struct LogComparison<'a, R> {
    rerun: RerunLog<R>,
    definitions: Definitions,
    options: ComparisonOptions,
    tally: Tally,
    result: Verification,
    /// Number of messages of the log so far.
    message_count: u64,
    /// Unmatched messages of the log at the current log time.
    group: Vec<Message>,
    /// Unmatched messages of the new run at that time, by topic, with their rank.
    unmatched: BTreeMap<String, VecDeque<(usize, Message)>>,
    log_time_ns: u64,
    /// Channels of the log that have messages.
    active_channels: HashSet<u16>,
    check: ProgressCheck<'a>,
}

impl<'a, R: Read> LogComparison<'a, R> {
    /// Compares with the log of the new run in `source`; an error of `check` ends the comparison.
    pub fn new(source: R, options: ComparisonOptions, check: ProgressCheck<'a>) -> io::Result<Self> {
        Ok(LogComparison {
            rerun: RerunLog::new(source)?,
            definitions: Definitions::default(),
            options,
            tally: Tally::default(),
            result: Verification::default(),
            message_count: 0,
            group: Vec::new(),
            unmatched: BTreeMap::new(),
            log_time_ns: 0,
            active_channels: HashSet::new(),
            check,
        })
    }

    /// Returns the result, after the log was read.
    pub fn finish(mut self) -> io::Result<Verification> {
        let has_run_end = self.options.has_run_end && self.options.before_ns.is_none();
        // A truncated log may lack messages of its last log time.
        if has_run_end || !self.group.is_empty() {
            self.match_group(has_run_end)?;
        }
        if has_run_end {
            while let Some(message) = self.rerun.next_message()? {
                self.count_extra(&message);
            }
        }
        // Read the remaining channels of the new run: a recovered log may have them earlier, from its index.
        while self.rerun.next_message()?.is_some() {}
        self.compare_channels();
        self.result.channels = self.definitions.channels.len() as u64;
        self.result.fields = self.tally.fields;
        Ok(self.result)
    }

    fn metadata(&mut self, entries: &BTreeMap<String, String>) {
        let rerun = &self.rerun.metadata;
        let keys = entries.keys().chain(rerun.keys().filter(|key| !entries.contains_key(*key)));
        for key in keys {
            if entries.get(key) != rerun.get(key) {
                self.result.metadata.push((key.clone(), entries.get(key).cloned(), rerun.get(key).cloned()));
            }
        }
    }

    fn message(&mut self, message: Message) -> io::Result<()> {
        if self.options.before_ns.is_some_and(|before_ns| message.log_time_ns >= before_ns) {
            self.result.not_compared += 1;
            return Ok(());
        }
        if self.options.gaps.iter().any(|gap| gap.after_messages == self.message_count) {
            if !self.group.is_empty() {
                self.match_group(false)?;
            }
            self.result.in_gaps +=
                std::mem::take(&mut self.unmatched).into_values().map(|queue| queue.len() as u64).sum::<u64>();
            self.skip_to(&message)?;
        } else if message.log_time_ns != self.log_time_ns {
            self.match_group(true)?;
        } else if self.group.len() >= MAX_GROUP_MESSAGES {
            self.match_group(false)?;
        }
        self.log_time_ns = message.log_time_ns;
        self.message_count += 1;
        self.active_channels.insert(message.channel);
        let is_in_lockstep = self.group.is_empty() && self.unmatched.is_empty();
        if is_in_lockstep && self.rerun.peek().is_some_and(|rerun| self.is_same(&message, rerun)) {
            self.rerun.next_message()?;
            self.count_compared(&message);
        } else {
            self.group.push(message);
        }
        Ok(())
    }

    fn is_same(&self, log: &Message, rerun: &Message) -> bool {
        self.definitions.topic(log.channel) == self.rerun.definitions.topic(rerun.channel)
            && log.log_time_ns == rerun.log_time_ns
            && log.publish_time_ns == rerun.publish_time_ns
            && log.sequence == rerun.sequence
            && log.data == rerun.data
    }

    fn count_compared(&mut self, message: &Message) {
        self.result.compared += 1;
        let time_s = message.log_time_ns as f64 * 1e-9;
        self.result.last_compared_s = Some(self.result.last_compared_s.map_or(time_s, |latest| latest.max(time_s)));
    }

    /// Counts a message that only the new run has.
    fn count_extra(&mut self, message: &Message) {
        self.result.only_in_rerun += 1;
        let topic = self.rerun.definitions.topic(message.channel).to_string();
        self.record_unmatched(topic, message.log_time_ns, false);
    }

    /// Records an unmatched message of the log or the new run as the first difference, if there is none yet.
    fn record_unmatched(&mut self, topic: String, log_time_ns: u64, in_log: bool) {
        let time_s = log_time_ns as f64 * 1e-9;
        let [log, rerun] = [in_log, !in_log].map(|exists| match exists {
            true => FieldValue::Text(format!("{topic} at {time_s:.9} s")),
            false => FieldValue::Missing,
        });
        let field = "(which message comes next)".to_string();
        self.result.first.get_or_insert(Difference { time_s, channel: topic, field, log, rerun });
    }

    /// After a gap of a recovered log: skips to the same message of the same channel in the new run.
    fn skip_to(&mut self, message: &Message) -> io::Result<()> {
        let topic = self.definitions.topic(message.channel).to_string();
        while let Some(rerun) = self.rerun.peek() {
            let is_match = self.rerun.definitions.topic(rerun.channel) == topic && rerun.sequence >= message.sequence;
            if is_match || rerun.log_time_ns > message.log_time_ns {
                break;
            }
            self.rerun.next_message()?;
            self.result.in_gaps += 1;
        }
        Ok(())
    }

    /// Matches the messages of the current log time with the new run. `all`: the log has no more messages of this time.
    fn match_group(&mut self, all: bool) -> io::Result<()> {
        let time_ns = self.log_time_ns;
        let mut count = 0;
        while let Some(rerun) = self.rerun.peek() {
            if rerun.log_time_ns > time_ns || count >= MAX_GROUP_MESSAGES {
                break;
            }
            let Some(rerun) = self.rerun.next_message()? else { break };
            if rerun.log_time_ns < time_ns {
                self.count_extra(&rerun);
                continue;
            }
            count += 1;
            let topic = self.rerun.definitions.topic(rerun.channel).to_string();
            self.unmatched.entry(topic).or_default().push_back((count, rerun));
        }
        let mut max_rank = 0;
        for message in std::mem::take(&mut self.group) {
            let topic = self.definitions.topic(message.channel);
            match self.unmatched.get_mut(topic).and_then(|queue| take_match(queue, &message)) {
                None => {
                    self.result.only_in_log += 1;
                    self.record_unmatched(topic.to_string(), time_ns, true);
                }
                Some((rank, rerun)) => {
                    // In the new run it precedes a message that is earlier in the log.
                    self.result.reordered += u64::from(rank < max_rank);
                    max_rank = max_rank.max(rank);
                    self.compare(&message, &rerun);
                }
            }
        }
        self.unmatched.retain(|_, queue| !queue.is_empty());
        if all {
            for (_, rerun) in std::mem::take(&mut self.unmatched).into_values().flatten() {
                self.count_extra(&rerun);
            }
        }
        Ok(())
    }

    /// Compares two messages of one channel and one log time.
    fn compare(&mut self, log: &Message, rerun: &Message) {
        self.count_compared(log);
        let unnumbered = log.sequence == 0 && rerun.sequence != 0;
        self.result.unnumbered += u64::from(unnumbered);
        // After a missing message all later sequence numbers differ; these differences are not counted.
        let has_same_number = unnumbered || self.result.first.is_some() || log.sequence == rerun.sequence;
        if log.data == rerun.data && log.publish_time_ns == rerun.publish_time_ns && has_same_number {
            return;
        }
        let channels =
            [self.definitions.channels.get(&log.channel), self.rerun.definitions.channels.get(&rerun.channel)];
        let [Some(log_channel), Some(rerun_channel)] = channels else { return };
        self.result.differing += 1;
        let first = self.tally.compare([log, rerun], [log_channel, rerun_channel]);
        self.result.first.get_or_insert(first);
    }

    /// Compares schemas and channels.
    fn compare_channels(&mut self) {
        let mut differences = Vec::new();
        for (id, found) in &self.definitions.channels {
            match self.rerun.definitions.by_topic(&found.topic) {
                Some(rerun) => differences.extend(describe_channel_differences(found, rerun)),
                None if self.active_channels.contains(id) => {
                    differences.push(format!("only the log has the channel {}", found.topic))
                }
                None => {}
            }
        }
        // A log without messages may have lost its channel records.
        if self.message_count > 0 {
            for (id, channel) in &self.rerun.definitions.channels {
                if self.definitions.by_topic(&channel.topic).is_none() && self.rerun.active_channels.contains(id) {
                    differences.push(format!("only the new run has the channel {}", channel.topic));
                }
            }
        }
        differences.sort();
        differences.truncate(MAX_SCHEMA_DIFFERENCES);
        self.result.schema_differences = differences;
    }
}

/// Removes and returns the matching message of a channel: same bytes, or same sequence number, or else the first.
fn take_match(queue: &mut VecDeque<(usize, Message)>, log: &Message) -> Option<(usize, Message)> {
    let same = queue.iter().position(|(_, rerun)| rerun.data == log.data && rerun.sequence == log.sequence);
    let same = same.or_else(|| queue.iter().position(|(_, rerun)| rerun.data == log.data));
    let same = same.or_else(|| queue.iter().position(|(_, rerun)| rerun.sequence == log.sequence));
    queue.remove(same.unwrap_or(0))
}

/// Describes the differences of a channel between the log and the new run.
fn describe_channel_differences(log: &Channel, rerun: &Channel) -> Vec<String> {
    let aspects = [
        ("name of the schema", log.schema.name == rerun.schema.name),
        ("encoding of the schema", log.schema.encoding == rerun.schema.encoding),
        ("schema", log.schema.data == rerun.schema.data),
        ("encoding of the messages", log.encoding == rerun.encoding),
        ("metadata", log.metadata == rerun.metadata),
    ];
    let differing = aspects.into_iter().filter(|(_, same)| !same);
    differing.map(|(aspect, _)| format!("the {aspect} of the channel {} differs", log.topic)).collect()
}

impl<R: Read> LogSink for LogComparison<'_, R> {
    fn record(&mut self, record: &Record<'_>) -> Result<(), SinkError> {
        match record {
            Record::Metadata { name: super::METADATA_NAME, entries } => self.metadata(entries),
            Record::Schema(schema) => self.definitions.schema(schema),
            Record::Channel(channel) => {
                self.definitions.channel(channel);
            }
            Record::Message(message) => {
                (self.check)(message.log_time_ns)?;
                let sink_name = "the comparison".to_string();
                self.message(Message::from(message)).map_err(|source| SinkError { target: sink_name, source })?;
            }
            Record::Metadata { .. } | Record::Attachment(_) => {}
        }
        Ok(())
    }
}
