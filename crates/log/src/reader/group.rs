//! The messages of one log time, and the order in which samples and events come of them.
//!
//! As phalanx writes a log, all messages of a sample follow each other, and events stand between samples. Where messages of a log time
//! come in that order, it is kept. Any other order says nothing: then messages are put together by channel, by their own time and by
//! their sequence number, events come in the order of the lines that tell of them, and a sample and an event of one instant come in the
//! order in which the model writes them.

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;

use phalanx_core::trace::EventKind;

/// What a message is to its group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Part of a sample, by its place among those.
    Part(usize),
    /// An event of a contact.
    Event { contact: usize, kind: EventKind },
    /// A line that tells of an event of a contact, and whether of its friction.
    Line { contact: usize, of_friction: bool },
}

/// A message.
#[derive(Clone, Debug)]
pub struct Held {
    pub kind: Kind,
    pub sequence: u32,
    /// The time that it says itself.
    pub time_s: f64,
    /// Its payload in the bytes of the group.
    pub data: Range<usize>,
}

/// What comes of a group.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Item {
    /// A sample of these messages.
    Sample(Vec<usize>),
    Event(usize),
}

/// Which order a sample and an event of one instant have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Habits {
    /// Of the engine: a change that is no touch-down stands before the sample at the end of its step.
    pub of_engine: bool,
    /// No sample has come yet: in the analytic model contacts that are closed at the start come before the first one.
    pub at_start: bool,
}

/// How many of the messages are in the order in which a log is written, up to the end of a sample or an event; `None` if they are not.
/// `parts` are the parts that a sample of this log has, in their order.
pub fn written(held: &[Held], parts: &[usize]) -> Option<usize> {
    let (mut next, mut whole) = (0, 0);
    let (mut sample_s, mut latest_s) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
    for (index, message) in held.iter().enumerate() {
        match message.kind {
            Kind::Part(part) => {
                if next == 0 {
                    sample_s = message.time_s;
                }
                if parts.get(next) != Some(&part) || message.time_s != sample_s || sample_s < latest_s {
                    return None;
                }
                next = (next + 1) % parts.len();
                latest_s = sample_s;
            }
            Kind::Event { .. } | Kind::Line { .. } if next > 0 => return None,
            Kind::Event { .. } | Kind::Line { .. } => {}
        }
        if next == 0 {
            whole = index + 1;
        }
    }
    Some(whole)
}

/// The samples and events of messages in written order.
pub fn in_order(held: &[Held]) -> Vec<Item> {
    let mut items: Vec<Item> = Vec::new();
    let mut latest = None;
    for (index, message) in held.iter().enumerate() {
        match message.kind {
            Kind::Part(part) => {
                match items.last_mut() {
                    Some(Item::Sample(of)) if latest.is_some_and(|latest| latest < part) => of.push(index),
                    _ => items.push(Item::Sample(vec![index])),
                }
                latest = Some(part);
            }
            Kind::Event { .. } => items.push(Item::Event(index)),
            Kind::Line { .. } => {}
        }
    }
    items
}

/// The samples and events of messages in any order.
pub fn put_in_order(held: &[Held], habits: Habits) -> Vec<Item> {
    let samples = samples(held);
    let mut items = Vec::new();
    let mut done = 0;
    // Where the samples of an instant begin, and how many events of it have come.
    let (mut instant, mut turn) = (usize::MAX, 0);
    for index in events(held) {
        let Kind::Event { kind, .. } = held[index].kind else { continue };
        let time_s = held[index].time_s;
        let before = samples.partition_point(|(at_s, _)| *at_s < time_s && !is_instant(*at_s, time_s));
        let along = samples[before..].iter().take_while(|(at_s, _)| is_instant(*at_s, time_s)).count();
        (instant, turn) = if instant == before { (instant, turn + 1) } else { (before, 1) };
        let first = habits.at_start && before == 0;
        let after = match (along, habits.of_engine) {
            (0, _) => before,
            (_, false) if first && !kind.is_of_friction() => before,
            // Each of two samples of one instant is followed by an event.
            (_, false) => before + turn.min(along),
            (_, true) if kind == EventKind::TouchDown => before + 1,
            (_, true) => before + along - 1,
        };
        while done < after {
            items.push(Item::Sample(samples[done].1.clone()));
            done += 1;
        }
        items.push(Item::Event(index));
    }
    items.extend(samples[done..].iter().map(|(_, of)| Item::Sample(of.clone())));
    items
}

/// Whether two times are of one instant: the model may come to it in two ways, and round otherwise.
fn is_instant(a_s: f64, b_s: f64) -> bool {
    (a_s - b_s).abs() <= 4.0 * f64::EPSILON * a_s.abs().max(b_s.abs())
}

/// The messages of every sample, and its time. Two samples of one instant have the messages of their channels in turn.
fn samples(held: &[Held]) -> Vec<(f64, Vec<usize>)> {
    let mut parts: Vec<(usize, usize)> = Vec::new();
    for (index, message) in held.iter().enumerate() {
        if let Kind::Part(part) = message.kind {
            parts.push((part, index));
        }
    }
    parts.sort_by(|&(part, a), &(other, b)| part.cmp(&other).then_with(|| by_time(&held[a], &held[b])));
    let mut found: Vec<(f64, usize, Vec<usize>)> = Vec::new();
    let mut places: BTreeMap<(u64, usize), usize> = BTreeMap::new();
    let (mut latest, mut turn) = (None, 0);
    for (part, index) in parts {
        let time_s = held[index].time_s;
        turn = if latest == Some((part, time_s.to_bits())) { turn + 1 } else { 0 };
        latest = Some((part, time_s.to_bits()));
        let place = *places.entry((time_s.to_bits(), turn)).or_insert_with(|| {
            found.push((time_s, turn, Vec::new()));
            found.len() - 1
        });
        found[place].2.push(index);
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    found.into_iter().map(|(time_s, _, of)| (time_s, of)).collect()
}

fn by_time(a: &Held, b: &Held) -> std::cmp::Ordering {
    a.time_s.total_cmp(&b.time_s).then(a.sequence.cmp(&b.sequence))
}

/// Events in the order of their lines; those that have none behind them, in the order of time.
fn events(held: &[Held]) -> Vec<usize> {
    let mut waiting: BTreeMap<(usize, bool), VecDeque<usize>> = BTreeMap::new();
    let mut all: Vec<usize> = (0..held.len()).filter(|&index| matches!(held[index].kind, Kind::Event { .. })).collect();
    all.sort_by(|&a, &b| by_time(&held[a], &held[b]));
    let mut found = Vec::with_capacity(all.len());
    for index in all {
        if let Kind::Event { contact, kind } = held[index].kind {
            waiting.entry((contact, kind.is_of_friction())).or_default().push_back(index);
        }
    }
    let mut lines: Vec<&Held> = held.iter().filter(|message| matches!(message.kind, Kind::Line { .. })).collect();
    lines.sort_by_key(|line| line.sequence);
    // Lines without numbers of their own are in no order.
    if lines.windows(2).any(|pair| pair[0].sequence == pair[1].sequence) {
        lines.clear();
    }
    for line in lines {
        if let Kind::Line { contact, of_friction } = line.kind {
            found.extend(waiting.get_mut(&(contact, of_friction)).and_then(VecDeque::pop_front));
        }
    }
    // Without their lines: by their own time.
    let mut rest: Vec<usize> = waiting.into_values().flatten().collect();
    rest.sort_by(|&a, &b| by_time(&held[a], &held[b]));
    found.extend(rest);
    found
}
