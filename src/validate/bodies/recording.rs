//! A run of discs kept whole.

use crate::trace::bodies::{BodiesEvent, BodiesOutcome, BodiesSample, BodiesSink, DiscState};
use crate::trace::{ContactSample, Energy, SinkError};

/// Everything a run said, in memory.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodiesRecording {
    /// In order of time; two may share one.
    pub samples: Vec<BodiesSample>,
    pub events: Vec<BodiesEvent>,
    pub outcome: BodiesOutcome,
}

impl BodiesSink for BodiesRecording {
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
    /// The samples around a time, of which the second may be the first; `cursor` is where the last search ended. `None`
    /// without samples.
    pub fn around(&self, time_s: f64, cursor: &mut usize) -> Option<(&BodiesSample, &BodiesSample)> {
        let last = self.samples.len().checked_sub(1)?;
        *cursor = (*cursor).min(last);
        if self.samples[*cursor].time_s > time_s {
            *cursor = self.samples.partition_point(|sample| sample.time_s <= time_s).saturating_sub(1);
        }
        while *cursor < last && self.samples[*cursor + 1].time_s <= time_s {
            *cursor += 1;
        }
        Some((&self.samples[*cursor], &self.samples[(*cursor + 1).min(last)]))
    }

    /// The state at a time, between the samples around it.
    pub fn at(&self, time_s: f64, cursor: &mut usize) -> Option<BodiesSample> {
        let (from, to) = self.around(time_s, cursor)?;
        Some(between(from, to, time_s.min(to.time_s)))
    }
}

/// The sample at time `t` between `a` and `b`: places and angles by cubic Hermite interpolation, all else linear.
pub fn between(a: &BodiesSample, b: &BodiesSample, t: f64) -> BodiesSample {
    let h = b.time_s - a.time_s;
    if h <= 0.0 {
        return b.clone();
    }
    let x = ((t - a.time_s) / h).clamp(0.0, 1.0);
    let line = |p: f64, q: f64| p + x * (q - p);
    let cubic = |p: f64, v: f64, q: f64, w: f64| {
        let (x2, x3) = (x * x, x * x * x);
        p + (q - p) * (3.0 * x2 - 2.0 * x3) + h * (v * (x3 - 2.0 * x2 + x) + w * (x3 - x2))
    };
    let disc = |(a, b): (&DiscState, &DiscState)| DiscState {
        centre_m: [0, 1].map(|k| cubic(a.centre_m[k], a.velocity_m_s[k], b.centre_m[k], b.velocity_m_s[k])),
        angle_rad: cubic(a.angle_rad, a.spin_rad_s, b.angle_rad, b.spin_rad_s),
        velocity_m_s: [0, 1].map(|k| line(a.velocity_m_s[k], b.velocity_m_s[k])),
        spin_rad_s: line(a.spin_rad_s, b.spin_rad_s),
    };
    let contact = |(a, b): (&ContactSample, &ContactSample)| ContactSample {
        gap_m: line(a.gap_m, b.gap_m),
        gap_rate_m_s: line(a.gap_rate_m_s, b.gap_rate_m_s),
        slip_m_s: line(a.slip_m_s, b.slip_m_s),
        normal_n: line(a.normal_n, b.normal_n),
        tangential_n: line(a.tangential_n, b.tangential_n),
        impulse_n_s: line(a.impulse_n_s, b.impulse_n_s),
        point_m: [0, 1].map(|k| line(a.point_m[k], b.point_m[k])),
        normal: [0, 1].map(|k| line(a.normal[k], b.normal[k])),
    };
    let energy = |field: fn(&Energy) -> f64| line(field(&a.energy), field(&b.energy));
    BodiesSample {
        time_s: t,
        discs: a.discs.iter().zip(&b.discs).map(disc).collect(),
        contacts: a.contacts.iter().zip(&b.contacts).map(contact).collect(),
        energy: Energy {
            kinetic_j: energy(|e| e.kinetic_j),
            gravity_j: energy(|e| e.gravity_j),
            spring_j: energy(|e| e.spring_j),
            elastic_j: energy(|e| e.elastic_j),
            dissipated_j: energy(|e| e.dissipated_j),
            motor_work_j: energy(|e| e.motor_work_j),
            balance_j: energy(|e| e.balance_j),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
