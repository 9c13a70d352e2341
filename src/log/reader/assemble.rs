//! From messages back to samples and events.

use foxglove::Decode;
use foxglove::messages::Log;

use super::Ended;
use super::bytes::Malformed;
use super::channels::{Carries, Channels};
use super::record::{ChannelRecord, MessageRecord, Names, SchemaRecord};
use super::wire::numbers;
use crate::trace::bodies::{BodiesEvent, BodiesSample, DiscState};
use crate::trace::{self, ContactSample, Event, EventKind, Sample, Site};

const BACK: Malformed = Malformed("the time of a sample is not a number, or goes back");

/// What a message, with those before it, came to.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// Part of something, or nothing of interest.
    Nothing,
    /// A message of a channel that phalanx does not know.
    Unknown,
    Sample(Box<Sample>),
    Event(Event),
    Discs(BodiesSample),
    DiscsEvent(BodiesEvent),
    Ended(Ended),
}

/// What messages have said so far.
pub struct Assembler {
    channels: Channels,
    /// A sample of which the last message (its energies) has not come yet.
    pending: Option<Box<Sample>>,
    discs: Parts,
    latest_s: f64,
}

/// A sample of discs as it comes together.
#[derive(Default)]
struct Parts {
    sample: BodiesSample,
    /// Which discs, and behind them which pairs, have come; and how many of them.
    there: Vec<bool>,
    count: usize,
}

impl Assembler {
    /// Of a log of discs, or of a finger.
    pub fn new(discs: bool) -> Self {
        Assembler { channels: Channels::new(discs), pending: None, discs: Parts::default(), latest_s: 0.0 }
    }

    pub fn schema(&mut self, schema: &SchemaRecord<'_>) {
        self.channels.schema(schema);
    }

    /// Takes note of a channel; true if it is new and unknown.
    pub fn channel(&mut self, channel: &ChannelRecord<'_>) -> bool {
        self.channels.channel(channel)
    }

    /// The discs and pairs of the samples.
    pub fn names(&self) -> &Names {
        self.channels.names()
    }

    /// Forgets samples of which not all has come.
    pub fn forget_parts(&mut self) {
        self.pending = None;
        self.discs.there.fill(false);
        self.discs.count = 0;
    }

    /// Takes a message.
    pub fn message(&mut self, message: &MessageRecord<'_>) -> Result<Found, Malformed> {
        let data = message.data;
        let Some(carries) = self.channels.carries(message.channel) else {
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
                let [_, gap_m, gap_rate_m_s, normal_n, impulse_n_s] = numbers(data)?;
                if let Some(sample) = &mut self.pending {
                    sample.limit =
                        ContactSample { gap_m, gap_rate_m_s, normal_n, impulse_n_s, ..ContactSample::default() };
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
                return self.finish_discs(energy);
            }
            Carries::Impact(site) => return event(site, data).map(Found::Event),
            Carries::Disc(index) => {
                let [time_s, x, y, angle_rad, vx, vy, spin_rad_s] = numbers(data)?;
                let state = DiscState { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s };
                self.put_part(index, time_s, |sample| sample.discs[index] = state)?;
            }
            Carries::PairContact(index) => {
                let [time_s] = numbers(data)?;
                let contact = contact(data)?;
                let place = self.channels.names().discs.len() + index;
                self.put_part(place, time_s, |sample| sample.contacts[index] = contact)?;
            }
            Carries::PairImpact(pair) => {
                self.channels.close();
                let (time_s, kind, [approach_m_s, impulse_n_s]) = change(data)?;
                return Ok(Found::DiscsEvent(BodiesEvent { time_s, pair, kind, approach_m_s, impulse_n_s }));
            }
            Carries::Lines => {
                let line = Log::decode(data).map_err(|_| Malformed("a line of the log is not protobuf"))?;
                if line.name == "run" {
                    return Ok(Found::Ended(Ended::new(message.log_time_ns as f64 * 1e-9, line.message)));
                }
            }
            Carries::Picture => {}
        }
        Ok(Found::Nothing)
    }

    /// Takes one of the messages of a sample of discs.
    fn put_part(&mut self, place: usize, time_s: f64, put: impl FnOnce(&mut BodiesSample)) -> Result<(), Malformed> {
        if !time_s.is_finite() || time_s < self.latest_s {
            return Err(BACK);
        }
        let names = self.channels.close();
        let parts = &mut self.discs;
        let (discs, pairs) = (names.discs.len(), names.pairs.len());
        if parts.there.len() != discs + pairs {
            parts.there = vec![false; discs + pairs];
            parts.sample.discs = vec![DiscState::default(); discs];
            parts.sample.contacts = vec![ContactSample::NONE; pairs];
        }
        parts.sample.time_s = time_s;
        put(&mut parts.sample);
        if !std::mem::replace(&mut parts.there[place], true) {
            parts.count += 1;
        }
        Ok(())
    }

    /// The sample, if every disc and every pair has come since the last one.
    fn finish_discs(&mut self, energy: trace::Energy) -> Result<Found, Malformed> {
        let parts = &mut self.discs;
        // Nothing is copied for less than a whole sample: the work stays in proportion to what was read.
        if parts.count == 0 || parts.count < parts.there.len() {
            return Ok(Found::Nothing);
        }
        parts.there.fill(false);
        parts.count = 0;
        parts.sample.energy = energy;
        self.latest_s = parts.sample.time_s;
        Ok(Found::Discs(parts.sample.clone()))
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
            return Err(BACK);
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
            limit: ContactSample::NONE,
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
    let (time_s, kind, [approach_speed, impulse]) = change(data)?;
    Ok(Event { time_s, site, kind, approach_speed, impulse })
}

/// A change of contact: its time, its kind, approach speed and impulse.
fn change(data: &[u8]) -> Result<(f64, EventKind, [f64; 2]), Malformed> {
    let [time_s, pressed, touch_down, approach_speed, impulse] = numbers(data)?;
    if !time_s.is_finite() {
        return Err(Malformed("the time of an event is not a number"));
    }
    let kind = match (pressed != 0.0, touch_down != 0.0) {
        (false, _) => EventKind::LiftOff,
        (true, true) => EventKind::TouchDown,
        (true, false) => EventKind::Reload,
    };
    Ok((time_s, kind, [approach_speed, impulse]))
}
