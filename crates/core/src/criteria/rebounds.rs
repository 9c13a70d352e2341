//! Restitution: how fast two surfaces part over how fast they met.

use crate::numeric::elementary::hypot;
use crate::scene::{DiscMotion, Pair, Partner, System};
use crate::trace::{Event, EventKind, Sample, Sink, SinkError};

/// An approach slower than this part of the fastest body's speed is rounding: the difference of two velocities whose own errors are
/// about as large.
const SLOWEST_APPROACH: f64 = 1e-6;
/// A separation by this part of the approach speed is rounding.
const SEPARATION_ROUNDING: f64 = 1e-9;
/// A contact gives back at most what it took. The rest is the error of a coarse run; above it something else drove the pair apart.
const LARGEST_RESTITUTION: f64 = 1.01;
/// Part of the change of the gap rate that may be due to anything but the contact: gravity, drives, other contacts.
const LARGEST_OTHER_SHARE: f64 = 0.5;

/// The first impact of a pair: from its touch-down to its last lift-off before the pair meets again.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rebound {
    /// Closing speed −gap rate at the touch-down; `None` until there was one at speed.
    pub approach_m_s: Option<f64>,
    /// Gap rate once the force has ended; `None` while it presses.
    pub separation_m_s: Option<f64>,
    /// Largest speed of any body's centre in the run, m/s.
    fastest_m_s: f64,
    /// Change of the gap rate by the impulse of the contact alone, m/s; `None` where masses are not known.
    by_contact_m_s: Option<f64>,
    /// Whether the pair has met again: what follows is another impact.
    over: bool,
    /// Whether the next sample has the gap rate of the lift-off.
    waits: bool,
}

impl Rebound {
    /// Newton's coefficient: separation speed over approach speed.
    ///
    /// `None` where the ratio means nothing: the pair has not let go; the approach is rounding beside the fastest body of the run; the
    /// surfaces still close when the force ends; or the separation is not due to the impact, because it is faster than the approach by
    /// more than 1 %, or because less than half of the change of the gap rate is the contact's own impulse.
    pub fn restitution(&self) -> Option<f64> {
        let (approach, separation) = (self.approach_m_s?, self.separation_m_s?);
        let ratio = separation / approach;
        let meaningful = approach >= SLOWEST_APPROACH * self.fastest_m_s;
        let parts = (-SEPARATION_ROUNDING..=LARGEST_RESTITUTION).contains(&ratio);
        let change = approach + separation;
        let own = self.by_contact_m_s.is_none_or(|by| (change - by).abs() <= LARGEST_OTHER_SHARE * change);
        (meaningful && parts && own).then(|| ratio.max(0.0))
    }
}

/// Finds the first impact of every pair while a run streams by.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rebounds {
    pairs: Vec<Rebound>,
    /// Gap rate per unit of normal impulse of each pair, 1/kg; empty where masses are not known.
    mobilities_per_kg: Vec<f64>,
    /// Time and gap rates of the latest sample.
    time_s: f64,
    rates_m_s: Vec<f64>,
}

impl Rebounds {
    /// Of pairs of bodies whose masses are not known: any separation of at most the approach speed counts as due to the impact.
    pub fn new(pairs: usize) -> Self {
        Rebounds {
            pairs: vec![Rebound::default(); pairs],
            mobilities_per_kg: Vec::new(),
            time_s: f64::NEG_INFINITY,
            rates_m_s: vec![0.0; pairs],
        }
    }

    /// Of the pairs of a system of discs.
    pub fn of(system: &System) -> Self {
        let mobility = |disc: usize| match system.discs[disc].motion {
            DiscMotion::Free { mass_kg, .. } => mass_kg.recip(),
            DiscMotion::Fixed | DiscMotion::Driven { .. } => 0.0,
        };
        let pairs = system.pairs();
        let of_pair = |pair: &Pair| {
            let partner = match pair.partner {
                Partner::Disc(disc) => mobility(disc),
                Partner::HalfPlane => 0.0,
            };
            mobility(pair.disc) + partner
        };
        Rebounds { mobilities_per_kg: pairs.iter().map(of_pair).collect(), ..Self::new(pairs.len()) }
    }

    /// In the order of the scene's pairs.
    pub fn pairs(&self) -> &[Rebound] {
        &self.pairs
    }
}

