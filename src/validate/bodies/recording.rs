//! A run of discs kept whole.

use crate::trace::bodies::{BodiesEvent, BodiesOutcome, BodiesSample};
use crate::trace::{Sink, SinkError, between};

/// Everything a run said, in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodiesRecording {
    /// In order of time; two may share one.
    pub samples: Vec<BodiesSample>,
    pub events: Vec<BodiesEvent>,
    pub outcome: BodiesOutcome,
}

impl Sink<BodiesSample> for BodiesRecording {
    fn sample(&mut self, sample: &BodiesSample) -> Result<(), SinkError> {
        self.samples.push(sample.clone());
        Ok(())
    }

    fn event(&mut self, event: &BodiesEvent) -> Result<(), SinkError> {
        self.events.push(*event);
        Ok(())
    }
}

impl BodiesRecording {
    /// The state at a time, between the samples around it; `cursor` is where the last search ended, and makes going
    /// through in order cheap. `None` without samples.
    pub fn at(&self, time_s: f64, cursor: &mut usize) -> Option<BodiesSample> {
        let last = self.samples.len().checked_sub(1)?;
        *cursor = (*cursor).min(last);
        if self.samples[*cursor].time_s > time_s {
            *cursor = self.samples.partition_point(|sample| sample.time_s <= time_s).saturating_sub(1);
        }
        while *cursor < last && self.samples[*cursor + 1].time_s <= time_s {
            *cursor += 1;
        }
        let (from, to) = (&self.samples[*cursor], &self.samples[(*cursor + 1).min(last)]);
        Some(between(from, to, time_s.min(to.time_s)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::bodies::DiscState;

    fn thrown(time_s: f64) -> BodiesSample {
        let disc = DiscState {
            centre_m: [3.0 * time_s, 1.0 - 5.0 * time_s * time_s],
            angle_rad: 7.0 * time_s,
            velocity_m_s: [3.0, -10.0 * time_s],
            spin_rad_s: 7.0,
        };
        BodiesSample { time_s, discs: vec![disc], ..BodiesSample::default() }
    }

    #[test]
    fn a_throw_between_two_samples_is_exact() {
        let recording = BodiesRecording { samples: [0.0, 0.5, 2.0].map(thrown).to_vec(), ..BodiesRecording::default() };
        let mut cursor = 0;
        for t in [0.0, 0.2, 0.5, 1.1, 2.0, 0.3] {
            let (found, expected) = (recording.at(t, &mut cursor).expect("samples"), thrown(t));
            let (found, expected) = (found.discs[0], expected.discs[0]);
            for k in 0..2 {
                assert!((found.centre_m[k] - expected.centre_m[k]).abs() < 1e-14, "{t}");
                assert!((found.velocity_m_s[k] - expected.velocity_m_s[k]).abs() < 1e-14, "{t}");
            }
            assert!((found.angle_rad - expected.angle_rad).abs() < 1e-14, "{t}");
        }
        assert_eq!(BodiesRecording::default().at(0.0, &mut 0), None);
    }
}
