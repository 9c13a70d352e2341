//! From messages back to samples and events.

use std::collections::HashMap;

use foxglove::Encode;
use foxglove::messages::Log;

use super::Ended;
use super::bytes::Malformed;
use super::wire::{log_line, numbers};
use crate::log::messages::{Contact, Energy, Impact, Limit, LimitImpact, State};
use crate::trace::{self, ContactSample, Event, EventKind, LimitSample, Sample, Site};

/// What a channel carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Carries {
    State,
    Contact(Site),
    Limit,
    Energy,
    Impact(Site),
    Lines,
}

/// What a message, with those before it, came to.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// Part of something, or nothing of interest.
    Nothing,
    /// A message of a channel that phalanx does not know.
    Unknown,
    Sample(Box<Sample>),
    Event(Event),
    Ended(Ended),
}

/// What messages have said so far.
pub struct Assembler {
    /// Schema names of phalanx with the channels that have them.
    known: Vec<(String, &'static [(&'static str, Carries)])>,
    /// Of each schema in the file that is known: its place in `known`.
    schemas: HashMap<u16, usize>,
    channels: HashMap<u16, Option<Carries>>,
    /// A sample of which the last message (its energies) has not come yet.
    pending: Option<Box<Sample>>,
    latest_s: f64,
}

impl Assembler {
    pub fn new() -> Self {
        const CONTACTS: &[(&str, Carries)] = &[
            ("/contact/proximal", Carries::Contact(Site::Proximal)),
            ("/contact/distal", Carries::Contact(Site::Distal)),
        ];
        const IMPACTS: &[(&str, Carries)] =
            &[("/impact/proximal", Carries::Impact(Site::Proximal)), ("/impact/distal", Carries::Impact(Site::Distal))];
        let known = [
            (State::get_schema(), &[("/state", Carries::State)][..]),
            (Contact::get_schema(), CONTACTS),
            (Limit::get_schema(), &[("/limit", Carries::Limit)]),
            (Energy::get_schema(), &[("/energy", Carries::Energy)]),
            (Impact::get_schema(), IMPACTS),
            (LimitImpact::get_schema(), &[("/impact/limit", Carries::Impact(Site::Limit))]),
            (Log::get_schema(), &[("/events", Carries::Lines)]),
        ];
        Assembler {
            known: known.into_iter().filter_map(|(schema, topics)| Some((schema?.name, topics))).collect(),
            schemas: HashMap::new(),
            channels: HashMap::new(),
            pending: None,
            latest_s: 0.0,
        }
    }

    /// Takes note of a schema; one that is not of phalanx is forgotten.
    pub fn schema(&mut self, id: u16, name: &str, encoding: &str) {
        if let Some(index) = self.known.iter().position(|(known, _)| encoding == "protobuf" && known == name) {
            self.schemas.insert(id, index);
        }
    }

    /// Takes note of a channel; true if it is new and unknown.
    pub fn channel(&mut self, id: u16, schema: u16, topic: &str, encoding: &str) -> bool {
        let topics = self.schemas.get(&schema).filter(|_| encoding == "protobuf").map(|&index| self.known[index].1);
        let carries = topics.and_then(|topics| topics.iter().find(|(name, _)| *name == topic)).map(|(_, found)| *found);
        self.channels.insert(id, carries).is_none() && carries.is_none()
    }

    /// Takes a message.
    pub fn message(&mut self, channel: u16, log_time_ns: u64, data: &[u8]) -> Result<Found, Malformed> {
        let Some(Some(carries)) = self.channels.get(&channel).copied() else {
            return Ok(Found::Unknown);
        };
        match carries {
            Carries::State => self.pending = Some(Box::new(self.begin(data)?)),
            Carries::Contact(site) => {
                let contact = contact(data)?;
                if let Some(sample) = &mut self.pending {
                    *(if site == Site::Proximal { &mut sample.proximal } else { &mut sample.distal }) = contact;
                }
            }
            Carries::Limit => {
                let [_, gap_rad, gap_rate_rad_s, torque_n_m, impulse_n_m_s] = numbers(data)?;
                if let Some(sample) = &mut self.pending {
                    sample.limit = LimitSample { gap_rad, gap_rate_rad_s, torque_n_m, impulse_n_m_s };
                }
            }
            Carries::Energy => {
                let energy = energy(data)?;
                // Energies come last: the sample is whole.
                if let Some(mut sample) = self.pending.take() {
                    sample.energy = energy;
                    self.latest_s = sample.time_s;
                    return Ok(Found::Sample(sample));
                }
            }
            Carries::Impact(site) => return event(site, data).map(Found::Event),
            Carries::Lines => {
                let (text, name) = log_line(data)?;
                if name == "run" {
                    return Ok(Found::Ended(Ended::new(log_time_ns as f64 * 1e-9, text)));
                }
            }
        }
        Ok(Found::Nothing)
    }

    fn begin(&self, data: &[u8]) -> Result<Sample, Malformed> {
        let [
            time_s,
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
        if !time_s.is_finite() || time_s < self.latest_s {
            return Err(Malformed("the time of a sample is not a number, or goes back"));
        }
        Ok(Sample {
            time_s,
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
            proximal: ContactSample::NONE,
            distal: ContactSample::NONE,
            limit: LimitSample::NONE,
            energy: trace::Energy::default(),
        })
    }
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

fn energy(data: &[u8]) -> Result<trace::Energy, Malformed> {
    let [_, kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j] = numbers(data)?;
    Ok(trace::Energy { kinetic_j, gravity_j, spring_j, elastic_j, dissipated_j, motor_work_j, balance_j })
}

fn event(site: Site, data: &[u8]) -> Result<Event, Malformed> {
    let [time_s, pressed, touch_down, approach_speed, impulse] = numbers(data)?;
    if !time_s.is_finite() {
        return Err(Malformed("the time of an event is not a number"));
    }
    let kind = match (pressed != 0.0, touch_down != 0.0) {
        (false, _) => EventKind::LiftOff,
        (true, true) => EventKind::TouchDown,
        (true, false) => EventKind::Reload,
    };
    Ok(Event { time_s, site, kind, approach_speed, impulse })
}
