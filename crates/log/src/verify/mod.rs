//! Whether a log is what simulating again gives: both message by message, as they come, so that memory does not grow with
//! the log.
//!
//! As long as nothing differs, messages are compared in lockstep: channel, times, sequence number, every byte. Behind the
//! first difference the runs may have steps at other times, so messages are paired by log time and channel; what finds no
//! partner is counted.
//!
//! | file | job |
//! |---|---|
//! | `again` | the log of the new run, message by message |
//! | `fields` | two messages field by field |
//! | `tally` | differences in sum |

mod again;
mod fields;
mod tally;

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::io::{self, Read};

use self::again::{Again, Announced, Channel, Message};
pub use self::fields::Leaf;
use self::tally::Tally;
pub use self::tally::{Difference, FieldTally};
use super::reader::{LogSink, Record};
use super::recovered::{Check, Gap};
use phalanx_core::trace::SinkError;

/// Messages of one log time that are paired at once: steps of an impact can share one.
const GROUP: usize = 10_000;

/// Differences between schemas and channels that are told one by one.
const MOST_NOTES: usize = 100;

/// What is known of a log before it is compared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Expected {
    /// Messages from this log time on are not compared: they are what an interrupt left.
    pub before_ns: Option<u64>,
    /// Whether the log says how its run ended: the new run must end there too.
    pub ends: bool,
    /// Where messages are missing in a log that was recovered.
    pub gaps: Vec<Gap>,
}

/// How the comparison came out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verification {
    /// Pairs of messages that were compared, and those of them that are not the same.
    pub compared: u64,
    pub differing: u64,
    /// Messages without a partner.
    pub only_in_log: u64,
    pub only_again: u64,
    /// Messages at the end of the log that were not compared: an interrupt left them.
    pub not_compared: u64,
    /// Messages of the new run in the gaps of a recovered log.
    pub in_gaps: u64,
    pub channels: u64,
    /// Log time of the last message that was compared.
    pub up_to_s: Option<f64>,
    pub first: Option<Difference>,
    /// By channel and field.
    pub fields: BTreeMap<(String, String), FieldTally>,
    /// What differs in schemas and channels, in words.
    pub structure: Vec<String>,
    /// Entries of the metadata that differ: key, log, new run.
    pub metadata: Vec<(String, Option<String>, Option<String>)>,
}

/// Entries that say which program wrote a log: they may differ.
const VERSIONS: [&str; 4] = ["phalanx_version", "mcap_version", "libm_version", "rapier_version"];

impl Verification {
    /// Whether everything that was compared is the same, bit for bit.
    pub fn is_same(&self) -> bool {
        let settings = self.metadata.iter().filter(|(key, ..)| !VERSIONS.contains(&key.as_str())).count();
        self.differing + self.only_in_log + self.only_again == 0 && self.structure.is_empty() && settings == 0
    }
}

/// A [`LogSink`] that compares a log with the one of a new run.
pub struct Lockstep<'a, R> {
    again: Again<R>,
    announced: Announced,
    expected: Expected,
    tally: Tally,
    found: Verification,
    /// Messages of the log so far.
    index: u64,
    /// Behind the first difference: messages of the log of one log time.
    group: Option<Vec<Message>>,
    check: Check<'a>,
}

impl<'a, R: Read> Lockstep<'a, R> {
    /// Compares with the log in `source`; an error of `check` ends it.
    pub fn new(source: R, expected: Expected, check: Check<'a>) -> io::Result<Self> {
        Ok(Lockstep {
            again: Again::new(source)?,
            announced: Announced::default(),
            expected,
            tally: Tally::default(),
            found: Verification::default(),
            index: 0,
            group: None,
            check,
        })
    }

    /// How it came out, once the log has been gone through.
    pub fn finish(mut self) -> io::Result<Verification> {
        if let Some(group) = self.group.take() {
            self.pair(group)?;
        }
        if self.expected.ends && self.expected.before_ns.is_none() {
            while let Some(message) = self.again.take()? {
                self.extra(&message);
            }
        }
        // Channels that come later in the new run than in the log: a recovered one has them from its index.
        while self.again.take()?.is_some() {}
        self.structure();
        self.found.channels = self.announced.channels.len() as u64;
        self.found.fields = self.tally.fields;
        Ok(self.found)
    }