impl Sink for Rebounds {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.time_s = sample.time_s;
        let speeds = sample.bodies.iter().map(|body| hypot(body.velocity_m_s[0], body.velocity_m_s[1]));
        let fastest_m_s = speeds.fold(0.0, f64::max);
        for pair in &mut self.pairs {
            pair.fastest_m_s = pair.fastest_m_s.max(fastest_m_s);
        }
        for ((pair, rate), contact) in self.pairs.iter_mut().zip(&mut self.rates_m_s).zip(&sample.contacts) {
            *rate = contact.gap_rate_m_s;
            if std::mem::take(&mut pair.waits) {
                pair.separation_m_s = Some(contact.gap_rate_m_s);
            }
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        let pair = &mut self.pairs[event.contact];
        match event.kind {
            EventKind::TouchDown if pair.approach_m_s.is_some() => {
                // Another impact only if the first has let go.
                pair.over |= pair.separation_m_s.is_some() || pair.waits;
            }
            EventKind::TouchDown if event.approach_speed > 0.0 => pair.approach_m_s = Some(event.approach_speed),
            EventKind::LiftOff if pair.approach_m_s.is_some() && !pair.over => {
                let mobility = self.mobilities_per_kg.get(event.contact);
                pair.by_contact_m_s = mobility.map(|mobility| mobility * event.impulse);
                // A model that lands on its events has a sample right there; after one within a step the pair is free,
                // and the end of the step has its rate.
                if self.time_s == event.time_s {
                    pair.separation_m_s = Some(self.rates_m_s[event.contact]);
                } else {
                    pair.waits = true;
                }
            }
            EventKind::Reload if !pair.over => (pair.separation_m_s, pair.waits) = (None, false),
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::ContactSample;

    fn sample(time_s: f64, gap_rate_m_s: f64) -> Sample {
        let contacts = vec![ContactSample { gap_rate_m_s, ..ContactSample::NONE }];
        Sample { time_s, contacts, ..Sample::default() }
    }

    fn event(time_s: f64, kind: EventKind, approach_speed: f64) -> Event {
        Event { time_s, contact: 0, kind, approach_speed, impulse: 0.0 }
    }

    fn found(run: &[(Option<f64>, f64, Option<EventKind>)]) -> Rebound {
        let mut rebounds = Rebounds::new(1);
        for &(rate, time_s, kind) in run {
            if let Some(rate) = rate {
                rebounds.sample(&sample(time_s, rate)).expect("kept");
            }
            if let Some(kind) = kind {
                rebounds.event(&event(time_s, kind, 2.0)).expect("kept");
            }
        }
        rebounds.pairs()[0]
    }

    #[test]
    fn the_rate_at_the_lift_off_counts_whether_there_is_a_sample_or_not() {
        use EventKind::{LiftOff, TouchDown};
        let landed = [(Some(-2.0), 1.0, Some(TouchDown)), (Some(1.0), 2.0, Some(LiftOff)), (Some(0.9), 3.0, None)];
        assert_eq!(found(&landed).restitution(), Some(0.5));
        let within =
            [(Some(-2.0), 0.9, None), (None, 1.0, Some(TouchDown)), (None, 2.0, Some(LiftOff)), (Some(1.5), 2.1, None)];
        assert_eq!(found(&within).restitution(), Some(0.75));
    }

    #[test]
    fn ratios_that_say_nothing_of_the_impact_are_none() {
        let impact = Rebound { approach_m_s: Some(2.0), separation_m_s: Some(1.0), ..Rebound::default() };
        assert_eq!(impact.restitution(), Some(0.5));
        // Rounding beside a fast body, but not in a scene that is slow as a whole.
        assert_eq!(Rebound { fastest_m_s: 3e6, ..impact }.restitution(), None);
        assert_eq!(Rebound { fastest_m_s: 1e6, ..impact }.restitution(), Some(0.5));
        let slow = Rebound { approach_m_s: Some(1e-8), separation_m_s: Some(1e-8), fastest_m_s: 1e-8, ..impact };
        assert_eq!(slow.restitution(), Some(1.0));
        // Faster apart than together, and closing still; rounding of nothing is nothing.
        let parts = |separation: f64| Rebound { separation_m_s: Some(separation), ..impact }.restitution();
        assert_eq!([2.01, 2.03, -0.1, -1e-17].map(parts), [Some(1.005), None, None, Some(0.0)]);
        // Of a change of 3 m/s the contact itself made so much.
        let by = |by: f64| Rebound { by_contact_m_s: Some(by), ..impact }.restitution();
        assert_eq!([3.0, 1.6, 1.4, 0.0, 4.6].map(by), [Some(0.5), Some(0.5), None, None, None]);
    }

    #[test]
    fn only_the_first_impact_counts_and_a_reload_belongs_to_it() {
        use EventKind::{LiftOff, Reload, TouchDown};
        let bounces = [
            (Some(-2.0), 1.0, Some(TouchDown)),
            (Some(0.2), 2.0, Some(LiftOff)),
            (Some(-0.1), 3.0, Some(Reload)),
            (Some(1.0), 4.0, Some(LiftOff)),
            (Some(-1.0), 5.0, Some(TouchDown)),
            (Some(0.3), 6.0, Some(LiftOff)),
        ];
        assert_eq!(found(&bounces).restitution(), Some(0.5));
        assert_eq!(found(&bounces[..1]).restitution(), None);
        assert_eq!(found(&bounces[..3]).restitution(), None, "pressed again");
    }
}
