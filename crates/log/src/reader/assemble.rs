//! From messages back to samples and events.

use foxglove::Decode;
use foxglove::messages::Log;

use super::Ended;
use super::bytes::Malformed;
use super::channels::{Carries, Channels};
use super::record::{ChannelRecord, MessageRecord, SchemaRecord};
use super::wire::numbers;
use phalanx_core::scene::words::SceneKind;
use phalanx_core::trace::{self, BodyState, ContactSample, Event, EventKind, FingerState, Layout, Sample};

const UNTIMED: Malformed = Malformed("the time of an event is not a number");
const BACK: Malformed = Malformed("the time of a sample is not a number, or goes back");

/// What a message, with those before it, came to.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// Part of something, or nothing of interest.
    Nothing,
    /// A message of a channel that phalanx does not know.
    Unknown,
    /// A sample is whole: [`Assembler::sample`].
    Sample,
    Event(Event),
    Ended(Ended),
}

/// What messages have said so far.
pub struct Assembler {
    channels: Channels,
    /// The sample as it comes together, and what of it has come since the last one was whole.
    sample: Sample,
    there: Parts,
    latest_s: f64,
}

/// Fingers, bodies and contacts that have come.
#[derive(Default)]
struct Parts {
    fingers: Vec<bool>,
    bodies: Vec<bool>,
    contacts: Vec<bool>,
    /// How many.
    count: usize,
}

impl Parts {
    fn forget(&mut self) {
        let Parts { fingers, bodies, contacts, count } = self;
        [fingers, bodies, contacts].into_iter().for_each(|parts| parts.fill(false));
        *count = 0;
    }

    /// Beside fingers there can be nothing to touch, and their messages come first, then those of bodies; where there are bodies alone
    /// everything has to come.
    fn are_whole(&self) -> bool {
        match self.fingers.is_empty() {
            false => self.fingers.iter().chain(&self.bodies).all(|there| *there),
            true => self.count > 0 && self.count == self.bodies.len() + self.contacts.len(),
        }
    }
}

impl Assembler {
    /// Of the log of a scene of this kind.
    pub fn new(kind: SceneKind) -> Self {
        let (sample, there) = (Sample::default(), Parts::default());
        Assembler { channels: Channels::new(kind), sample, there, latest_s: 0.0 }
    }

    pub fn schema(&mut self, schema: &SchemaRecord<'_>) {
        self.channels.schema(schema);
    }

    /// Takes note of a channel; true if it is new and unknown.
    pub fn channel(&mut self, channel: &ChannelRecord<'_>) -> bool {
        self.channels.channel(channel)
    }

    /// What the samples consist of; it stays the same from here on.
    pub fn layout(&mut self) -> &Layout {
        self.channels.close()
    }

    /// The sample that was made whole last, until the next message.
    pub fn sample(&self) -> &Sample {
        &self.sample
    }

    /// Forgets samples of which not all has come.
    pub fn forget_parts(&mut self) {
        self.there.forget();
    }

