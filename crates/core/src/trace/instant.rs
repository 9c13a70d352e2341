//! What the samples of all kinds of scene have in common: by it they are passed on, thinned and kept once for all.

use super::bodies::{BodiesEvent, BodiesSample};
use super::columns::{discs_values, finger_values};
use super::{ContactSample, Event, Sample};

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

    fn copy_from(&mut self, other: &Self) {
        *self = *other;
    }
}

impl Instant for BodiesSample {
    type Event = BodiesEvent;

    fn time_s(&self) -> f64 {
        self.time_s
    }

    fn places(&self) -> usize {
        self.contacts.len()
    }

    fn contact(&self, place: usize) -> &ContactSample {
        &self.contacts[place]
    }

    fn contact_mut(&mut self, place: usize) -> &mut ContactSample {
        &mut self.contacts[place]
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        discs_values(self)
    }

    fn copy_from(&mut self, other: &Self) {
        self.clone_from(other);
    }
}
