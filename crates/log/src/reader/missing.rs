//! What a log lacks that the log of such a run has.
//!
//! A log whose topics were filtered is a whole MCAP file, and its samples are as good as what is left of them. What should be there
//! follows from the scene in the log, and from the log itself: every sample has a message on each of its topics, numbers of messages have no
//! holes, every event stands on the topic of its contact and as a line on `/events`, and the last of these says how the run ended.

use std::collections::BTreeMap;

use super::channels::{Carries, Channels, part};
use super::reading::{Concerns, Missing, Reading};
use super::survey::Numbers;
use crate::channels::Topics;
use phalanx_core::scene::words::SceneKind;
use phalanx_core::trace::Layout;

impl From<Carries> for Concerns {
    fn from(carries: Carries) -> Self {
        match carries {
            Carries::Finger(index) => Concerns::Finger(index),
            Carries::Body(index) => Concerns::Body(index),
            Carries::Contact(index) | Carries::Stop(index) | Carries::Impact(index) | Carries::Slip(index) => {
                Concerns::Contact(index)
            }
            Carries::Energy => Concerns::Energy,
            Carries::Lines | Carries::Picture => Concerns::Run,
        }
    }
}

/// What has come of every part of the samples, and of events and their lines.
pub struct Lacking {
    samples: u64,
    latest_s: f64,
    /// Of each part: in how many samples it came, and the first one in which it did not.
    came: Vec<(u64, Option<f64>)>,
    /// Of each contact: events and lines that tell of one, of its force and of its friction.
    events: Vec<[u64; 2]>,
    lines: Vec<[u64; 2]>,
    /// Of each channel: messages that came before, number and all.
    repeated: BTreeMap<u16, u64>,
}

impl Lacking {
    pub fn new(parts: usize, contacts: usize) -> Self {
        Lacking {
            samples: 0,
            latest_s: 0.0,
            came: vec![(0, None); parts],
            events: vec![[0; 2]; contacts],
            lines: vec![[0; 2]; contacts],
            repeated: BTreeMap::new(),
        }
    }

    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// A sample begins.
    pub fn sample(&mut self, time_s: f64) {
        self.close();
        self.samples += 1;
        self.latest_s = time_s;
    }

    /// A part of it has come.
    pub fn part(&mut self, part: usize) {
        self.came[part].0 += 1;
    }

    pub fn event(&mut self, contact: usize, of_friction: bool) {
        self.events[contact][usize::from(of_friction)] += 1;
    }

    pub fn line(&mut self, contact: usize, of_friction: bool) {
        self.lines[contact][usize::from(of_friction)] += 1;
    }

    /// A message of this channel comes again.
    pub fn again(&mut self, channel: u16) {
        *self.repeated.entry(channel).or_default() += 1;
    }

    /// The latest sample is over.
    pub fn close(&mut self) {
        for (count, first_s) in &mut self.came {
            if *count < self.samples && first_s.is_none() {
                *first_s = Some(self.latest_s);
            }
        }
    }
}

/// The topics that a log of this kind should have, with what they carry; of a scene all of them, without one those that every such log has.
pub fn expected(kind: SceneKind, topics: Option<&Topics>) -> Vec<(String, Carries)> {
    let mut all = Vec::new();
    match topics {
        Some(Topics { fingers, bodies, contacts }) => {
            all.extend(fingers.iter().enumerate().map(|(index, topic)| (topic.clone(), Carries::Finger(index))));
            all.extend(bodies.iter().enumerate().map(|(index, topic)| (topic.clone(), Carries::Body(index))));
            for (index, of) in contacts.iter().enumerate() {
                all.extend(of.iter().map(|of| (of.samples.clone(), Carries::Contact(index))));
            }
            for (index, of) in contacts.iter().enumerate() {
                all.extend(of.iter().map(|of| (of.impact.clone(), Carries::Impact(index))));
                all.extend(of.iter().filter_map(|of| Some((of.slip.clone()?, Carries::Slip(index)))));
            }
        }
        None => match kind {
            SceneKind::Finger => all.push(("/state".to_string(), Carries::Finger(0))),
            SceneKind::Gripper => {
                all.push(("/state/right".to_string(), Carries::Finger(0)));
                all.push(("/state/left".to_string(), Carries::Finger(1)));
                all.push(("/object".to_string(), Carries::Body(0)));
            }
            SceneKind::Bodies => {}
        },
    }
    all.push(("/energy".to_string(), Carries::Energy));
    all.push(("/events".to_string(), Carries::Lines));
    all
}