    /// Takes a message.
    pub fn message(&mut self, message: &MessageRecord<'_>) -> Result<Found, Malformed> {
        let data = message.data;
        let Some(carries) = self.channels.carries(message.channel) else {
            return Ok(Found::Unknown);
        };
        match carries {
            Carries::Finger(index) => {
                let (time_s, finger) = finger(data)?;
                self.begin(time_s)?;
                if index == 0 {
                    // It comes first: what came before it belongs to no sample.
                    self.there.forget();
                    self.sample.contacts.fill(ContactSample::NONE);
                }
                self.sample.fingers[index] = finger;
                self.there.fingers[index] = true;
            }
            Carries::Body(index) => {
                let (time_s, body) = body(data)?;
                self.begin(time_s)?;
                self.sample.bodies[index] = body;
                self.there.count += usize::from(!std::mem::replace(&mut self.there.bodies[index], true));
            }
            Carries::Contact(index) => {
                let [time_s] = numbers(data)?;
                self.put_contact(index, time_s, contact(data)?)?;
            }
            Carries::Stop(index) => {
                let [time_s, gap_m, gap_rate_m_s, normal_n, impulse_n_s] = numbers(data)?;
                let stop = ContactSample { gap_m, gap_rate_m_s, normal_n, impulse_n_s, ..ContactSample::default() };
                self.put_contact(index, time_s, stop)?;
            }
            Carries::Energy => {
                let energy = energy(data)?;
                // Energies come last: the sample is whole if all else has come.
                if self.there.are_whole() {
                    self.there.forget();
                    self.sample.energy = energy;
                    self.latest_s = self.sample.time_s;
                    return Ok(Found::Sample);
                }
            }
            Carries::Impact(contact) => {
                let (time_s, kind, [approach_speed, impulse]) = change(data)?;
                return Ok(Found::Event(Event { time_s, contact, kind, approach_speed, impulse }));
            }
            Carries::Slip(contact) => {
                let [time_s, slips] = numbers(data)?;
                if !time_s.is_finite() {
                    return Err(UNTIMED);
                }
                let kind = if slips != 0.0 { EventKind::Slips } else { EventKind::Sticks };
                return Ok(Found::Event(Event { time_s, contact, kind, approach_speed: 0.0, impulse: 0.0 }));
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

    /// A part of a sample of this time has come: makes room for all of it.
    fn begin(&mut self, time_s: f64) -> Result<(), Malformed> {
        if !time_s.is_finite() || time_s < self.latest_s {
            return Err(BACK);
        }
        let Layout { fingers, bodies, contacts } = self.channels.close();
        let (sample, there) = (&mut self.sample, &mut self.there);
        if (sample.fingers.len(), sample.bodies.len(), sample.contacts.len())
            != (fingers.len(), bodies.len(), contacts.len())
        {
            sample.fingers = vec![FingerState::default(); fingers.len()];
            sample.bodies = vec![BodyState::default(); bodies.len()];
            sample.contacts = vec![ContactSample::NONE; contacts.len()];
            there.fingers = vec![false; fingers.len()];
            there.bodies = vec![false; bodies.len()];
            there.contacts = vec![false; contacts.len()];
        }
        sample.time_s = time_s;
        Ok(())
    }

    fn put_contact(&mut self, index: usize, time_s: f64, contact: ContactSample) -> Result<(), Malformed> {
        if self.channels.begin_with_fingers() {
            // Of a sample of which the finger is lost.
            if self.there.fingers.is_empty() || !self.there.are_whole() {
                return Ok(());
            }
        } else {
            self.begin(time_s)?;
        }
        self.sample.contacts[index] = contact;
        self.there.count += usize::from(!std::mem::replace(&mut self.there.contacts[index], true));
        Ok(())
    }
}

fn finger(data: &[u8]) -> Result<(f64, FingerState), Malformed> {
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
    let finger = FingerState {
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
    };
    Ok((time_s, finger))
}

fn body(data: &[u8]) -> Result<(f64, BodyState), Malformed> {
    let [time_s, x, y, angle_rad, vx, vy, spin_rad_s] = numbers(data)?;
    Ok((time_s, BodyState { centre_m: [x, y], angle_rad, velocity_m_s: [vx, vy], spin_rad_s }))
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

/// A change of contact: its time, its kind, approach speed and impulse.
fn change(data: &[u8]) -> Result<(f64, EventKind, [f64; 2]), Malformed> {
    let [time_s, pressed, touch_down, approach_speed, impulse] = numbers(data)?;
    if !time_s.is_finite() {
        return Err(UNTIMED);
    }
    let kind = match (pressed != 0.0, touch_down != 0.0) {
        (false, _) => EventKind::LiftOff,
        (true, true) => EventKind::TouchDown,
        (true, false) => EventKind::Reload,
    };
    Ok((time_s, kind, [approach_speed, impulse]))
}
