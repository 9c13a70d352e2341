//! Finds data missing in a log.
//!
//! A log with filtered topics is a valid MCAP file. Its expected contents follow from its list of subjects, or from the
//! attached scene, and from the messages: every sample has a message on each of its topics, sequence numbers are contiguous, every event is on `/event`
//! and is a line on `/events`, and the last line tells how the run ended.

use std::collections::BTreeMap;

use super::scan::SequenceStats;
use super::summary::{LogSummary, MissingData};
use crate::channels::{ChannelContent, Topic};
use phalanx_core::trace::Schema;
use phalanx_core::trace::schema::SubjectKind;

/// Counts the received components of samples, events and event lines.
pub(crate) struct MissingTracker {
    samples: u64,
    latest_s: f64,
    /// For each component: number of samples with it, and time of the first sample without it.
    received: Vec<(u64, Option<f64>)>,
    /// Number of events of each contact, for impacts and for friction.
    events: Vec<[u64; 2]>,
    /// Number of event lines of each contact, for impacts and for friction.
    lines: Vec<[u64; 2]>,
    /// Number of duplicate messages of each channel.
    duplicates: BTreeMap<u16, u64>,
}

impl MissingTracker {
    pub fn new(components: usize, contacts: usize) -> Self {
        MissingTracker {
            samples: 0,
            latest_s: 0.0,
            received: vec![(0, None); components],
            events: vec![[0; 2]; contacts],
            lines: vec![[0; 2]; contacts],
            duplicates: BTreeMap::new(),
        }
    }

    pub(crate) fn start_sample(&mut self, time_s: f64) {
        self.end_sample();
        self.samples += 1;
        self.latest_s = time_s;
    }

    fn end_sample(&mut self) {
        for (count, first_s) in &mut self.received {
            if *count < self.samples {
                first_s.get_or_insert(self.latest_s);
            }
        }
    }

    /// Counts a component of the current sample.
    pub(crate) fn count_component(&mut self, component: usize) {
        self.received[component].0 += 1;
    }

    pub(crate) fn count_event(&mut self, contact: usize, is_friction: bool) {
        self.events[contact][usize::from(is_friction)] += 1;
    }

    pub(crate) fn count_line(&mut self, contact: usize, is_friction: bool) {
        self.lines[contact][usize::from(is_friction)] += 1;
    }

    pub(crate) fn count_duplicate(&mut self, channel: u16) {
        *self.duplicates.entry(channel).or_default() += 1;
    }

    /// Returns the missing data after the log has been read to its end. `sequences` are the sequence numbers of the
    /// known channels.
    pub fn missing(
        mut self,
        summary: &LogSummary,
        topics: Vec<Topic>,
        schema: &Schema,
        sequences: &BTreeMap<u16, SequenceStats>,
    ) -> Vec<MissingData> {
        self.end_sample();
        // Sequence numbers start at 0 on every channel. Tools that rewrite a log may number differently, or not at all.
        let are_numbered = sequences.values().filter(|stats| stats.min_sequence == 0).count() > 1
            && sequences.values().any(|stats| stats.max_sequence > 0);
        let has_messages = |topic: &Topic| topic.channels.iter().any(|id| sequences.contains_key(id));
        let has_lines = topics.iter().any(|topic| topic.content == ChannelContent::Lines && has_messages(topic));
        let mut found = Vec::new();
        for topic in topics {
            let Topic { content, ref channels, .. } = topic;
            let is_empty = !has_messages(&topic);
            let defect = match content {
                ChannelContent::Lines => self.missing_lines(summary, is_empty),
                ChannelContent::Events => self.missing_events(channels.is_empty() && !has_lines),
                ChannelContent::Subject { index, .. } => self.missing_components(summary, index, is_empty),
            };
            let defect = defect.or_else(|| {
                channels.iter().filter(|_| are_numbered).find_map(|id| {
                    // Identical messages count once.
                    sequence_gaps(sequences.get(id)?, self.duplicates.get(id).copied().unwrap_or(0))
                })
            });
            let is_required_for_verdict = is_required_for_verdict(schema, content);
            found.extend(defect.map(|defect| MissingData {
                topic: topic.name,
                defect,
                content,
                is_required_for_verdict,
            }));
        }
        found.extend(time_gaps(summary).into_iter().map(|defect| MissingData {
            topic: "every topic".to_string(),
            defect,
            content: ChannelContent::Lines,
            is_required_for_verdict: true,
        }));
        found
    }