    fn metadata(&mut self, entries: &BTreeMap<String, String>) {
        let again = &self.again.metadata;
        let keys = entries.keys().chain(again.keys().filter(|key| !entries.contains_key(*key)));
        for key in keys {
            if entries.get(key) != again.get(key) {
                self.found.metadata.push((key.clone(), entries.get(key).cloned(), again.get(key).cloned()));
            }
        }
    }

    fn message(&mut self, message: Message) -> io::Result<()> {
        if self.expected.before_ns.is_some_and(|before_ns| message.log_time_ns >= before_ns) {
            self.found.not_compared += 1;
            return Ok(());
        }
        if self.expected.gaps.iter().any(|gap| gap.after_messages == self.index) && self.group.is_none() {
            self.skip_to(&message)?;
        }
        self.index += 1;
        match &mut self.group {
            None => {
                let same = self.again.peek().is_some_and(|again| self.is_same(&message, again));
                match same {
                    true => {
                        self.again.take()?;
                        self.compared(&message);
                    }
                    false => self.part(message),
                }
            }
            Some(group) => {
                let ends = group.first().is_some_and(|first| first.log_time_ns != message.log_time_ns);
                if ends || group.len() >= GROUP {
                    let full = std::mem::take(group);
                    self.pair(full)?;
                }
                if let Some(group) = &mut self.group {
                    group.push(message);
                }
            }
        }
        Ok(())
    }

    /// The first difference is here: from now on messages are paired.
    fn part(&mut self, message: Message) {
        let topic = self.announced.topic(message.channel);
        let time_s = message.log_time_ns as f64 * 1e-9;
        let here = |topic: &str, ns: u64| Leaf::Text(format!("{topic} at {:.9} s", ns as f64 * 1e-9));
        self.found.first = match self.again.peek() {
            Some(again)
                if self.again.announced.topic(again.channel) == topic && again.log_time_ns == message.log_time_ns =>
            {
                None
            }
            again => Some(Difference {
                time_s: again.map_or(time_s, |again| time_s.min(again.log_time_ns as f64 * 1e-9)),
                channel: topic.to_string(),
                field: "(which message comes next)".to_string(),
                log: here(topic, message.log_time_ns),
                again: again
                    .map_or(Leaf::Absent, |again| here(self.again.announced.topic(again.channel), again.log_time_ns)),
            }),
        };
        self.group = Some(vec![message]);
    }

    fn is_same(&self, log: &Message, again: &Message) -> bool {
        self.announced.topic(log.channel) == self.again.announced.topic(again.channel)
            && log.log_time_ns == again.log_time_ns
            && log.publish_time_ns == again.publish_time_ns
            && log.sequence == again.sequence
            && log.data == again.data
    }

    fn compared(&mut self, message: &Message) {
        self.found.compared += 1;
        let time_s = message.log_time_ns as f64 * 1e-9;
        self.found.up_to_s = Some(self.found.up_to_s.map_or(time_s, |latest| latest.max(time_s)));
    }

    /// A message that only the new run has.
    fn extra(&mut self, message: &Message) {
        self.found.only_again += 1;
        if self.found.first.is_none() {
            let topic = self.again.announced.topic(message.channel).to_string();
            self.found.first = Some(Difference {
                time_s: message.log_time_ns as f64 * 1e-9,
                log: Leaf::Absent,
                again: Leaf::Text(format!("{topic} at {:.9} s", message.log_time_ns as f64 * 1e-9)),
                channel: topic,
                field: "(which message comes next)".to_string(),
            });
        }
    }

    /// In the gap of a recovered log: goes on in the new run to the same message of the same channel.
    fn skip_to(&mut self, message: &Message) -> io::Result<()> {
        let topic = self.announced.topic(message.channel).to_string();
        while let Some(again) = self.again.peek() {
            let there = self.again.announced.topic(again.channel) == topic && again.sequence >= message.sequence;
            if there || again.log_time_ns > message.log_time_ns {
                break;
            }
            self.again.take()?;
            self.found.in_gaps += 1;
        }
        Ok(())
    }

