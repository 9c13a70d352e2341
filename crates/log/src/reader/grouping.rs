//! Groups the messages of one log time into samples and events.
//!
//! In the write order of phalanx, the messages of a sample are consecutive and events are between samples. This order
//! is preserved. In any other order, messages are matched by channel, their own time and sequence number; events are in
//! the order of their event lines; a sample and an event of one instant are in the order in which the model writes
//! them.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;

use phalanx_core::trace::EventKind;

/// Role of a message in its group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MessageRole {
    /// Component of a sample, by index.
    Component(usize),
    /// Event of a contact.
    Event { contact: usize, kind: EventKind },
    /// Event line of a contact; `is_friction`: about friction.
    Line { contact: usize, is_friction: bool },
}

/// A message of a group.
#[derive(Clone, Debug)]
pub struct GroupedMessage {
    pub role: MessageRole,
    pub sequence: u32,
    /// Time in the message itself.
    pub time_s: f64,
    /// Range of the payload in the bytes of the group.
    pub data: Range<usize>,
}

/// A sample or event of a group, by indices of messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Item {
    Sample(Vec<usize>),
    Event(usize),
}

/// Determines the order of a sample and an event of one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TieOrder {
    /// Whether the log is from the engine model, where every event except a touch-down precedes the sample at the end
    /// of its step.
    pub is_engine: bool,
    /// Whether no sample has been read yet: in the analytic model, events of contacts closed at the start precede the
    /// first sample.
    pub is_at_start: bool,
}

/// Returns how many messages form complete samples and events if all are in write order, otherwise `None`. `components`
/// are the components of a sample of this log, in order.
pub fn count_in_write_order(messages: &[GroupedMessage], components: &[usize]) -> Option<usize> {
    let (mut next, mut count) = (0, 0);
    let (mut sample_s, mut latest_s) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
    for (index, message) in messages.iter().enumerate() {
        match message.role {
            MessageRole::Component(component) => {
                if next == 0 {
                    sample_s = message.time_s;
                }
                if components.get(next) != Some(&component) || message.time_s != sample_s || sample_s < latest_s {
                    return None;
                }
                next = (next + 1) % components.len();
                latest_s = sample_s;
            }
            MessageRole::Event { .. } | MessageRole::Line { .. } if next > 0 => return None,
            MessageRole::Event { .. } | MessageRole::Line { .. } => {}
        }
        if next == 0 {
            count = index + 1;
        }
    }
    Some(count)
}

/// Returns the samples and events of messages in write order.
pub fn items_in_write_order(messages: &[GroupedMessage]) -> Vec<Item> {
    let mut items: Vec<Item> = Vec::new();
    let mut latest = None;
    for (index, message) in messages.iter().enumerate() {
        match message.role {
            MessageRole::Component(component) => {
                match items.last_mut() {
                    Some(Item::Sample(indices)) if latest.is_some_and(|latest| latest < component) => {
                        indices.push(index)
                    }
                    _ => items.push(Item::Sample(vec![index])),
                }
                latest = Some(component);
            }
            MessageRole::Event { .. } => items.push(Item::Event(index)),
            MessageRole::Line { .. } => {}
        }
    }
    items
}

/// Returns the samples and events of messages in any order.
pub fn reconstruct_order(messages: &[GroupedMessage], tie_order: TieOrder) -> Vec<Item> {
    let samples = group_samples(messages);
    let mut items = Vec::new();
    let mut emitted = 0;
    // First sample of the current instant and number of its events so far.
    let (mut first_sample, mut occurrence) = (usize::MAX, 0);
    for index in order_events(messages) {
        let MessageRole::Event { kind, .. } = messages[index].role else { continue };
        let time_s = messages[index].time_s;
        let before = samples.partition_point(|(at_s, _)| *at_s < time_s && !is_same_instant(*at_s, time_s));
        let simultaneous = samples[before..].iter().take_while(|(at_s, _)| is_same_instant(*at_s, time_s)).count();
        (first_sample, occurrence) = if first_sample == before { (first_sample, occurrence + 1) } else { (before, 1) };
        let precedes_first_sample = tie_order.is_at_start && before == 0;
        let after = match (simultaneous, tie_order.is_engine) {
            (0, _) => before,
            (_, false) if precedes_first_sample && !kind.is_friction_event() => before,
            // Each of two samples of one instant is followed by an event.
            (_, false) => before + occurrence.min(simultaneous),
            (_, true) if kind == EventKind::TouchDown => before + 1,
            (_, true) => before + simultaneous - 1,
        };
        while emitted < after {
            items.push(Item::Sample(samples[emitted].1.clone()));
            emitted += 1;
        }
        items.push(Item::Event(index));
    }
    items.extend(samples[emitted..].iter().map(|(_, indices)| Item::Sample(indices.clone())));
    items
}

