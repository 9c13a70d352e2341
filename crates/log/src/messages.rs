//! Messages of the log: flat structs of named doubles, one type per kind of channel, each with the time of its sample.
//!
//! `#[derive(foxglove::Encode)]` numbers the fields in order and generates the descriptor embedded in the log. Readers
//! use field names; append new fields at the end.

use foxglove::Encode;

use phalanx_core::trace::{self, BodyState, ContactSample, Event, EventKind, FingerState};

/// `/state`: joint angles and rates, motor torque.
#[derive(Clone, Copy, Debug, PartialEq, Encode)]
pub struct State {
    /// Time since the start of the run, in s.
    pub timestamp: f64,
    pub q11_rad: f64,
    pub q21_rad: f64,
    pub q12_rad: f64,
    pub q22_rad: f64,
    pub q13_rad: f64,
    pub qd11_rad_s: f64,
    pub qd21_rad_s: f64,
    pub qd12_rad_s: f64,
    pub qd22_rad_s: f64,
    pub motor_torque_n_m: f64,
}

/// `/disc/…`: one disc of a scene of discs. The angle is counter-clockwise and not wrapped.
#[derive(Clone, Copy, Debug, PartialEq, Encode)]
pub struct Disc {
    /// Time since the start of the run, in s.
    pub timestamp: f64,
    pub x_m: f64,
    pub y_m: f64,
    pub angle_rad: f64,
    pub vx_m_s: f64,
    pub vy_m_s: f64,
    pub spin_rad_s: f64,
}

/// `/contact/…`: one phalanx against the object, or a disc against its partner. Forces act on the phalanx (the disc);
/// the normal is a unit vector from the object (the partner) to it.
#[derive(Clone, Copy, Debug, PartialEq, Encode)]
pub struct Contact {
    pub timestamp: f64,
    pub gap_m: f64,
    pub gap_rate_m_s: f64,
    pub slip_m_s: f64,
    pub normal_n: f64,
    pub tangential_n: f64,
    pub point_x_m: f64,
    pub point_y_m: f64,
    pub normal_x: f64,
    pub normal_y: f64,
    /// Normal impulse since the start.
    pub impulse_n_s: f64,
}

/// `/limit`: the joint limit q22 ≥ −φ22.
#[derive(Clone, Copy, Debug, PartialEq, Encode)]
pub struct Limit {
    pub timestamp: f64,
    pub gap_rad: f64,
    pub gap_rate_rad_s: f64,
    pub torque_n_m: f64,
    pub impulse_n_m_s: f64,
}

/// `/energy`: energies and works since the start.
#[derive(Clone, Copy, Debug, PartialEq, Encode)]
pub struct Energy {
    pub timestamp: f64,
    pub kinetic_j: f64,
    pub gravity_j: f64,
    pub spring_j: f64,
    pub elastic_j: f64,
    pub dissipated_j: f64,
    pub motor_work_j: f64,
    pub balance_j: f64,
}

/// `/impact/…`: a change of contact.
///
/// | | `pressed` | `touch_down` | |
/// |---|---|---|---|
/// | touch-down | true | true | with its approach speed |
/// | lift-off | false | false | with the impulse since the touch-down |
/// | reload | true | false | the force returns before the surfaces have parted |
#[derive(Clone, Copy, Debug, PartialEq, Encode)]
pub struct Impact {
    pub timestamp: f64,
    /// Whether a contact force acts from now on.
    pub pressed: bool,
    /// Whether the surfaces come into contact.
    pub touch_down: bool,
    pub approach_speed_m_s: f64,
    pub impulse_n_s: f64,
}

/// `/impact/limit`: a change of contact at the joint limit.
#[derive(Clone, Copy, Debug, PartialEq, Encode)]
pub struct LimitImpact {
    pub timestamp: f64,
    pub pressed: bool,
    pub touch_down: bool,
    pub approach_speed_rad_s: f64,
    pub impulse_n_m_s: f64,
}

