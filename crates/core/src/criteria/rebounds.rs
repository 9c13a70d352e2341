//! Restitution: separation speed of two surfaces over their approach speed.

use crate::mechanism::{Mechanism, OutlineId, OutlineShape};
use crate::numeric::elementary::hypot;
use crate::trace::{Event, EventKind, RequiredData, Sample, Sink, SinkError};

/// Smallest approach speed relative to the fastest body; a slower approach is the rounding error of two velocities.
const MIN_RELATIVE_APPROACH: f64 = 1e-6;
/// Largest ratio of separation and approach speed that is rounding error.
const SEPARATION_ROUNDING: f64 = 1e-9;
/// Largest valid restitution. Physically it is at most 1; the margin is for the error of a coarse run. Above it,
/// something other than the contact separated the pair.
const MAX_RESTITUTION: f64 = 1.01;
/// Largest fraction of the change of the gap rate that may have other causes: gravity, drives, other contacts.
const MAX_OTHER_FRACTION: f64 = 0.5;

/// The first impact of a pair: from its touch-down to the last lift-off before the next touch-down.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rebound {
    /// Approach speed (−gap rate) at the touch-down, m/s; `None` before the first touch-down with a positive approach
    /// speed.
    pub approach_m_s: Option<f64>,
    /// Gap rate after the force has ended, m/s; `None` while the force lasts.
    pub separation_m_s: Option<f64>,
    /// Largest speed of any body's centre in the run, m/s.
    fastest_m_s: f64,
    /// Change of the gap rate due to the impulse of the contact, m/s; `None` if masses are unknown.
    contact_change_m_s: Option<f64>,
    /// Whether the pair has touched again, so later events belong to another impact.
    is_finished: bool,
    /// Whether the next sample gives the gap rate at the lift-off.
    awaits_separation: bool,
}

impl Rebound {
    /// Returns Newton's coefficient of restitution: the ratio of separation speed to approach speed.
    ///
    /// It is `None` where the ratio is meaningless:
    /// * The pair has not separated, or the surfaces still approach when the force ends.
    /// * The approach speed is a rounding error relative to the fastest body of the run.
    /// * The impact does not cause the separation: it is more than 1 % faster than the approach, or the contact impulse
    ///   causes less than half of the change of the gap rate.
    pub fn restitution(&self) -> Option<f64> {
        let (approach, separation) = (self.approach_m_s?, self.separation_m_s?);
        let ratio = separation / approach;
        let is_significant = approach >= MIN_RELATIVE_APPROACH * self.fastest_m_s;
        let is_separation = (-SEPARATION_ROUNDING..=MAX_RESTITUTION).contains(&ratio);
        let change = approach + separation;
        let is_caused_by_contact =
            self.contact_change_m_s.is_none_or(|by_contact| (change - by_contact).abs() <= MAX_OTHER_FRACTION * change);
        (is_significant && is_separation && is_caused_by_contact).then(|| ratio.max(0.0))
    }
}

/// A [`Sink`] that finds the first impact of each pair during a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rebounds {
    pairs: Vec<Rebound>,
    /// Change of the gap rate per normal impulse of each pair, 1/kg; empty if masses are unknown.
    mobilities_per_kg: Vec<f64>,
    /// Time of the last sample.
    time_s: f64,
    /// Gap rates in the last sample.
    rates_m_s: Vec<f64>,
}

impl Rebounds {
    /// Creates the sink for bodies of unknown mass. A separation that is not faster than the approach is attributed to
    /// the impact.
    pub fn new(pairs: usize) -> Self {
        Rebounds {
            pairs: vec![Rebound::default(); pairs],
            mobilities_per_kg: Vec::new(),
            time_s: f64::NEG_INFINITY,
            rates_m_s: vec![0.0; pairs],
        }
    }

    /// Creates the sink for the contacts of a mechanism. `None` if the mechanism has joints, or if a contact force does
    /// not pass through the centres of mass.
    pub fn for_mechanism(mechanism: &Mechanism) -> Option<Self> {
        let mobility = |id: OutlineId| match (id.body.map(|body| &mechanism.bodies[body]), &mechanism.outline(id).shape)
        {
            (Some(body), OutlineShape::Disc { center_m, .. }) if body.motion.is_none() => {
                (*center_m == body.com_m).then(|| body.mass_kg.recip())
            }
            (None, _) => Some(0.0),
            (Some(body), _) => body.motion.as_ref().map(|_| 0.0),
        };
        let points = mechanism.point_contacts().into_iter().map(|point| &mechanism.contacts[point.pair]);
        let mobilities = points.map(|pair| Some(mobility(pair.points)? + mobility(pair.face)?));
        let mobilities_per_kg = mobilities.collect::<Option<Vec<f64>>>().filter(|_| mechanism.joints.is_empty())?;
        let count = mobilities_per_kg.len();
        Some(Rebounds { mobilities_per_kg, ..Self::new(count) })
    }

    pub fn pairs(&self) -> &[Rebound] {
        &self.pairs
    }
}