    /// Pairs the messages of the log of one log time with those of the new run.
    fn pair(&mut self, group: Vec<Message>) -> io::Result<()> {
        let Some(time_ns) = group.first().map(|first| first.log_time_ns) else { return Ok(()) };
        let mut partners: HashMap<String, VecDeque<Message>> = HashMap::new();
        let mut count = 0;
        while let Some(again) = self.again.peek() {
            if again.log_time_ns > time_ns || count >= GROUP {
                break;
            }
            let Some(again) = self.again.take()? else { break };
            if again.log_time_ns < time_ns {
                self.extra(&again);
                continue;
            }
            count += 1;
            let topic = self.again.announced.topic(again.channel).to_string();
            partners.entry(topic).or_default().push_back(again);
        }
        for message in group {
            let topic = self.announced.topic(message.channel);
            match partners.get_mut(topic).and_then(VecDeque::pop_front) {
                None => self.found.only_in_log += 1,
                Some(again) => self.weigh(&message, &again),
            }
        }
        for again in partners.into_values().flatten() {
            self.extra(&again);
        }
        Ok(())
    }

    /// Compares two messages of one channel and one log time.
    fn weigh(&mut self, log: &Message, again: &Message) {
        self.compared(log);
        // Once a message is missing, all sequence numbers behind it differ: that is no difference of theirs.
        let numbered = self.found.first.is_some() || log.sequence == again.sequence;
        if log.data == again.data && log.publish_time_ns == again.publish_time_ns && numbered {
            return;
        }
        let channels = [self.announced.channels.get(&log.channel), self.again.announced.channels.get(&again.channel)];
        let [Some(ours), Some(theirs)] = channels else { return };
        self.found.differing += 1;
        let first = self.tally.take([log, again], [ours, theirs]);
        self.found.first.get_or_insert(first);
    }

    /// Compares schemas and channels.
    fn structure(&mut self) {
        let mut notes = Vec::new();
        for found in self.announced.channels.values() {
            match self.again.announced.by_topic(&found.topic) {
                Some(again) => notes.extend(apart(found, again)),
                None => notes.push(format!("only the log has the channel {}", found.topic)),
            }
        }
        // Of a log without messages the part that names the channels may be lost.
        if self.index > 0 {
            for channel in self.again.announced.channels.values() {
                if self.announced.by_topic(&channel.topic).is_none() {
                    notes.push(format!("only the new run has the channel {}", channel.topic));
                }
            }
        }
        notes.sort();
        notes.truncate(MOST_NOTES);
        self.found.structure = notes;
    }
}

/// In what a channel is another one in the new run.
fn apart(log: &Channel, again: &Channel) -> Vec<String> {
    let parts = [
        ("name of the schema", log.schema.name == again.schema.name),
        ("encoding of the schema", log.schema.encoding == again.schema.encoding),
        ("schema", log.schema.data == again.schema.data),
        ("encoding of the messages", log.encoding == again.encoding),
        ("metadata", log.metadata == again.metadata),
    ];
    let differing = parts.into_iter().filter(|(_, same)| !same);
    differing.map(|(what, _)| format!("the {what} of the channel {} is another one", log.topic)).collect()
}

impl<R: Read> LogSink for Lockstep<'_, R> {
    fn record(&mut self, record: &Record<'_>) -> Result<(), SinkError> {
        match record {
            Record::Metadata { name: super::METADATA_NAME, entries } => self.metadata(entries),
            Record::Schema(schema) => self.announced.schema(schema),
            Record::Channel(channel) => {
                self.announced.channel(channel);
            }
            Record::Message(message) => {
                (self.check)(message.log_time_ns)?;
                let what = "the comparison".to_string();
                self.message(Message::from(message)).map_err(|source| SinkError { what, source })?;
            }
            Record::Metadata { .. } | Record::Attachment(_) => {}
        }
        Ok(())
    }
}
