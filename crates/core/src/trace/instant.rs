//! What the samples of all kinds of scene have in common: by it they are passed on, thinned and kept once for all.

use super::between::Between;
use super::columns::finger_values;
use super::{ContactSample, Energy, Event, EventKind, Outcome, Sample, Site, SiteSummary, Work};
use crate::numeric::plane::near_turn;

/// One instant of a run, of whatever is simulated: a time, and a list of contacts.
pub trait Instant: Clone + PartialEq {
    /// A change at one of its contacts.
    type Event: Copy;
    /// What a run comes to.
    type Outcome: Default;
    /// A list with one entry for each contact: an array where their number is known, so that nothing is allocated.
    type Each<T>: AsRef<[T]> + AsMut<[T]>;

    fn each<T>(places: usize, of: impl FnMut(usize) -> T) -> Self::Each<T>;
    /// An event of a place: `approach` is the closing speed at a touch-down, `impulse` that since it at a lift-off, else 0.
    fn event(time_s: f64, place: usize, kind: EventKind, approach: f64, impulse: f64) -> Self::Event;
    /// What a run with this last sample comes to.
    fn outcome(self, sites: Self::Each<SiteSummary>, work: Work, loop_gap_m: f64) -> Self::Outcome;

    fn time_s(&self) -> f64;
    /// Number of contacts.
    fn places(&self) -> usize;
    /// The contact at a place; of a finger in the order of [`Site::ALL`](super::Site::ALL).
    fn contact(&self, place: usize) -> &ContactSample;
    fn contact_mut(&mut self, place: usize) -> &mut ContactSample;

    fn energy(&self) -> &Energy;

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
    type Outcome = Outcome;
    type Each<T> = [T; 3];

    fn each<T>(_: usize, of: impl FnMut(usize) -> T) -> [T; 3] {
        std::array::from_fn(of)
    }

    fn event(time_s: f64, place: usize, kind: EventKind, approach_speed: f64, impulse: f64) -> Event {
        Event { time_s, site: Site::ALL[place], kind, approach_speed, impulse }
    }

    fn outcome(self, sites: [SiteSummary; 3], work: Work, loop_gap_m: f64) -> Outcome {
        Outcome { last: self, sites, work, loop_gap_m }
    }

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

    fn energy(&self) -> &Energy {
        &self.energy
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