impl Sink for Rebounds {
    fn required_data(&self) -> RequiredData {
        RequiredData { peaks: true, ..RequiredData::NONE }
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.time_s = sample.time_s;
        let speeds = sample.bodies().map(|body| hypot(body.velocity_m_s[0], body.velocity_m_s[1]));
        let fastest_m_s = speeds.fold(0.0, f64::max);
        for pair in &mut self.pairs {
            pair.fastest_m_s = pair.fastest_m_s.max(fastest_m_s);
        }
        for ((pair, rate), contact) in self.pairs.iter_mut().zip(&mut self.rates_m_s).zip(sample.contacts()) {
            *rate = contact.gap_rate_m_s;
            if std::mem::take(&mut pair.awaits_separation) {
                pair.separation_m_s = Some(contact.gap_rate_m_s);
            }
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        let pair = &mut self.pairs[event.contact];
        match event.kind {
            EventKind::TouchDown if pair.approach_m_s.is_some() => {
                // Another impact only if the pair has separated after the first.
                pair.is_finished |= pair.separation_m_s.is_some() || pair.awaits_separation;
            }
            EventKind::TouchDown if event.approach_speed > 0.0 => pair.approach_m_s = Some(event.approach_speed),
            EventKind::LiftOff if pair.approach_m_s.is_some() && !pair.is_finished => {
                let mobility = self.mobilities_per_kg.get(event.contact);
                pair.contact_change_m_s = mobility.map(|mobility| mobility * event.impulse);
                // With event location there is a sample at the event. Otherwise the pair is free for the rest of the
                // step, and the sample at its end gives the rate.
                if self.time_s == event.time_s {
                    pair.separation_m_s = Some(self.rates_m_s[event.contact]);
                } else {
                    pair.awaits_separation = true;
                }
            }
            EventKind::Reload if !pair.is_finished => (pair.separation_m_s, pair.awaits_separation) = (None, false),
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
        Sample::of(time_s, &[], &[], &contacts)
    }

    fn event(time_s: f64, kind: EventKind, approach_speed: f64) -> Event {
        Event { time_s, contact: 0, kind, approach_speed, impulse: 0.0 }
    }

    fn rebound(run: &[(Option<f64>, f64, Option<EventKind>)]) -> Rebound {
        let mut rebounds = Rebounds::new(1);
        for &(rate, time_s, kind) in run {
            if let Some(rate) = rate {
                rebounds.sample(&sample(time_s, rate)).expect("accepted");
            }
            if let Some(kind) = kind {
                rebounds.event(&event(time_s, kind, 2.0)).expect("accepted");
            }
        }
        rebounds.pairs()[0]
    }

    #[test]
    fn uses_the_rate_at_the_lift_off_with_or_without_a_sample() {
        use EventKind::{LiftOff, TouchDown};
        let at_events = [(Some(-2.0), 1.0, Some(TouchDown)), (Some(1.0), 2.0, Some(LiftOff)), (Some(0.9), 3.0, None)];
        assert_eq!(rebound(&at_events).restitution(), Some(0.5));
        let between_samples =
            [(Some(-2.0), 0.9, None), (None, 1.0, Some(TouchDown)), (None, 2.0, Some(LiftOff)), (Some(1.5), 2.1, None)];
        assert_eq!(rebound(&between_samples).restitution(), Some(0.75));
    }

    #[test]
    fn meaningless_ratios_are_none() {
        let impact = Rebound { approach_m_s: Some(2.0), separation_m_s: Some(1.0), ..Rebound::default() };
        assert_eq!(impact.restitution(), Some(0.5));
        // Rounding error relative to a fast body, but not in a scene in which all bodies are slow.
        assert_eq!(Rebound { fastest_m_s: 3e6, ..impact }.restitution(), None);
        assert_eq!(Rebound { fastest_m_s: 1e6, ..impact }.restitution(), Some(0.5));
        let slow = Rebound { approach_m_s: Some(1e-8), separation_m_s: Some(1e-8), fastest_m_s: 1e-8, ..impact };
        assert_eq!(slow.restitution(), Some(1.0));
        // Separation faster than the approach, and surfaces that still approach; a rounding error of 0 counts as 0.
        let with_separation = |separation: f64| Rebound { separation_m_s: Some(separation), ..impact }.restitution();
        assert_eq!([2.01, 2.03, -0.1, -1e-17].map(with_separation), [Some(1.005), None, None, Some(0.0)]);
        // Contribution of the contact to a change of 3 m/s.
        let with_change = |change: f64| Rebound { contact_change_m_s: Some(change), ..impact }.restitution();
        assert_eq!([3.0, 1.6, 1.4, 0.0, 4.6].map(with_change), [Some(0.5), Some(0.5), None, None, None]);
    }

    #[test]
    fn a_reload_belongs_to_the_first_impact() {
        use EventKind::{LiftOff, Reload, TouchDown};
        let bounces = [
            (Some(-2.0), 1.0, Some(TouchDown)),
            (Some(0.2), 2.0, Some(LiftOff)),
            (Some(-0.1), 3.0, Some(Reload)),
            (Some(1.0), 4.0, Some(LiftOff)),
            (Some(-1.0), 5.0, Some(TouchDown)),
            (Some(0.3), 6.0, Some(LiftOff)),
        ];
        assert_eq!(rebound(&bounces).restitution(), Some(0.5));
        assert_eq!(rebound(&bounces[..1]).restitution(), None);
        assert_eq!(rebound(&bounces[..3]).restitution(), None, "in contact again");
    }
}
