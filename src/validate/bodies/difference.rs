//! Everything in which a run of discs differs from its reference.

use super::super::Recording;
use super::super::Track;
use super::super::difference::{distance, larger};
use crate::trace::{ContactSummary, Event, Outcome, Sample, Sink, SinkError};

/// Pairs with less than this part of the largest figure of all are too small to compare in it.
const SIGNIFICANT: f64 = 0.01;

/// Differences of a run from its reference, or the worst of several. Infinite where one of the two has what the other
/// lacks; `None` where neither has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodiesDifferences {
    /// Of the centre of each disc: largest distance, its time, root mean square, at the end.
    pub position_max_m: Vec<f64>,
    pub position_max_at_s: Vec<f64>,
    pub position_rms_m: Vec<f64>,
    pub position_end_m: Vec<f64>,
    /// Of the angle of each disc, at the end.
    pub angle_end_rad: Vec<f64>,
    /// First touch-down of each pair.
    pub contact_time_s: Vec<Option<f64>>,
    /// Relative difference of the normal impulse of each pair, and of its largest normal force.
    pub impulse: Vec<Option<f64>>,
    pub peak_force: Vec<Option<f64>>,
    /// Largest excess of the energy balance, in J and relative to the energy there is.
    pub energy_created_j: f64,
    pub energy_created: f64,
}

impl BodiesDifferences {
    /// Largest difference of any disc.
    pub fn position_m(&self) -> f64 {
        self.position_max_m.iter().copied().fold(0.0, f64::max)
    }

    /// Worst of all pairs.
    pub fn contact_time(&self) -> Option<f64> {
        worst(&self.contact_time_s)
    }

    /// Worst of all pairs.
    pub fn impulse(&self) -> Option<f64> {
        worst(&self.impulse)
    }

    /// Worst of all pairs.
    pub fn peak_force(&self) -> Option<f64> {
        worst(&self.peak_force)
    }

    /// The worse of each figure.
    pub fn worst(&self, other: &Self) -> Self {
        let mut worst = self.clone();
        for k in 0..self.position_max_m.len() {
            if other.position_max_m[k] > self.position_max_m[k] {
                (worst.position_max_m[k], worst.position_max_at_s[k]) =
                    (other.position_max_m[k], other.position_max_at_s[k]);
            }
            worst.position_rms_m[k] = self.position_rms_m[k].max(other.position_rms_m[k]);
            worst.position_end_m[k] = self.position_end_m[k].max(other.position_end_m[k]);
            worst.angle_end_rad[k] = self.angle_end_rad[k].max(other.angle_end_rad[k]);
        }
        for k in 0..self.impulse.len() {
            worst.contact_time_s[k] = larger(self.contact_time_s[k], other.contact_time_s[k]);
            worst.impulse[k] = larger(self.impulse[k], other.impulse[k]);
            worst.peak_force[k] = larger(self.peak_force[k], other.peak_force[k]);
        }
        worst.energy_created_j = self.energy_created_j.max(other.energy_created_j);
        worst.energy_created = self.energy_created.max(other.energy_created);
        worst
    }
}

fn worst(figures: &[Option<f64>]) -> Option<f64> {
    figures.iter().copied().fold(None, larger)
}

/// A sink that compares a run with its reference as it goes by.
pub struct BodiesComparison<'a> {
    reference: &'a Recording,
    cursor: usize,
    places: Vec<Track>,
    excess_j: f64,
    energy_j: f64,
}

impl<'a> BodiesComparison<'a> {
    pub fn new(reference: &'a Recording) -> Self {
        let discs = reference.outcome.last.bodies.len();
        Self { reference, cursor: 0, places: vec![Track::default(); discs], excess_j: 0.0, energy_j: 0.0 }
    }

    /// The differences, once the run is over.
    pub fn finish(self, outcome: &Outcome) -> BodiesDifferences {
        let reference = &self.reference.outcome;
        let pairs = || outcome.contacts.iter().zip(&reference.contacts);
        let relative = |figure: fn(&ContactSummary) -> f64| {
            let largest = reference.contacts.iter().map(figure).fold(0.0, f64::max);
            pairs().map(|(found, expected)| relative(figure(found), figure(expected), largest)).collect()
        };
        let turned = outcome.last.bodies.iter().zip(&reference.last.bodies);
        BodiesDifferences {
            position_max_m: self.places.iter().map(|track| track.max).collect(),
            position_max_at_s: self.places.iter().map(|track| track.max_at_s).collect(),
            position_rms_m: self.places.iter().map(Track::rms).collect(),
            position_end_m: self.places.iter().map(|track| track.end).collect(),
            angle_end_rad: turned.map(|(found, expected)| distance(found.angle_rad, expected.angle_rad)).collect(),
            contact_time_s: pairs().map(|(found, expected)| first_touch(found.first_s, expected.first_s)).collect(),
            impulse: relative(|pair| pair.impulse_n_s),
            peak_force: relative(|pair| pair.peak_normal_n),
            energy_created_j: self.excess_j,
            energy_created: if self.excess_j > 0.0 { self.excess_j / self.energy_j } else { 0.0 },
        }
    }
}

