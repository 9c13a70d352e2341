//! From messages back to samples and events.

use std::collections::{BTreeMap, HashSet};

use foxglove::Decode;
use foxglove::messages::Log;

use super::bytes::Malformed;
use super::channels::{Carries, Channels, part};
use super::group::{Habits, Held, Item, Kind, in_order, put_in_order, written};
use super::missing::{Lacking, missing};
use super::reading::{Ended, Missing, Reading};
use super::record::MessageRecord;
use super::survey::Numbers;
use super::wire::numbers;
use crate::lines::is_of_friction;
use phalanx_core::trace::{self, BodyState, ContactSample, Event, EventKind, FingerState, Layout, Sample, SinkError};

const UNTIMED: Malformed = Malformed("the time of a message is not a number");
const BACK: Malformed = Malformed("the time of a sample goes back although its log time does not");

/// Messages of one log time that are put in order at once.
const MOST_HELD: usize = 200_000;

/// What messages come to.
pub enum Found<'a> {
    /// A message of a channel that phalanx does not know.
    Unknown,
    Sample(&'a Sample),
    Event(Event),
    Ended(Ended),
}

/// Takes what is found; an error of its own ends the reading.
pub trait Take: FnMut(Found<'_>) -> Result<(), SinkError> {}

impl<F: FnMut(Found<'_>) -> Result<(), SinkError>> Take for F {}

/// Puts messages together. They come in the order of their log times.
pub struct Assembler {
    channels: Channels,
    of_engine: bool,
    /// The parts of a sample of which the log has messages, in the order in which they are written.
    parts: Vec<usize>,
    /// A sample of which nothing has come: what must come is no number.
    blank: Sample,
    sample: Sample,
    /// The messages of the log time at hand.
    log_time_ns: u64,
    held: Vec<Held>,
    data: Vec<u8>,
    /// Of a log in which messages come more than once: those of the log time at hand, by channel, number and payload.
    seen: Option<HashSet<(u16, u32, Vec<u8>)>>,
    latest_s: f64,
    lacking: Lacking,
}

impl Assembler {
    /// Of the log of a model. `parts` are those of a sample of which the log has messages, in their order; `wanted` those that it should
    /// have besides; `repeats`: some messages come more than once.
    pub fn new(channels: Channels, of_engine: bool, parts: Vec<usize>, wanted: &[usize], repeats: bool) -> Self {
        let Layout { fingers, bodies, contacts } = channels.layout();
        let first = fingers.len() + bodies.len();
        let nothing = |index: usize| parts.contains(&(first + index)) || wanted.contains(&(first + index));
        let blank = Sample {
            time_s: f64::NAN,
            fingers: vec![NO_FINGER; fingers.len()],
            bodies: vec![NO_BODY; bodies.len()],
            contacts: (0..contacts.len()).map(|k| if nothing(k) { NO_CONTACT } else { ContactSample::NONE }).collect(),
            energy: NO_ENERGY,
        };
        let lacking = Lacking::new(first + contacts.len() + 1, contacts.len());
        Assembler {
            channels,
            of_engine,
            parts,
            sample: blank.clone(),
            blank,
            log_time_ns: 0,
            held: Vec::new(),
            data: Vec::new(),
            seen: repeats.then(HashSet::new),
            latest_s: 0.0,
            lacking,
        }
    }

    /// What the samples consist of.
    pub fn layout(&self) -> &Layout {
        self.channels.layout()
    }

    /// What the log lacks, once it was gone through.
    pub fn missing(
        &mut self,
        reading: &Reading,
        expected: &[(String, Carries)],
        numbers: &BTreeMap<u16, Numbers>,
    ) -> Vec<Missing> {
        missing(reading, expected, &self.channels, numbers, &mut self.lacking)
    }

    /// Takes a message; what is whole now goes to `take`.
    pub fn message(
        &mut self,
        message: &MessageRecord<'_>,
        take: &mut impl Take,
    ) -> Result<Result<(), Malformed>, SinkError> {
        let Some(carries) = self.channels.carries(message.channel) else {
            return take(Found::Unknown).map(Ok);
        };
        if message.log_time_ns != self.log_time_ns || self.held.len() >= MOST_HELD {
            if let Err(malformed) = self.release(message.log_time_ns != self.log_time_ns, take)? {
                return Ok(Err(malformed));
            }
            if message.log_time_ns != self.log_time_ns {
                self.seen.iter_mut().for_each(HashSet::clear);
            }
            self.log_time_ns = message.log_time_ns;
        }
        if let Some(seen) = &mut self.seen
            && carries != Carries::Picture
            && !seen.insert((message.channel, message.sequence, message.data.to_vec()))
        {
            self.lacking.again(message.channel);
            return Ok(Ok(()));
        }
        let kind = match carries {
            Carries::Picture => return Ok(Ok(())),
            Carries::Lines => match Log::decode(message.data) {
                Err(_) => return Ok(Err(Malformed("a line of the log is not protobuf"))),
                Ok(line) if line.name == "run" => {
                    return take(Found::Ended(Ended::new(message.log_time_ns as f64 * 1e-9, line.message))).map(Ok);
                }
                Ok(line) => {
                    let place = self.layout().contacts.iter().position(|place| place.name == line.name);
                    let Some(contact) = place else { return Ok(Ok(())) };
                    let of_friction = is_of_friction(&line.message);
                    self.lacking.line(contact, of_friction);
                    Ok(Kind::Line { contact, of_friction })
                }
            },
            Carries::Impact(contact) => change_kind(message.data).map(|kind| Kind::Event { contact, kind }),
            Carries::Slip(contact) => slip_kind(message.data).map(|kind| Kind::Event { contact, kind }),
            other => Ok(Kind::Part(part(self.layout(), other).unwrap_or(usize::MAX))),
        };
        let time_s = match kind {
            Ok(Kind::Line { .. }) => Ok([0.0]),
            _ => numbers::<1>(message.data),
        };
        match kind.and_then(|kind| time_s.map(|[time_s]| (kind, time_s))) {
            Ok((_, time_s)) if !time_s.is_finite() => Ok(Err(UNTIMED)),
            Ok((kind, time_s)) => {
                let start = self.data.len();
                self.data.extend_from_slice(message.data);
                self.held.push(Held { kind, sequence: message.sequence, time_s, data: start..self.data.len() });
                Ok(Ok(()))
            }
            Err(malformed) => Ok(Err(malformed)),
        }
    }

    /// Once all messages have come.
    pub fn end(&mut self, take: &mut impl Take) -> Result<Result<(), Malformed>, SinkError> {
        self.release(true, take)
    }

    /// Hands on what the messages at hand come to; those of a sample that may become whole yet stay, unless that was `all` of their log time.
    fn release(&mut self, all: bool, take: &mut impl Take) -> Result<Result<(), Malformed>, SinkError> {
        let whole =
            written(&self.held, &self.parts).filter(|whole| if all { *whole == self.held.len() } else { *whole > 0 });
        let habits = Habits { of_engine: self.of_engine, at_start: self.lacking.samples() == 0 };
        let (items, used) = match whole {
            Some(whole) => (in_order(&self.held[..whole]), whole),
            None => (put_in_order(&self.held, habits), self.held.len()),
        };
        let held = std::mem::take(&mut self.held);
        for item in items {
            let outcome = match item {
                Item::Sample(of) => match self.put_together(&held, &of) {
                    Ok(()) => take(Found::Sample(&self.sample)).map(Ok)?,
                    Err(malformed) => Err(malformed),
                },
                Item::Event(index) => match self.event(&held[index]) {
                    Ok(event) => {
                        self.lacking.event(event.contact, event.kind.is_of_friction());
                        take(Found::Event(event)).map(Ok)?
                    }
                    Err(malformed) => Err(malformed),
                },
            };
            if outcome.is_err() {
                return Ok(outcome);
            }
        }
        self.held = held;
        self.held.drain(..used);
        let gone = self.held.first().map_or(self.data.len(), |first| first.data.start);
        self.data.drain(..gone);
        for message in &mut self.held {
            message.data = message.data.start - gone..message.data.end - gone;
        }
        Ok(Ok(()))
    }

    fn put_together(&mut self, held: &[Held], of: &[usize]) -> Result<(), Malformed> {
        let layout = self.channels.layout();
        let (fingers, bodies) = (layout.fingers.len(), layout.bodies.len());
        self.sample.clone_from(&self.blank);
        let Some(first) = of.first() else { return Ok(()) };
        self.sample.time_s = held[*first].time_s;
        if self.sample.time_s < self.latest_s {
            return Err(BACK);
        }
        self.latest_s = self.sample.time_s;
        self.lacking.sample(self.sample.time_s);
        for &index in of {
            let Kind::Part(part) = held[index].kind else { continue };
            let data = &self.data[held[index].data.clone()];
            self.lacking.part(part);
            if part < fingers {
                self.sample.fingers[part] = finger(data)?;
            } else if part < fingers + bodies {
                self.sample.bodies[part - fingers] = body(data)?;
            } else if let Some(place) = layout.contacts.get(part - fingers - bodies) {
                self.sample.contacts[part - fingers - bodies] = if place.angular { stop(data) } else { contact(data) }?;
            } else {
                self.sample.energy = energy(data)?;
            }
        }
        Ok(())
    }

    fn event(&self, held: &Held) -> Result<Event, Malformed> {
        let Kind::Event { contact, kind } = held.kind else { return Err(UNTIMED) };
        let time_s = held.time_s;
        if kind.is_of_friction() {
            return Ok(Event { time_s, contact, kind, approach_speed: 0.0, impulse: 0.0 });
        }
        let [.., approach_speed, impulse] = numbers::<5>(&self.data[held.data.clone()])?;
        Ok(Event { time_s, contact, kind, approach_speed, impulse })
    }
}

const NO_FINGER: FingerState = FingerState {
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
const NO_BODY: BodyState =
    BodyState { centre_m: [f64::NAN; 2], angle_rad: f64::NAN, velocity_m_s: [f64::NAN; 2], spin_rad_s: f64::NAN };
const NO_CONTACT: ContactSample = ContactSample {
    gap_m: f64::NAN,
    gap_rate_m_s: f64::NAN,
    slip_m_s: f64::NAN,
    normal_n: f64::NAN,
    tangential_n: f64::NAN,
    impulse_n_s: f64::NAN,
    point_m: [f64::NAN; 2],
    normal: [f64::NAN; 2],
};
const NO_ENERGY: trace::Energy = trace::Energy {
    kinetic_j: f64::NAN,
    gravity_j: f64::NAN,
    spring_j: f64::NAN,
    elastic_j: f64::NAN,
    dissipated_j: f64::NAN,
    motor_work_j: f64::NAN,
    balance_j: f64::NAN,
};

fn finger(data: &[u8]) -> Result<FingerState, Malformed> {
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
    ] = numbers(data)?;
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

fn body(data: &[u8]) -> Result<BodyState, Malformed> {
    let [_, x, y, angle_rad, vx, vy, spin_rad_s] = numbers(data)?;
    Ok(BodyState { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s })
}

fn contact(data: &[u8]) -> Result<ContactSample, Malformed> {
    let [_, gap_m, gap_rate_m_s, slip_m_s, normal_n, tangential_n, x, y, normal_x, normal_y, impulse_n_s] =
        numbers(data)?;
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

fn stop(data: &[u8]) -> Result<ContactSample, Malformed> {
    let [_, gap_m, gap_rate_m_s, normal_n, impulse_n_s] = numbers(data)?;
    Ok(ContactSample { gap_m, gap_rate_m_s, normal_n, impulse_n_s, ..ContactSample::default() })
}

fn energy(data: &[u8]) -> Result<trace::Energy, Malformed> {
    let [_, kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j] = numbers(data)?;
    Ok(trace::Energy { kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j })
}

fn change_kind(data: &[u8]) -> Result<EventKind, Malformed> {
    let [_, pressed, touch_down] = numbers(data)?;
    Ok(match (pressed != 0.0, touch_down != 0.0) {
        (false, _) => EventKind::LiftOff,
        (true, true) => EventKind::TouchDown,
        (true, false) => EventKind::Reload,
    })
}

fn slip_kind(data: &[u8]) -> Result<EventKind, Malformed> {
    let [_, slips] = numbers(data)?;
    Ok(if slips != 0.0 { EventKind::Slips } else { EventKind::Sticks })
}
