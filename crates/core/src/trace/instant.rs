//! What the samples of all kinds of scene have in common: by it they are passed on, thinned and kept once for all.

use super::between::Between;
use super::columns::finger_values;
use super::{ContactSample, Event, Sample};
use crate::numeric::plane::near_turn;

/// One instant of a run, of whatever is simulated: a time, and a list of contacts.
pub trait Instant: Clone + PartialEq {
    /// A change at one of its contacts.
    type Event: Copy;

    fn time_s(&self) -> f64;
    /// Number of contacts.
    fn places(&self) -> usize;
    /// The contact at a place; of a finger in the order of [`Site::ALL`](super::Site::ALL).
    fn contact(&self, place: usize) -> &ContactSample;
    fn contact_mut(&mut self, place: usize) -> &mut ContactSample;

    /// Force (N; limit: N·m) and penetration (m; rad) at one place.
    fn pressed(&self, place: usize) -> (f64, f64) {
        let contact = self.contact(place);
        (contact.normal_n, -contact.gap_m)
    }

    /// All figures, in the order of the columns of a [`Recording`](super::Recording).
    fn values(&self) -> impl Iterator<Item = f64>;
    /// The one between two others.
    fn blend(a: &Self, b: &Self, at: &Between) -> Self;
    /// Takes over another sample of the same shape, keeping what it has allocated.
    fn copy_from(&mut self, other: &Self);
}

impl Instant for Sample {
    type Event = Event;

    fn time_s(&self) -> f64 {
        self.time_s
    }

    fn places(&self) -> usize {
        3
    }

    fn contact(&self, place: usize) -> &ContactSample {
        [&self.proximal, &self.distal, &self.limit][place]
    }

    fn contact_mut(&mut self, place: usize) -> &mut ContactSample {
        match place {
            0 => &mut self.proximal,
            1 => &mut self.distal,
            _ => &mut self.limit,
        }
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        finger_values(self)
    }

    fn blend(a: &Self, b: &Self, at: &Between) -> Self {
        let of = |field: fn(&Sample) -> f64| at.line(field(a), field(b));
        // A passive angle may come back at −π where it went out at π.
        let q = |angle: fn(&Sample) -> f64, rate: fn(&Sample) -> f64| {
            at.cubic(angle(a), rate(a), near_turn(angle(b), angle(a)), rate(b))
        };
        Sample {
            time_s: at.time_s,
            q11_rad: q(|s| s.q11_rad, |s| s.qd11_rad_s),
            q21_rad: q(|s| s.q21_rad, |s| s.qd21_rad_s),
            q12_rad: q(|s| s.q12_rad, |s| s.qd12_rad_s),
            q22_rad: q(|s| s.q22_rad, |s| s.qd22_rad_s),
            q13_rad: q(|s| s.q13_rad, |s| s.qd21_rad_s + s.qd22_rad_s),
            qd11_rad_s: of(|s| s.qd11_rad_s),
            qd21_rad_s: of(|s| s.qd21_rad_s),
            qd12_rad_s: of(|s| s.qd12_rad_s),
            qd22_rad_s: of(|s| s.qd22_rad_s),
            motor_torque_n_m: of(|s| s.motor_torque_n_m),
            proximal: at.contact(&a.proximal, &b.proximal),
            distal: at.contact(&a.distal, &b.distal),
            limit: at.contact(&a.limit, &b.limit),
            energy: at.energy(&a.energy, &b.energy),
        }
    }

    fn copy_from(&mut self, other: &Self) {
        *self = *other;
    }
}
