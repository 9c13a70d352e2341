//! Finds data missing in a log.
//!
//! A log with filtered topics is a valid MCAP file. Its expected contents follow from the attached scene and from the
//! log itself: every sample has a message on each of its topics, sequence numbers are contiguous, every event is on the
//! topic of its contact and is a line on `/events`, and the last line tells how the run ended.

use std::collections::BTreeMap;

use super::channels::{ChannelContent, Channels, component_index};
use super::summary::{LogSummary, MissingData, TopicSubject};
use super::survey::SequenceStats;
use crate::channels::Topics;
use phalanx_core::scene::keywords::SceneKind;
use phalanx_core::trace::Layout;

impl From<ChannelContent> for TopicSubject {
    fn from(content: ChannelContent) -> Self {
        match content {
            ChannelContent::Finger(index) => TopicSubject::Finger(index),
            ChannelContent::Body(index) => TopicSubject::Body(index),
            ChannelContent::Contact(index)
            | ChannelContent::Limit(index)
            | ChannelContent::Impact(index)
            | ChannelContent::Slip(index) => TopicSubject::Contact(index),
            ChannelContent::Energy => TopicSubject::Energy,
            ChannelContent::Lines | ChannelContent::Picture => TopicSubject::Run,
        }
    }
}

/// Counts the received components of samples, events and event lines.
pub struct MissingTracker {
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

    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Starts a sample.
    pub fn sample(&mut self, time_s: f64) {
        self.close();
        self.samples += 1;
        self.latest_s = time_s;
    }

    /// Counts a component of the current sample.
    pub fn component(&mut self, component: usize) {
        self.received[component].0 += 1;
    }

    pub fn event(&mut self, contact: usize, is_friction: bool) {
        self.events[contact][usize::from(is_friction)] += 1;
    }

    pub fn line(&mut self, contact: usize, is_friction: bool) {
        self.lines[contact][usize::from(is_friction)] += 1;
    }

    /// Counts a duplicate message.
    pub fn duplicate(&mut self, channel: u16) {
        *self.duplicates.entry(channel).or_default() += 1;
    }

    /// Ends the current sample.
    pub fn close(&mut self) {
        for (count, first_s) in &mut self.received {
            if *count < self.samples && first_s.is_none() {
                *first_s = Some(self.latest_s);
            }
        }
    }
}

/// Returns the expected topics of a log and their content. Without `topics` of a scene, these are the topics that every
/// log of this kind has.
pub fn expected_topics(kind: SceneKind, topics: Option<&Topics>) -> Vec<(String, ChannelContent)> {
    let mut all = Vec::new();
    match topics {
        Some(Topics { fingers, bodies, contacts }) => {
            all.extend(fingers.iter().enumerate().map(|(index, topic)| (topic.clone(), ChannelContent::Finger(index))));
            all.extend(bodies.iter().enumerate().map(|(index, topic)| (topic.clone(), ChannelContent::Body(index))));
            for (index, contact) in contacts.iter().enumerate() {
                all.extend(contact.iter().map(|contact| (contact.samples.clone(), ChannelContent::Contact(index))));
            }
            for (index, contact) in contacts.iter().enumerate() {
                all.extend(contact.iter().map(|contact| (contact.impact.clone(), ChannelContent::Impact(index))));
                all.extend(
                    contact.iter().filter_map(|contact| Some((contact.slip.clone()?, ChannelContent::Slip(index)))),
                );
            }
        }
        None => match kind {
            SceneKind::Finger => all.push(("/state".to_string(), ChannelContent::Finger(0))),
            SceneKind::Gripper => {
                all.push(("/state/right".to_string(), ChannelContent::Finger(0)));
                all.push(("/state/left".to_string(), ChannelContent::Finger(1)));
                all.push(("/object".to_string(), ChannelContent::Body(0)));
            }
            SceneKind::Bodies => {}
        },
    }
    all.push(("/energy".to_string(), ChannelContent::Energy));
    all.push(("/events".to_string(), ChannelContent::Lines));
    all
}

/// Returns the data missing in a log, after it was read to its end.
pub fn missing(
    summary: &LogSummary,
    expected_topics: &[(String, ChannelContent)],
    channels: &Channels,
    sequence_stats: &BTreeMap<u16, SequenceStats>,
    tracker: &mut MissingTracker,
) -> Vec<MissingData> {
    tracker.close();
    let tracker = &*tracker;
    let layout = channels.layout();
    let mut topics = expected_topics.to_vec();
    for (_, topic, content) in channels.topics() {
        if !topics.iter().any(|(known, _)| known == topic) {
            topics.push((topic.clone(), *content));
        }
    }
    // Identical messages count once.
    let without_duplicates = |id: &u16| {
        let stats = sequence_stats.get(id)?;
        let duplicates = tracker.duplicates.get(id).copied().unwrap_or(0);
        Some(SequenceStats { messages: stats.messages - duplicates, ..*stats })
    };
    let messages = |topic: &str| -> Vec<SequenceStats> {
        channels
            .topics()
            .iter()
            .filter(|(_, known, _)| known == topic)
            .filter_map(|(id, ..)| without_duplicates(id))
            .collect()
    };
    let are_sequences_numbered = are_sequences_numbered(channels, sequence_stats) && summary.recovered.is_none();
    // A run that stopped before its first sample has no samples; a truncated log may have none.
    let stopped = summary.run_end.as_ref().is_some_and(|run_end| run_end.stopped.is_some());
    let may_be_empty = summary.samples == 0 && (stopped || !summary.is_complete());
    let mut found = Vec::new();
    for (topic, content) in &topics {
        let stats = messages(topic);
        let defect = match content {
            ChannelContent::Picture => None,
            _ if component_index(layout, *content).is_some() => {
                let (received, first_s) =
                    component_index(layout, *content).map_or((0, None), |component| tracker.received[component]);
                describe_missing_components(received, tracker.samples, first_s, stats.is_empty(), may_be_empty)
            }
            ChannelContent::Impact(index) => describe_missing_events(tracker, *index, false),
            ChannelContent::Slip(index) => describe_missing_events(tracker, *index, true),
            _ => describe_missing_lines(summary, tracker, stats.is_empty()),
        };
        let has_sequence_numbers = are_sequences_numbered && *content != ChannelContent::Picture;
        let defect = defect.or_else(|| stats.iter().filter(|_| has_sequence_numbers).find_map(describe_sequence_gaps));
        found.extend(defect.map(|defect| MissingData {
            topic: topic.clone(),
            defect,
            subject: (*content).into(),
            is_required_for_verdict: is_required_for_verdict(layout, *content),
        }));
    }
    found.extend(describe_time_gaps(summary).into_iter().map(|defect| MissingData {
        topic: "every topic".to_string(),
        defect,
        subject: TopicSubject::Run,
        is_required_for_verdict: true,
    }));
    found
}