/// Whether two times denote the same instant: the model may compute it in two ways with different rounding.
fn is_same_instant(a_s: f64, b_s: f64) -> bool {
    (a_s - b_s).abs() <= 4.0 * f64::EPSILON * a_s.abs().max(b_s.abs())
}

/// Returns time and messages of every sample. Of two samples of one instant, the first gets the first message of every
/// channel.
fn group_samples(messages: &[GroupedMessage]) -> Vec<(f64, Vec<usize>)> {
    let mut components: Vec<(usize, usize)> = Vec::new();
    for (index, message) in messages.iter().enumerate() {
        if let MessageRole::Component(component) = message.role {
            components.push((component, index));
        }
    }
    components.sort_by(|&(component, a), &(other, b)| {
        component.cmp(&other).then_with(|| by_time(&messages[a], &messages[b]))
    });
    let mut found: Vec<(f64, usize, Vec<usize>)> = Vec::new();
    let mut sample_indices: BTreeMap<(u64, usize), usize> = BTreeMap::new();
    let (mut latest, mut occurrence) = (None, 0);
    for (component, index) in components {
        let time_s = messages[index].time_s;
        occurrence = if latest == Some((component, time_s.to_bits())) { occurrence + 1 } else { 0 };
        latest = Some((component, time_s.to_bits()));
        let index_in_found = *sample_indices.entry((time_s.to_bits(), occurrence)).or_insert_with(|| {
            found.push((time_s, occurrence, Vec::new()));
            found.len() - 1
        });
        found[index_in_found].2.push(index);
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    found.into_iter().map(|(time_s, _, indices)| (time_s, indices)).collect()
}

fn by_time(a: &GroupedMessage, b: &GroupedMessage) -> std::cmp::Ordering {
    a.time_s.total_cmp(&b.time_s).then(a.sequence.cmp(&b.sequence))
}

/// Returns events in the order of their lines, then events without a line in order of time.
fn order_events(messages: &[GroupedMessage]) -> Vec<usize> {
    let mut by_contact: BTreeMap<(usize, bool), VecDeque<usize>> = BTreeMap::new();
    let mut all: Vec<usize> =
        (0..messages.len()).filter(|&index| matches!(messages[index].role, MessageRole::Event { .. })).collect();
    all.sort_by(|&a, &b| by_time(&messages[a], &messages[b]));
    let mut found = Vec::with_capacity(all.len());
    for index in all {
        if let MessageRole::Event { contact, kind } = messages[index].role {
            by_contact.entry((contact, kind.is_friction_event())).or_default().push_back(index);
        }
    }
    let mut lines: Vec<&GroupedMessage> =
        messages.iter().filter(|message| matches!(message.role, MessageRole::Line { .. })).collect();
    lines.sort_by_key(|line| line.sequence);
    // Lines without distinct sequence numbers have no order.
    if lines.windows(2).any(|pair| pair[0].sequence == pair[1].sequence) {
        lines.clear();
    }
    for line in lines {
        if let MessageRole::Line { contact, is_friction } = line.role {
            found.extend(by_contact.get_mut(&(contact, is_friction)).and_then(VecDeque::pop_front));
        }
    }
    // Events without a line are ordered by their own time.
    let mut without_line: Vec<usize> = by_contact.into_values().flatten().collect();
    without_line.sort_by(|&a, &b| by_time(&messages[a], &messages[b]));
    found.extend(without_line);
    found
}