/// `/slip/…`: friction with stiction reaches the friction cone, where the slider of its bristle begins to slip, or is
/// inside the cone again. Only for contacts with bristles.
#[derive(Clone, Copy, Debug, PartialEq, Encode)]
pub struct Slip {
    pub timestamp: f64,
    /// Whether the contact slips from now on.
    pub slips: bool,
}

impl State {
    pub fn new(time_s: f64, finger: &FingerState) -> Self {
        State {
            timestamp: time_s,
            q11_rad: finger.q11_rad,
            q21_rad: finger.q21_rad,
            q12_rad: finger.q12_rad,
            q22_rad: finger.q22_rad,
            q13_rad: finger.q13_rad,
            qd11_rad_s: finger.qd11_rad_s,
            qd21_rad_s: finger.qd21_rad_s,
            qd12_rad_s: finger.qd12_rad_s,
            qd22_rad_s: finger.qd22_rad_s,
            motor_torque_n_m: finger.motor_torque_n_m,
        }
    }
}

impl Contact {
    pub fn new(time_s: f64, contact: &ContactSample) -> Self {
        Contact {
            timestamp: time_s,
            gap_m: contact.gap_m,
            gap_rate_m_s: contact.gap_rate_m_s,
            slip_m_s: contact.slip_m_s,
            normal_n: contact.normal_n,
            tangential_n: contact.tangential_n,
            point_x_m: contact.point_m[0],
            point_y_m: contact.point_m[1],
            normal_x: contact.normal[0],
            normal_y: contact.normal[1],
            impulse_n_s: contact.impulse_n_s,
        }
    }
}

impl Limit {
    pub fn new(time_s: f64, limit: &ContactSample) -> Self {
        Limit {
            timestamp: time_s,
            gap_rad: limit.gap_m,
            gap_rate_rad_s: limit.gap_rate_m_s,
            torque_n_m: limit.normal_n,
            impulse_n_m_s: limit.impulse_n_s,
        }
    }
}

impl Disc {
    pub fn new(time_s: f64, disc: &BodyState) -> Self {
        Disc {
            timestamp: time_s,
            x_m: disc.centre_m[0],
            y_m: disc.centre_m[1],
            angle_rad: disc.angle_rad,
            vx_m_s: disc.velocity_m_s[0],
            vy_m_s: disc.velocity_m_s[1],
            spin_rad_s: disc.spin_rad_s,
        }
    }
}

impl Energy {
    pub fn new(time_s: f64, energy: &trace::Energy) -> Self {
        Energy {
            timestamp: time_s,
            kinetic_j: energy.kinetic_j,
            gravity_j: energy.gravity_j,
            spring_j: energy.spring_j,
            elastic_j: energy.elastic_j,
            dissipated_j: energy.dissipated_j,
            motor_work_j: energy.motor_work_j,
            balance_j: energy.balance_j,
        }
    }
}

impl From<&Event> for Impact {
    fn from(event: &Event) -> Self {
        Impact {
            timestamp: event.time_s,
            pressed: event.kind != EventKind::LiftOff,
            touch_down: event.kind == EventKind::TouchDown,
            approach_speed_m_s: event.approach_speed,
            impulse_n_s: event.impulse,
        }
    }
}

impl From<&Event> for Slip {
    fn from(event: &Event) -> Self {
        Slip { timestamp: event.time_s, slips: event.kind == EventKind::Slips }
    }
}

impl From<&Event> for LimitImpact {
    fn from(event: &Event) -> Self {
        LimitImpact {
            timestamp: event.time_s,
            pressed: event.kind != EventKind::LiftOff,
            touch_down: event.kind == EventKind::TouchDown,
            approach_speed_rad_s: event.approach_speed,
            impulse_n_m_s: event.impulse,
        }
    }
}

/// Returns the log time of a sample: nanoseconds since the start, rounded to the nearest.
pub fn stamp_ns(time_s: f64) -> u64 {
    // A cast from float saturates, so this cannot wrap.
    (time_s * 1e9).round() as u64
}