/// Whether class and fate depend on a channel. They do not depend on energies or slip events, nor for a single finger
/// on the joint limit.
fn is_required_for_verdict(layout: &Layout, content: ChannelContent) -> bool {
    let is_limit = |index: usize| {
        layout.fingers.len() == 1 && layout.contacts.get(index).is_some_and(|contact| contact.is_angular)
    };
    match content {
        ChannelContent::Energy | ChannelContent::Slip(_) | ChannelContent::Picture => false,
        ChannelContent::Contact(index) | ChannelContent::Limit(index) | ChannelContent::Impact(index) => {
            !is_limit(index)
        }
        ChannelContent::Finger(_) | ChannelContent::Body(_) | ChannelContent::Lines => true,
    }
}

/// Describes messages missing on a topic that has one per sample.
fn describe_missing_components(
    received: u64,
    samples: u64,
    first_s: Option<f64>,
    is_empty: bool,
    may_be_empty: bool,
) -> Option<String> {
    match first_s {
        _ if is_empty && !may_be_empty => Some("has no message".to_string()),
        Some(first_s) if received < samples => {
            let from = format!("the first at {:.6} ms", first_s * 1e3);
            Some(format!("lacks {} of {samples} messages, {from}", samples - received))
        }
        _ => None,
    }
}

/// Describes events that have a line but no message.
fn describe_missing_events(tracker: &MissingTracker, contact: usize, is_friction: bool) -> Option<String> {
    let [lines, events] = [&tracker.lines, &tracker.events].map(|all| all[contact][usize::from(is_friction)]);
    let missing = lines.saturating_sub(events);
    (missing > 0).then(|| format!("lacks {missing} of {lines} events that are on /events"))
}

/// Describes missing event lines, or a missing line about the end of the run.
fn describe_missing_lines(summary: &LogSummary, tracker: &MissingTracker, is_empty: bool) -> Option<String> {
    if is_empty {
        return summary.is_complete().then(|| "has no message".to_string());
    }
    let sum = |all: &[[u64; 2]]| all.iter().flatten().sum::<u64>();
    let without_line: u64 = tracker
        .events
        .iter()
        .flatten()
        .zip(tracker.lines.iter().flatten())
        .map(|(events, lines)| events.saturating_sub(*lines))
        .sum();
    if without_line > 0 {
        return Some(format!("lacks {without_line} of {} events that are on other topics", sum(&tracker.events)));
    }
    let should_end = summary.is_complete() && summary.recovered.is_none();
    (should_end && summary.run_end.is_none()).then(|| "does not say how the run ended".to_string())
}

/// Whether a channel has more messages than sequence numbers.
pub fn has_duplicates(sequence_stats: &BTreeMap<u16, SequenceStats>) -> bool {
    sequence_stats.values().any(|stats| stats.messages > u64::from(stats.max_sequence) + 1 && stats.max_sequence > 0)
}

/// Whether sequence numbers start at 0 on every channel. Tools that rewrite a log may number differently, or not at
/// all.
fn are_sequences_numbered(channels: &Channels, sequence_stats: &BTreeMap<u16, SequenceStats>) -> bool {
    let known = || channels.topics().iter().filter_map(|(id, ..)| sequence_stats.get(id));
    known().filter(|stats| stats.min_sequence == 0).count() > 1 && known().any(|stats| stats.max_sequence > 0)
}

/// Describes missing or surplus messages of a channel by its sequence numbers.
fn describe_sequence_gaps(stats: &SequenceStats) -> Option<String> {
    let expected = u64::from(stats.max_sequence) + 1;
    match stats.messages {
        // The messages are not numbered.
        _ if stats.max_sequence == 0 && stats.messages > 1 => None,
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
fn describe_time_gaps(summary: &LogSummary) -> Vec<String> {
    let mut found = Vec::new();
    let ms = |time_s: f64| format!("{:.6} ms", time_s * 1e3);
    if let Some(first_s) = summary.first_s.filter(|first_s| *first_s > 0.0 && summary.recovered.is_none()) {
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