/// What is missing in a log that was gone through to its end.
pub fn missing(
    reading: &Reading,
    expected: &[(String, Carries)],
    channels: &Channels,
    numbers: &BTreeMap<u16, Numbers>,
    lacking: &mut Lacking,
) -> Vec<Missing> {
    lacking.close();
    let lacking = &*lacking;
    let layout = channels.layout();
    let mut topics = expected.to_vec();
    for (_, topic, carries) in channels.topics() {
        if !topics.iter().any(|(known, _)| known == topic) {
            topics.push((topic.clone(), *carries));
        }
    }
    // Messages that are the same to the last byte are one.
    let once = |id: &u16| {
        let numbers = numbers.get(id)?;
        let repeated = lacking.repeated.get(id).copied().unwrap_or(0);
        Some(Numbers { messages: numbers.messages - repeated, ..*numbers })
    };
    let messages = |topic: &str| -> Vec<Numbers> {
        channels.topics().iter().filter(|(_, known, _)| known == topic).filter_map(|(id, ..)| once(id)).collect()
    };
    let are_numbered = are_numbered(channels, numbers) && reading.recovered.is_none();
    // A run that stopped before its first sample has none, and of one that is cut off there may be none.
    let stopped = reading.ended.as_ref().is_some_and(|ended| ended.stopped.is_some());
    let may_be_empty = reading.samples == 0 && (stopped || !reading.is_whole());
    let mut found = Vec::new();
    for (topic, carries) in &topics {
        let of = messages(topic);
        let what = match carries {
            Carries::Picture => None,
            _ if part(layout, *carries).is_some() => {
                let (came, first_s) = part(layout, *carries).map_or((0, None), |part| lacking.came[part]);
                sample_part(came, lacking.samples, first_s, of.is_empty(), may_be_empty)
            }
            Carries::Impact(index) => events(lacking, *index, false),
            Carries::Slip(index) => events(lacking, *index, true),
            _ => lines(reading, lacking, of.is_empty()),
        };
        let is_counted = are_numbered && *carries != Carries::Picture;
        let what = what.or_else(|| of.iter().filter(|_| is_counted).find_map(by_number));
        found.extend(what.map(|what| Missing {
            topic: topic.clone(),
            what,
            concerns: (*carries).into(),
            is_judged_by: is_judged_by(layout, *carries),
        }));
    }
    found.extend(ends(reading).into_iter().map(|what| Missing {
        topic: "every topic".to_string(),
        what,
        concerns: Concerns::Run,
        is_judged_by: true,
    }));
    found
}

/// No class, and nothing of a grasp, follows from energies or from how friction slips; the class of a finger does not follow from its joint
/// limit either.
fn is_judged_by(layout: &Layout, carries: Carries) -> bool {
    let is_limit =
        |index: usize| layout.fingers.len() == 1 && layout.contacts.get(index).is_some_and(|place| place.angular);
    match carries {
        Carries::Energy | Carries::Slip(_) | Carries::Picture => false,
        Carries::Contact(index) | Carries::Stop(index) | Carries::Impact(index) => !is_limit(index),
        Carries::Finger(_) | Carries::Body(_) | Carries::Lines => true,
    }
}

/// Of a topic that every sample has a message on.
fn sample_part(came: u64, samples: u64, first_s: Option<f64>, is_empty: bool, may_be_empty: bool) -> Option<String> {
    match first_s {
        _ if is_empty && !may_be_empty => Some("has no message".to_string()),
        Some(first_s) if came < samples => {
            let from = format!("the first at {:.6} ms", first_s * 1e3);
            Some(format!("lacks {} of {samples} messages, {from}", samples - came))
        }
        _ => None,
    }
}

/// Events of which a line tells, but no message.
fn events(lacking: &Lacking, contact: usize, of_friction: bool) -> Option<String> {
    let [lines, events] = [&lacking.lines, &lacking.events].map(|all| all[contact][usize::from(of_friction)]);
    let missing = lines.saturating_sub(events);
    (missing > 0).then(|| format!("lacks {missing} of {lines} events that /events names"))
}

/// The lines of events, and the one that says how the run ended.
fn lines(reading: &Reading, lacking: &Lacking, is_empty: bool) -> Option<String> {
    if is_empty {
        return reading.is_whole().then(|| "has no message".to_string());
    }
    let sum = |all: &[[u64; 2]]| all.iter().flatten().sum::<u64>();
    let untold: u64 = lacking
        .events
        .iter()
        .flatten()
        .zip(lacking.lines.iter().flatten())
        .map(|(events, lines)| events.saturating_sub(*lines))
        .sum();
    if untold > 0 {
        return Some(format!("lacks {untold} of {} events that have messages of their own", sum(&lacking.events)));
    }
    let should_end = reading.is_whole() && reading.recovered.is_none();
    (should_end && reading.ended.is_none()).then(|| "does not say how the run ended".to_string())
}

/// Whether some messages must come more than once.
pub fn repeats(numbers: &BTreeMap<u16, Numbers>) -> bool {
    numbers.values().any(|numbers| numbers.messages > u64::from(numbers.largest) + 1 && numbers.largest > 0)
}

/// Whether the messages of every channel are numbered by themselves, from 0: who writes a log anew may number otherwise, or not at all.
fn are_numbered(channels: &Channels, numbers: &BTreeMap<u16, Numbers>) -> bool {
    let known = || channels.topics().iter().filter_map(|(id, ..)| numbers.get(id));
    known().filter(|numbers| numbers.least == 0).count() > 1 && known().any(|numbers| numbers.largest > 0)
}

/// Messages that are missing, or come more than once, by the numbers of those that are there.
fn by_number(numbers: &Numbers) -> Option<String> {
    let expected = u64::from(numbers.largest) + 1;
    match numbers.messages {
        // Not numbered.
        _ if numbers.largest == 0 && numbers.messages > 1 => None,
        count if count < expected => {
            Some(format!("lacks {} of {expected} messages, by their numbers", expected - count))
        }
        count if count > expected => Some(format!(
            "has {} messages more than their numbers say: other messages were merged into it",
            count - expected
        )),
        _ => None,
    }
}

/// A log that was cut out of a longer one begins late or ends early.
fn ends(reading: &Reading) -> Vec<String> {
    let mut found = Vec::new();
    let ms = |time_s: f64| format!("{:.6} ms", time_s * 1e3);
    if let Some(first_s) = reading.first_s.filter(|first_s| *first_s > 0.0 && reading.recovered.is_none()) {
        found.push(format!("has no message before {}", ms(first_s)));
    }
    let completed = reading.ended.as_ref().filter(|ended| ended.stopped.is_none());
    // Log times are whole nanoseconds.
    if let Some((ended, last_s)) = completed.zip(reading.last_s)
        && ended.time_s - last_s > 1e-9 + 1e-12 * last_s
    {
        found.push(format!("has no message between {} and the end of the run at {}", ms(last_s), ms(ended.time_s)));
    }
    found
}