impl Sink for BodiesComparison<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        let energy = &sample.energy;
        self.excess_j = self.excess_j.max(energy.balance_j);
        self.energy_j = self.energy_j.max(energy.kinetic_j + energy.elastic_j).max(energy.motor_work_j.abs());
        let Some(expected) = self.reference.at(sample.time_s, &mut self.cursor) else { return Ok(()) };
        for ((track, found), expected) in self.places.iter_mut().zip(&sample.bodies).zip(&expected.bodies) {
            let [x, y] = [0, 1].map(|k| found.centre_m[k] - expected.centre_m[k]);
            track.push(sample.time_s, x.hypot(y));
        }
        Ok(())
    }

    fn event(&mut self, _: &Event) -> Result<(), SinkError> {
        Ok(())
    }
}

/// Compares a run that was kept with its reference.
pub fn compare(run: &Recording, reference: &Recording) -> BodiesDifferences {
    let mut comparison = BodiesComparison::new(reference);
    for sample in &run.samples {
        comparison.sample(sample).expect("comparing writes nothing");
    }
    comparison.finish(&run.outcome)
}

/// Difference of two first touches.
fn first_touch(time_s: Option<f64>, expected_s: Option<f64>) -> Option<f64> {
    match (time_s, expected_s) {
        (Some(t), Some(expected)) => Some(distance(t, expected)),
        (None, None) => None,
        _ => Some(f64::INFINITY),
    }
}

/// Difference relative to what is expected; `None` where that is next to nothing beside the largest of all.
fn relative(found: f64, expected: f64, largest: f64) -> Option<f64> {
    if expected > 0.0 && expected >= SIGNIFICANT * largest {
        Some(distance(found, expected) / expected)
    } else if found > SIGNIFICANT * largest && found > 0.0 {
        Some(f64::INFINITY)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::BodyState;
    use ContactSummary;

    fn recording(shift_m: f64, pairs: [ContactSummary; 3]) -> Recording {
        let sample = |time_s: f64| Sample {
            time_s,
            bodies: vec![BodyState { centre_m: [shift_m * time_s, 0.0], ..BodyState::default() }],
            ..Sample::default()
        };
        let samples = vec![sample(0.0), sample(1.0)];
        let outcome = Outcome { last: sample(1.0), contacts: pairs.to_vec(), ..Outcome::default() };
        Recording { samples, outcome, ..Recording::default() }
    }

    fn pair(first_s: Option<f64>, impulse_n_s: f64) -> ContactSummary {
        ContactSummary { first_s, impulse_n_s, peak_normal_n: 10.0 * impulse_n_s, ..ContactSummary::default() }
    }

    #[test]
    fn places_touches_and_impulses_are_compared_pair_by_pair() {
        let reference = recording(0.0, [pair(Some(0.5), 2.0), pair(None, 0.0), pair(Some(0.7), 0.001)]);
        let found = recording(3e-6, [pair(Some(0.501), 2.1), pair(None, 0.0), pair(None, 0.0)]);
        let differences = compare(&found, &reference);
        assert!((differences.position_m() - 3e-6).abs() < 1e-18);
        assert_eq!(differences.position_max_at_s, [1.0]);
        assert!((differences.contact_time_s[0].expect("touches") - 1e-3).abs() < 1e-12);
        assert_eq!(differences.contact_time_s[1..], [None, Some(f64::INFINITY)], "one touch is missing");
        assert!((differences.impulse[0].expect("an impulse") - 0.05).abs() < 1e-12);
        assert_eq!(differences.impulse[1..], [None, None], "nothing, and next to nothing");
        assert!((differences.peak_force().expect("a force") - 0.05).abs() < 1e-12);
        let exact = compare(&reference, &reference);
        assert_eq!((exact.position_m(), exact.impulse(), exact.contact_time()), (0.0, Some(0.0), Some(0.0)));
        assert_eq!(exact.worst(&differences), differences);
    }

    #[test]
    fn an_impulse_out_of_nothing_is_infinitely_wrong() {
        let reference = recording(0.0, [pair(None, 0.0); 3]);
        let found = recording(0.0, [pair(Some(0.1), 1.0), pair(None, 0.0), pair(None, 0.0)]);
        assert_eq!(compare(&found, &reference).impulse(), Some(f64::INFINITY));
    }
}