    /// Describes messages missing on a topic that has one per sample.
    fn missing_components(&self, summary: &LogSummary, subject: usize, is_empty: bool) -> Option<String> {
        // A run that stopped before its first sample has no samples; a truncated log may have none.
        let stopped = summary.run_end.as_ref().is_some_and(|run_end| run_end.stopped.is_some());
        if is_empty && (summary.samples > 0 || !stopped && summary.is_read_to_end()) {
            return Some("has no message".to_string());
        }
        let (received, first_s) = self.received[subject];
        let (missing, samples, first_ms) = (self.samples - received.min(self.samples), self.samples, first_s? * 1e3);
        (missing > 0).then(|| format!("lacks {missing} of {samples} messages, the first at {first_ms:.6} ms"))
    }

    /// Describes events that have a line but no message.
    fn missing_events(&self, is_unknown: bool) -> Option<String> {
        if is_unknown {
            return Some("has no message, and /events does not tell whether there were events".to_string());
        }
        let pairs = self.lines.iter().flatten().zip(self.events.iter().flatten());
        let missing: u64 = pairs.map(|(lines, events)| lines.saturating_sub(*events)).sum();
        let lines: u64 = self.lines.iter().flatten().sum();
        (missing > 0).then(|| format!("lacks {missing} of {lines} events that are on /events"))
    }

    /// Describes missing event lines, or a missing line about the end of the run.
    fn missing_lines(&self, summary: &LogSummary, is_empty: bool) -> Option<String> {
        if is_empty {
            return summary.is_read_to_end().then(|| "has no message".to_string());
        }
        let pairs = || self.events.iter().flatten().zip(self.lines.iter().flatten());
        let without_line: u64 = pairs().map(|(events, lines)| events.saturating_sub(*lines)).sum();
        if without_line > 0 {
            let events: u64 = pairs().map(|(events, _)| events).sum();
            return Some(format!("lacks {without_line} of {events} events that are on other topics"));
        }
        (summary.is_read_to_end() && summary.run_end.is_none()).then(|| "does not say how the run ended".to_string())
    }
}

/// Whether class and fate depend on a channel. They do not depend on energies, nor for a single finger on the joint
/// limit.
fn is_required_for_verdict(schema: &Schema, content: ChannelContent) -> bool {
    match content {
        ChannelContent::Subject { kind: SubjectKind::Energy, .. } => false,
        ChannelContent::Subject { kind: SubjectKind::Limit, .. } => schema.fingers.len() != 1,
        _ => true,
    }
}

/// Whether a channel has more messages than sequence numbers.
pub fn has_duplicates(sequences: &BTreeMap<u16, SequenceStats>) -> bool {
    sequences.values().any(|stats| stats.messages > u64::from(stats.max_sequence) + 1 && stats.max_sequence > 0)
}

/// Describes missing or surplus messages of a channel by its sequence numbers.
fn sequence_gaps(stats: &SequenceStats, duplicates: u64) -> Option<String> {
    let (expected, messages) = (u64::from(stats.max_sequence) + 1, stats.messages - duplicates);
    match messages {
        // The messages are not numbered.
        _ if stats.max_sequence == 0 && messages > 1 => None,
        count if count < expected => {
            Some(format!("lacks {} of {expected} messages according to their sequence numbers", expected - count))
        }
        count if count > expected => Some(format!(
            "has {} more messages than sequence numbers: other messages were merged into it",
            count - expected
        )),
        _ => None,
    }
}

/// Describes a late start or early end, as in an excerpt of a longer log.
fn time_gaps(summary: &LogSummary) -> Vec<String> {
    let mut found = Vec::new();
    let ms = |time_s: f64| format!("{:.6} ms", time_s * 1e3);
    if let Some(first_s) = summary.first_s.filter(|first_s| *first_s > 0.0) {
        found.push(format!("has no message before {}", ms(first_s)));
    }
    let completed = summary.run_end.as_ref().filter(|run_end| run_end.stopped.is_none());
    // Log times are whole nanoseconds.
    if let Some((run_end, last_s)) = completed.zip(summary.last_s)
        && run_end.time_s - last_s > 1e-9 + 1e-12 * last_s
    {
        found.push(format!("has no message between {} and the end of the run at {}", ms(last_s), ms(run_end.time_s)));
    }
    found
}
