//! Assembles messages into samples and events.

use std::collections::{BTreeMap, HashSet};

use foxglove::Decode;
use foxglove::messages::Log;

use super::bytes::MalformedData;
use super::channels::{ChannelContent, Channels, component_index};
use super::grouping::{
    GroupedMessage, Item, MessageRole, TieOrder, count_in_write_order, items_in_write_order, reconstruct_order,
};
use super::missing::{MissingTracker, missing};
use super::record::MessageRecord;
use super::summary::{LogSummary, MissingData, RunEnd};
use super::survey::SequenceStats;
use super::wire::decode_doubles;
use crate::lines::is_friction_line;
use phalanx_core::trace::{self, BodyState, ContactSample, Event, EventKind, FingerState, Layout, Sample, SinkError};

const NON_FINITE_TIME: MalformedData = MalformedData("the time of a message is not a number");
const DECREASING_TIME: MalformedData = MalformedData("the time of a sample decreases although its log time does not");

/// Maximum number of messages of one log time that are grouped at once.
const MAX_GROUPED_MESSAGES: usize = 200_000;

/// Decoded content of one or more messages.
pub enum Decoded<'a> {
    /// Message of an unknown channel.
    UnknownMessage,
    Sample(&'a Sample),
    Event(Event),
    RunEnd(RunEnd),
}

