//! Restitution: how fast two surfaces part over how fast they met.

use crate::trace::{Event, EventKind, Sample, Sink, SinkError};

/// The first impact of a pair: from its touch-down to its last lift-off before the pair meets again.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rebound {
    /// Closing speed −gap rate at the touch-down; `None` until there was one at speed.
    pub approach_m_s: Option<f64>,
    /// Gap rate once the force has ended; `None` while it presses.
    pub separation_m_s: Option<f64>,
    /// Whether the pair has met again: what follows is another impact.
    over: bool,
    /// Whether the next sample has the gap rate of the lift-off.
    waits: bool,
}

impl Rebound {
    /// Separation speed over approach speed (Newton's coefficient); `None` where the pair has not let go.
    pub fn restitution(&self) -> Option<f64> {
        Some(self.separation_m_s? / self.approach_m_s?)
    }
}

/// Finds the first impact of every pair while a run streams by.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rebounds {
    pairs: Vec<Rebound>,
    /// Time and gap rates of the latest sample.
    time_s: f64,
    rates_m_s: Vec<f64>,
}

impl Rebounds {
    pub fn new(pairs: usize) -> Self {
        Rebounds { pairs: vec![Rebound::default(); pairs], time_s: f64::NEG_INFINITY, rates_m_s: vec![0.0; pairs] }
    }

    /// In the order of the scene's pairs.
    pub fn pairs(&self) -> &[Rebound] {
        &self.pairs
    }
}

impl Sink for Rebounds {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.time_s = sample.time_s;
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
