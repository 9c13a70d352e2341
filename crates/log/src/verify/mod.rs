//! Whether a log is what simulating again gives: both message by message, as they come, so that memory does not grow with
//! the log.
//!
//! Messages of one log time are compared channel by channel, whatever their order: times, sequence number, every byte. What finds no
//! partner is counted. A log without sequence numbers (they are all 0, as tools write that do not number) is compared without them, and
//! channels without messages do not count.
//!
//! | file | job |
//! |---|---|
//! | `again` | the log of the new run, message by message |
//! | `fields` | two messages field by field |
//! | `tally` | differences in sum |

mod again;
mod fields;
mod tally;

use std::collections::{BTreeMap, HashSet, VecDeque};
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
    /// Messages that the log has in another order, and those to which it gives no number.
    pub reordered: u64,
    pub unnumbered: u64,
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
    /// Messages of the log at the log time at hand that have found no partner yet.
    group: Vec<Message>,
    /// The same of the new run, by topic.
    waiting: BTreeMap<String, VecDeque<(usize, Message)>>,
    log_time_ns: u64,
    /// Channels of the log that have messages.
    spoken: HashSet<u16>,
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
            group: Vec::new(),
            waiting: BTreeMap::new(),
            log_time_ns: 0,
            spoken: HashSet::new(),
            check,
        })
    }

    /// How it came out, once the log has been gone through.
    pub fn finish(mut self) -> io::Result<Verification> {
        let ends = self.expected.ends && self.expected.before_ns.is_none();
        // Of a log that is cut off there may be more of its last time.
        if ends || !self.group.is_empty() {
            self.pair(ends)?;
        }
        if ends {
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
        if self.expected.gaps.iter().any(|gap| gap.after_messages == self.index) {
            if !self.group.is_empty() {
                self.pair(false)?;
            }
            self.found.in_gaps +=
                std::mem::take(&mut self.waiting).into_values().map(|queue| queue.len() as u64).sum::<u64>();
            self.skip_to(&message)?;
        } else if message.log_time_ns != self.log_time_ns {
            self.pair(true)?;
        } else if self.group.len() >= GROUP {
            self.pair(false)?;
        }
        self.log_time_ns = message.log_time_ns;
        self.index += 1;
        self.spoken.insert(message.channel);
        let in_step = self.group.is_empty() && self.waiting.is_empty();
        if in_step && self.again.peek().is_some_and(|again| self.is_same(&message, again)) {
            self.again.take()?;
            self.compared(&message);
        } else {
            self.group.push(message);
        }
        Ok(())
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
        let topic = self.again.announced.topic(message.channel).to_string();
        self.alone(topic, message.log_time_ns, false);
    }

    /// A message of `topic` without a partner, in the log or in the new run.
    fn alone(&mut self, topic: String, log_time_ns: u64, in_log: bool) {
        let time_s = log_time_ns as f64 * 1e-9;
        let [log, again] = [in_log, !in_log].map(|is_there| match is_there {
            true => Leaf::Text(format!("{topic} at {time_s:.9} s")),
            false => Leaf::Absent,
        });
        let field = "(which message comes next)".to_string();
        self.found.first.get_or_insert(Difference { time_s, channel: topic, field, log, again });
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

    /// Pairs the messages of the log of one log time with those of the new run. `all`: the log has no more of this time.
    fn pair(&mut self, all: bool) -> io::Result<()> {
        let time_ns = self.log_time_ns;
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
            self.waiting.entry(topic).or_default().push_back((count, again));
        }
        let mut latest = 0;
        for message in std::mem::take(&mut self.group) {
            let topic = self.announced.topic(message.channel);
            match self.waiting.get_mut(topic).and_then(|queue| partner(queue, &message)) {
                None => {
                    self.found.only_in_log += 1;
                    self.alone(topic.to_string(), time_ns, true);
                }
                Some((place, again)) => {
                    // The new run has it before one that came earlier in the log.
                    self.found.reordered += u64::from(place < latest);
                    latest = latest.max(place);
                    self.weigh(&message, &again);
                }
            }
        }
        self.waiting.retain(|_, queue| !queue.is_empty());
        if all {
            for (_, again) in std::mem::take(&mut self.waiting).into_values().flatten() {
                self.extra(&again);
            }
        }
        Ok(())
    }

    /// Compares two messages of one channel and one log time.
    fn weigh(&mut self, log: &Message, again: &Message) {
        self.compared(log);
        let unnumbered = log.sequence == 0 && again.sequence != 0;
        self.found.unnumbered += u64::from(unnumbered);
        // Once a message is missing, all sequence numbers behind it differ: that is no difference of theirs.
        let numbered = unnumbered || self.found.first.is_some() || log.sequence == again.sequence;
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
        for (id, found) in &self.announced.channels {
            match self.again.announced.by_topic(&found.topic) {
                Some(again) => notes.extend(apart(found, again)),
                None if self.spoken.contains(id) => notes.push(format!("only the log has the channel {}", found.topic)),
                None => {}
            }
        }
        // Of a log without messages the part that names the channels may be lost.
        if self.index > 0 {
            for (id, channel) in &self.again.announced.channels {
                if self.announced.by_topic(&channel.topic).is_none() && self.again.spoken.contains(id) {
                    notes.push(format!("only the new run has the channel {}", channel.topic));
                }
            }
        }
        notes.sort();
        notes.truncate(MOST_NOTES);
        self.found.structure = notes;
    }
}

/// The one among the messages of a channel that goes with this one: of the same bytes, or of the same number, or else the next.
fn partner(queue: &mut VecDeque<(usize, Message)>, log: &Message) -> Option<(usize, Message)> {
    let same = queue.iter().position(|(_, again)| again.data == log.data && again.sequence == log.sequence);
    let same = same.or_else(|| queue.iter().position(|(_, again)| again.data == log.data));
    let same = same.or_else(|| queue.iter().position(|(_, again)| again.sequence == log.sequence));
    queue.remove(same.unwrap_or(0))
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