/// Callback for decoded content; its error ends reading.
pub trait OnDecoded: FnMut(Decoded<'_>) -> Result<(), SinkError> {}

impl<F: FnMut(Decoded<'_>) -> Result<(), SinkError>> OnDecoded for F {}

/// Assembles messages, which arrive in order of log time.
pub struct Assembler {
    channels: Channels,
    is_engine: bool,
    /// Components of a sample that the log has, in write order.
    components: Vec<usize>,
    /// A sample without any message: all required values are NaN.
    missing_sample: Sample,
    sample: Sample,
    /// Log time of `messages`.
    log_time_ns: u64,
    messages: Vec<GroupedMessage>,
    data: Vec<u8>,
    /// Channel, sequence number and payload of the messages of this log time; only for logs with duplicates.
    seen: Option<HashSet<(u16, u32, Vec<u8>)>>,
    latest_s: f64,
    tracker: MissingTracker,
}

impl Assembler {
    /// Creates an assembler. `components`: components of a sample that the log has, in order; `required`: components
    /// that it should have; `has_duplicates`: some messages are repeated.
    pub fn new(
        channels: Channels,
        is_engine: bool,
        components: Vec<usize>,
        required: &[usize],
        has_duplicates: bool,
    ) -> Self {
        let Layout { fingers, bodies, contacts } = channels.layout();
        let first = fingers.len() + bodies.len();
        let is_in_log = |index: usize| components.contains(&(first + index)) || required.contains(&(first + index));
        let missing_sample = Sample {
            time_s: f64::NAN,
            fingers: vec![MISSING_FINGER; fingers.len()],
            bodies: vec![MISSING_BODY; bodies.len()],
            contacts: (0..contacts.len())
                .map(|k| if is_in_log(k) { MISSING_CONTACT } else { ContactSample::NONE })
                .collect(),
            energy: MISSING_ENERGY,
        };
        let tracker = MissingTracker::new(first + contacts.len() + 1, contacts.len());
        Assembler {
            channels,
            is_engine,
            components,
            sample: missing_sample.clone(),
            missing_sample,
            log_time_ns: 0,
            messages: Vec::new(),
            data: Vec::new(),
            seen: has_duplicates.then(HashSet::new),
            latest_s: 0.0,
            tracker,
        }
    }

    /// Layout of the samples.
    pub fn layout(&self) -> &Layout {
        self.channels.layout()
    }

    /// Returns the data missing in the log; called after the last message.
    pub fn missing(
        &mut self,
        summary: &LogSummary,
        expected_topics: &[(String, ChannelContent)],
        sequence_stats: &BTreeMap<u16, SequenceStats>,
    ) -> Vec<MissingData> {
        missing(summary, expected_topics, &self.channels, sequence_stats, &mut self.tracker)
    }

    /// Adds a message and passes completed samples and events to `on_decoded`.
    pub fn message(
        &mut self,
        message: &MessageRecord<'_>,
        on_decoded: &mut impl OnDecoded,
    ) -> Result<Result<(), MalformedData>, SinkError> {
        let Some(content) = self.channels.content(message.channel) else {
            return on_decoded(Decoded::UnknownMessage).map(Ok);
        };
        if message.log_time_ns != self.log_time_ns || self.messages.len() >= MAX_GROUPED_MESSAGES {
            if let Err(malformed) = self.flush_group(message.log_time_ns != self.log_time_ns, on_decoded)? {
                return Ok(Err(malformed));
            }
            if message.log_time_ns != self.log_time_ns {
                self.seen.iter_mut().for_each(HashSet::clear);
            }
            self.log_time_ns = message.log_time_ns;
        }
        if let Some(seen) = &mut self.seen
            && content != ChannelContent::Picture
            && !seen.insert((message.channel, message.sequence, message.data.to_vec()))
        {
            self.tracker.duplicate(message.channel);
            return Ok(Ok(()));
        }
        let role = match content {
            ChannelContent::Picture => return Ok(Ok(())),
            ChannelContent::Lines => match Log::decode(message.data) {
                Err(_) => return Ok(Err(MalformedData("a line of the log is not protobuf"))),
                Ok(line) if line.name == "run" => {
                    return on_decoded(Decoded::RunEnd(RunEnd::new(message.log_time_ns as f64 * 1e-9, line.message)))
                        .map(Ok);
                }
                Ok(line) => {
                    let contact = self.layout().contacts.iter().position(|channel| channel.name == line.name);
                    let Some(contact) = contact else { return Ok(Ok(())) };
                    let is_friction = is_friction_line(&line.message);
                    self.tracker.line(contact, is_friction);
                    Ok(MessageRole::Line { contact, is_friction })
                }
            },
            ChannelContent::Impact(contact) => {
                decode_impact_kind(message.data).map(|kind| MessageRole::Event { contact, kind })
            }
            ChannelContent::Slip(contact) => {
                decode_slip_kind(message.data).map(|kind| MessageRole::Event { contact, kind })
            }
            other => Ok(MessageRole::Component(component_index(self.layout(), other).unwrap_or(usize::MAX))),
        };
        let time_s = match role {
            Ok(MessageRole::Line { .. }) => Ok([0.0]),
            _ => decode_doubles::<1>(message.data),
        };
        match role.and_then(|role| time_s.map(|[time_s]| (role, time_s))) {
            Ok((_, time_s)) if !time_s.is_finite() => Ok(Err(NON_FINITE_TIME)),
            Ok((role, time_s)) => {
                let start = self.data.len();
                self.data.extend_from_slice(message.data);
                self.messages.push(GroupedMessage {
                    role,
                    sequence: message.sequence,
                    time_s,
                    data: start..self.data.len(),
                });
                Ok(Ok(()))
            }
            Err(malformed) => Ok(Err(malformed)),
        }
    }

    /// Called after the last message.
    pub fn end(&mut self, on_decoded: &mut impl OnDecoded) -> Result<Result<(), MalformedData>, SinkError> {
        self.flush_group(true, on_decoded)
    }

    /// Passes on the samples and events of the current group. Messages of an incomplete sample remain unless `all`
    /// messages of the log time have arrived.
    fn flush_group(
        &mut self,
        all: bool,
        on_decoded: &mut impl OnDecoded,
    ) -> Result<Result<(), MalformedData>, SinkError> {
        let ordered_count = count_in_write_order(&self.messages, &self.components)
            .filter(|count| if all { *count == self.messages.len() } else { *count > 0 });
        let tie_order = TieOrder { is_engine: self.is_engine, is_at_start: self.tracker.samples() == 0 };
        let (items, used) = match ordered_count {
            Some(count) => (items_in_write_order(&self.messages[..count]), count),
            None => (reconstruct_order(&self.messages, tie_order), self.messages.len()),
        };
        let messages = std::mem::take(&mut self.messages);
        for item in items {
            let outcome = match item {
                Item::Sample(indices) => match self.assemble_sample(&messages, &indices) {
                    Ok(()) => on_decoded(Decoded::Sample(&self.sample)).map(Ok)?,
                    Err(malformed) => Err(malformed),
                },
                Item::Event(index) => match self.event(&messages[index]) {
                    Ok(event) => {
                        self.tracker.event(event.contact, event.kind.is_friction_event());
                        on_decoded(Decoded::Event(event)).map(Ok)?
                    }
                    Err(malformed) => Err(malformed),
                },
            };
            if outcome.is_err() {
                return Ok(outcome);
            }
        }
        self.messages = messages;
        self.messages.drain(..used);
        let consumed_bytes = self.messages.first().map_or(self.data.len(), |first| first.data.start);
        self.data.drain(..consumed_bytes);
        for message in &mut self.messages {
            message.data = message.data.start - consumed_bytes..message.data.end - consumed_bytes;
        }
        Ok(Ok(()))
    }

    fn assemble_sample(&mut self, messages: &[GroupedMessage], indices: &[usize]) -> Result<(), MalformedData> {
        let layout = self.channels.layout();
        let (fingers, bodies) = (layout.fingers.len(), layout.bodies.len());
        self.sample.clone_from(&self.missing_sample);
        let Some(first) = indices.first() else { return Ok(()) };
        self.sample.time_s = messages[*first].time_s;
        if self.sample.time_s < self.latest_s {
            return Err(DECREASING_TIME);
        }
        self.latest_s = self.sample.time_s;
        self.tracker.sample(self.sample.time_s);
        for &index in indices {
            let MessageRole::Component(component) = messages[index].role else { continue };
            let data = &self.data[messages[index].data.clone()];
            self.tracker.component(component);
            if component < fingers {
                self.sample.fingers[component] = decode_finger(data)?;
            } else if component < fingers + bodies {
                self.sample.bodies[component - fingers] = decode_body(data)?;
            } else if let Some(channel) = layout.contacts.get(component - fingers - bodies) {
                self.sample.contacts[component - fingers - bodies] =
                    if channel.is_angular { decode_limit(data) } else { decode_contact(data) }?;
            } else {
                self.sample.energy = decode_energy(data)?;
            }
        }
        Ok(())
    }

    fn event(&self, message: &GroupedMessage) -> Result<Event, MalformedData> {
        let MessageRole::Event { contact, kind } = message.role else { return Err(NON_FINITE_TIME) };
        let time_s = message.time_s;
        if kind.is_friction_event() {
            return Ok(Event { time_s, contact, kind, approach_speed: 0.0, impulse: 0.0 });
        }
        let [.., approach_speed, impulse] = decode_doubles::<5>(&self.data[message.data.clone()])?;
        Ok(Event { time_s, contact, kind, approach_speed, impulse })
    }
}

const MISSING_FINGER: FingerState = FingerState {
    q11_rad: f64::NAN,
    q21_rad: f64::NAN,
    q12_rad: f64::NAN,
    q22_rad: f64::NAN,
    q13_rad: f64::NAN,
    qd11_rad_s: f64::NAN,
    qd21_rad_s: f64::NAN,
    qd12_rad_s: f64::NAN,
    qd22_rad_s: f64::NAN,
    motor_torque_n_m: f64::NAN,
};
const MISSING_BODY: BodyState =
    BodyState { centre_m: [f64::NAN; 2], angle_rad: f64::NAN, velocity_m_s: [f64::NAN; 2], spin_rad_s: f64::NAN };
const MISSING_CONTACT: ContactSample = ContactSample {
    gap_m: f64::NAN,
    gap_rate_m_s: f64::NAN,
    slip_m_s: f64::NAN,
    normal_n: f64::NAN,
    tangential_n: f64::NAN,
    impulse_n_s: f64::NAN,
    point_m: [f64::NAN; 2],
    normal: [f64::NAN; 2],
};
const MISSING_ENERGY: trace::Energy = trace::Energy {
    kinetic_j: f64::NAN,
    gravity_j: f64::NAN,
    spring_j: f64::NAN,
    elastic_j: f64::NAN,
    dissipated_j: f64::NAN,
    motor_work_j: f64::NAN,
    balance_j: f64::NAN,
};

fn decode_finger(data: &[u8]) -> Result<FingerState, MalformedData> {
    let [
        _,
        q11_rad,
        q21_rad,
        q12_rad,
        q22_rad,
        q13_rad,
        qd11_rad_s,
        qd21_rad_s,
        qd12_rad_s,
        qd22_rad_s,
        motor_torque_n_m,
    ] = decode_doubles(data)?;
    Ok(FingerState {
        q11_rad,
        q21_rad,
        q12_rad,
        q22_rad,
        q13_rad,
        qd11_rad_s,
        qd21_rad_s,
        qd12_rad_s,
        qd22_rad_s,
        motor_torque_n_m,
    })
}

fn decode_body(data: &[u8]) -> Result<BodyState, MalformedData> {
    let [_, x, y, angle_rad, vx, vy, spin_rad_s] = decode_doubles(data)?;
    Ok(BodyState { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s })
}

fn decode_contact(data: &[u8]) -> Result<ContactSample, MalformedData> {
    let [_, gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, x, y, normal_x, normal_y, impulse_n_s] =
        decode_doubles(data)?;
    Ok(ContactSample {
        gap_m,
        gap_rate_m_s,
        slip_m_s,
        normal_n,
        tangential_n,
        impulse_n_s,
        point_m: [x, y],
        normal: [normal_x, normal_y],
    })
}

fn decode_limit(data: &[u8]) -> Result<ContactSample, MalformedData> {
    let [_, gap_m, gap_rate_m_s, normal_n, impulse_n_s] = decode_doubles(data)?;
    Ok(ContactSample { gap_m, gap_rate_m_s, normal_n, impulse_n_s, ..ContactSample::default() })
}

fn decode_energy(data: &[u8]) -> Result<trace::Energy, MalformedData> {
    let [_, kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j] = decode_doubles(data)?;
    Ok(trace::Energy { kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j })
}

fn decode_impact_kind(data: &[u8]) -> Result<EventKind, MalformedData> {
    let [_, pressed, touch_down] = decode_doubles(data)?;
    Ok(match (pressed != 0.0, touch_down != 0.0) {
        (false, _) => EventKind::LiftOff,
        (true, true) => EventKind::TouchDown,
        (true, false) => EventKind::Reload,
    })
}

fn decode_slip_kind(data: &[u8]) -> Result<EventKind, MalformedData> {
    let [_, slips] = decode_doubles(data)?;
    Ok(if slips != 0.0 { EventKind::Slips } else { EventKind::Sticks })
}
