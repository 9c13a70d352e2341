//! A sample of discs as one of any kind of scene.

use super::{BodiesEvent, BodiesOutcome, BodiesSample, DiscState};
use crate::trace::between::Between;
use crate::trace::columns::discs_values;
use crate::trace::{ContactSample, Energy, EventKind, Instant, SiteSummary, Work};

impl Instant for BodiesSample {
    type Event = BodiesEvent;
    type Outcome = BodiesOutcome;
    type Each<T> = Vec<T>;

    fn each<T>(places: usize, of: impl FnMut(usize) -> T) -> Vec<T> {
        (0..places).map(of).collect()
    }

    fn event(time_s: f64, pair: usize, kind: EventKind, approach_m_s: f64, impulse_n_s: f64) -> BodiesEvent {
        BodiesEvent { time_s, pair, kind, approach_m_s, impulse_n_s }
    }

    fn outcome(self, pairs: Vec<SiteSummary>, work: Work, _: f64) -> BodiesOutcome {
        BodiesOutcome { last: self, pairs, work }
    }

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

    fn energy(&self) -> &Energy {
        &self.energy
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        discs_values(self)
    }

    fn blend(a: &Self, b: &Self, at: &Between) -> Self {
        let disc = |(a, b): (&DiscState, &DiscState)| {
            let axis = |i: usize| at.cubic(a.centre_m[i], a.velocity_m_s[i], b.centre_m[i], b.velocity_m_s[i]);
            DiscState {
                centre_m: [axis(0), axis(1)],
                angle_rad: at.cubic(a.angle_rad, a.spin_rad_s, b.angle_rad, b.spin_rad_s),
                velocity_m_s: at.pair(a.velocity_m_s, b.velocity_m_s),
                spin_rad_s: at.line(a.spin_rad_s, b.spin_rad_s),
            }
        };
        BodiesSample {
            time_s: at.time_s,
            discs: a.discs.iter().zip(&b.discs).map(disc).collect(),
            contacts: a.contacts.iter().zip(&b.contacts).map(|(a, b)| at.contact(a, b)).collect(),
            energy: at.energy(&a.energy, &b.energy),
        }
    }

    fn copy_from(&mut self, other: &Self) {
        self.clone_from(other);
    }
}
