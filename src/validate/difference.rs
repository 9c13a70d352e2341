//! Differences between a run and its reference.

use super::{Angle, Impact, Impacts, Rate, Recording, RunningDifference};
use crate::check::REFERENCE_LENGTH_M;
use crate::trace::{ContactSummary, Event, Outcome, Sample, Sink, SinkError};

/// Impacts of a finger with less than this fraction of the largest impulse, and pairs of bodies with less than this
/// fraction of the largest impulse or force of all pairs, are not compared.
const SIGNIFICANT: f64 = 0.01;
/// Upper bound of the rounding error of positions in these scenes, m.
const ROUNDING_M: f64 = 1e-15;
/// A reference force below this counts as zero, and the difference is absolute, in N.
const ZERO_FORCE_N: f64 = 1e-6;

/// Error of one coordinate over a run: an angle in rad, the centre of a body in m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CoordinateError {
    /// Largest absolute difference.
    pub max: f64,
    /// Time of the largest difference, s.
    pub max_at_s: f64,
    /// Root mean square.
    pub rms: f64,
    /// Difference at the end of the compared time.
    pub end: f64,
}

/// Differences of a run from its reference, or the worst of several runs. A value is infinite where only one of the two
/// has the quantity, and `None` where neither has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Differences {
    /// Errors of q11, q21, q22 of every finger, then of the centre of every body.
    pub path: Vec<CoordinateError>,
    /// RMS errors of qd11, qd21, qd22 of every finger.
    pub rate_rms_rad_s: Vec<f64>,
    /// Error of the angle of every body at the end.
    pub angle_end_rad: Vec<f64>,
    /// Difference of the first touch-down of every contact between surfaces.
    pub contact_time_s: Vec<Option<f64>>,
    /// Worst relative difference of the normal impulse of an impact; for pairs of bodies, of the impulse over the run.
    pub impulse: Vec<Option<f64>>,
    /// Difference of the normal force at the end of the run, relative to the reference (in N where the reference force
    /// is zero).
    pub final_force: Vec<Option<f64>>,
    /// Relative difference of the largest normal force.
    pub peak_force: Vec<Option<f64>>,
    /// Largest opening of a joint.
    pub loop_gap_m: f64,
    /// Largest excess of the energy balance, J.
    pub energy_created_j: f64,
    /// The same relative to the motor's work, or for scenes of discs to the largest energy of the run.
    pub energy_created: f64,
}

impl Differences {
    /// Largest difference of any coordinate. In scenes with fingers, distances are scaled by [`REFERENCE_LENGTH_M`].
    pub fn path_max(&self) -> f64 {
        let unit = if self.has_fingers() { REFERENCE_LENGTH_M } else { 1.0 };
        self.angle_max().max(self.centre_max() / unit)
    }

    pub(super) fn has_fingers(&self) -> bool {
        !self.rate_rms_rad_s.is_empty()
    }

    pub(super) fn has_bodies(&self) -> bool {
        !self.angle_end_rad.is_empty()
    }

    /// Largest difference of an angle of any finger.
    pub fn angle_max(&self) -> f64 {
        self.path[..self.rate_rms_rad_s.len()].iter().map(|error| error.max).fold(0.0, f64::max)
    }

    /// Largest distance between the centres of any body.
    pub fn centre_max(&self) -> f64 {
        self.path[self.rate_rms_rad_s.len()..].iter().map(|error| error.max).fold(0.0, f64::max)
    }

    /// Returns the maximum of each difference.
    pub fn worst(&self, other: &Self) -> Self {
        let mut worst = self.clone();
        for (worst, other) in worst.path.iter_mut().zip(&other.path) {
            if other.max > worst.max {
                (worst.max, worst.max_at_s) = (other.max, other.max_at_s);
            }
            worst.rms = worst.rms.max(other.rms);
            worst.end = worst.end.max(other.end);
        }
        let figures =
            [(&mut worst.rate_rms_rad_s, &other.rate_rms_rad_s), (&mut worst.angle_end_rad, &other.angle_end_rad)];
        for (worst, other) in figures {
            worst.iter_mut().zip(other).for_each(|(worst, other)| *worst = worst.max(*other));
        }
        let figures = [
            (&mut worst.contact_time_s, &other.contact_time_s),
            (&mut worst.impulse, &other.impulse),
            (&mut worst.final_force, &other.final_force),
            (&mut worst.peak_force, &other.peak_force),
        ];
        for (worst, other) in figures {
            worst.iter_mut().zip(other).for_each(|(worst, other)| *worst = larger(*worst, *other));
        }
        worst.loop_gap_m = self.loop_gap_m.max(other.loop_gap_m);
        worst.energy_created_j = self.energy_created_j.max(other.energy_created_j);
        worst.energy_created = self.energy_created.max(other.energy_created);
        worst
    }
}

/// Returns the largest of the values that are present.
pub fn largest(values: &[Option<f64>]) -> Option<f64> {
    values.iter().copied().fold(None, larger)
}

fn larger(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.max(b)),
        (value, None) | (None, value) => value,
    }
}

/// A [`Sink`] that compares a run with its reference without storing its samples.
pub struct Comparison<'a> {
    reference: &'a Recording,
    until_s: f64,
    cursor: usize,
    path: Vec<RunningDifference>,
    rates: Vec<RunningDifference>,
    impacts: Impacts,
    excess_j: f64,
    motor_work_j: f64,
    energy_j: f64,
}

impl<'a> Comparison<'a> {
    /// Creates a comparison of trajectories up to `until_s`.
    pub fn new(reference: &'a Recording, until_s: f64) -> Self {
        let Sample { fingers, bodies, .. } = &reference.outcome.last;
        let (angles, rates) = (Angle::ALL.len() * fingers.len(), Rate::ALL.len() * fingers.len());
        Self {
            reference,
            until_s,
            cursor: 0,
            path: vec![RunningDifference::default(); angles + bodies.len()],
            rates: vec![RunningDifference::default(); rates],
            impacts: Impacts::default(),
            excess_j: 0.0,
            motor_work_j: 0.0,
            energy_j: 0.0,
        }
    }

    /// Maximum penetration of a contact in either model, m.
    fn max_penetration_m(&self, index: usize, outcome: &Outcome) -> f64 {
        let runs = [outcome, &self.reference.outcome];
        let depths = runs.map(|run| run.contacts.get(index).map_or(f64::NAN, |contact| contact.max_penetration_m));
        depths[0].max(depths[1])
    }

    /// Whether the contact force of a pair of discs is negligible in both models: the pair overlaps by rounding only,
    /// or its largest force is negligible compared with its spring force alone. In the latter case the contact law
    /// clamps the force to zero, and the remaining force during separation is too short to be resolved by steps.
    fn is_force_negligible(&self, index: usize, outcome: &Outcome) -> bool {
        let peak_spring_n = self.reference.peak_spring_n.get(index).copied().unwrap_or(0.0);
        let runs = [outcome, &self.reference.outcome];
        let peaks = runs.map(|run| run.contacts.get(index).map_or(f64::NAN, |contact| contact.peak_normal_n));
        let is_rounding = peak_spring_n > 0.0 && self.max_penetration_m(index, outcome) <= ROUNDING_M;
        is_rounding || peaks.iter().all(|peak| *peak < SIGNIFICANT * peak_spring_n)
    }

    /// Returns the differences after the end of the run.
    pub fn finish(self, outcome: &Outcome) -> Differences {
        let reference = &self.reference.outcome;
        let compared: Vec<usize> =
            (0..reference.contacts.len()).filter(|&index| !reference.last.is_stop(index)).collect();
        let has_fingers = !reference.last.fingers.is_empty();
        let compare_totals = |quantity: fn(&ContactSummary) -> f64| -> Vec<Option<f64>> {
            let largest = reference.contacts.iter().map(quantity).fold(0.0, f64::max);
            let compare_total = |&index: &usize| {
                let found = outcome.contacts.get(index).map_or(f64::NAN, quantity);
                if self.is_force_negligible(index, outcome) {
                    return None;
                }
                relative_difference(found, quantity(&reference.contacts[index]), largest)
            };
            compared.iter().map(compare_total).collect()
        };
        let first_s = |outcome: &Outcome, index: usize| outcome.contacts.get(index).and_then(|contact| contact.first_s);
        // Discs that overlap by rounding only do not count as in contact.
        let contact_time = |&index: &usize| {
            let (found, expected) = (first_s(outcome, index), first_s(reference, index));
            let is_missing_in_one = found.is_some() != expected.is_some();
            let is_between_discs = self.reference.peak_spring_n.get(index).is_some();
            if is_missing_in_one && is_between_discs && self.max_penetration_m(index, outcome) <= ROUNDING_M {
                None
            } else {
                first_contact_difference(found, expected, self.until_s)
            }
        };
        let ends_within = outcome.last.time_s <= self.until_s;
        let final_force = |&index: &usize| match ends_within {
            true => final_force_difference(&outcome.last, &reference.last, index),
            // The end of the run is beyond the compared time.
            false => None,
        };
        let angles = outcome.last.bodies.iter().zip(&reference.last.bodies);
        let error = |running: &RunningDifference| CoordinateError {
            max: running.max,
            max_at_s: running.max_at_s,
            rms: running.rms(),
            end: running.end,
        };
        let energy_j = if has_fingers { self.motor_work_j } else { self.energy_j };
        Differences {
            path: self.path.iter().map(error).collect(),
            rate_rms_rad_s: self.rates.iter().map(RunningDifference::rms).collect(),
            angle_end_rad: angles.map(|(found, expected)| distance(found.angle_rad, expected.angle_rad)).collect(),
            contact_time_s: compared.iter().map(contact_time).collect(),
            impulse: match has_fingers {
                true => {
                    let worst = |&index: &usize| {
                        worst_impulse_difference(&self.impacts, &self.reference.impacts, index, self.until_s)
                    };
                    compared.iter().map(worst).collect()
                }
                false => compare_totals(|contact| contact.impulse_n_s),
            },
            final_force: compared.iter().map(final_force).collect(),
            peak_force: compare_totals(|contact| contact.peak_normal_n),
            loop_gap_m: outcome.loop_gap_m,
            energy_created_j: self.excess_j,
            energy_created: if self.excess_j > 0.0 { self.excess_j / energy_j } else { 0.0 },
        }
    }
}

impl Sink for Comparison<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.impacts.sample(sample)?;
        let energy = &sample.energy;
        self.excess_j = self.excess_j.max(energy.balance_j);
        self.motor_work_j = self.motor_work_j.max(energy.motor_work_j.abs());
        self.energy_j = self.energy_j.max(energy.kinetic_j + energy.elastic_j).max(energy.motor_work_j.abs());
        // The reference ends early if the object of a gripper is ejected.
        if sample.time_s > self.until_s.min(self.reference.outcome.last.time_s) {
            return Ok(());
        }
        let Some(expected) = self.reference.interpolate(sample.time_s, &mut self.cursor) else { return Ok(()) };
        for (running, error) in self.path.iter_mut().zip(coordinate_errors(sample, &expected)) {
            running.push(sample.time_s, error);
        }
        let fingers = sample.fingers.iter().zip(&expected.fingers);
        let rates = fingers.flat_map(|(a, b)| Rate::ALL.map(|rate| rate.value(a) - rate.value(b)));
        for (running, error) in self.rates.iter_mut().zip(rates) {
            running.push(sample.time_s, error);
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.impacts.event(event)
    }
}

/// Returns the errors of the coordinates of a sample: q11, q21, q22 of every finger, then the distances between the
/// centres of all bodies.
pub fn coordinate_errors(sample: &Sample, expected: &Sample) -> impl Iterator<Item = f64> {
    let fingers = sample.fingers.iter().zip(&expected.fingers);
    let angles = fingers.flat_map(|(a, b)| Angle::ALL.map(|angle| angle.difference(a, b)));
    let centres = sample.bodies.iter().zip(&expected.bodies).map(|(a, b)| {
        let [x, y] = [0, 1].map(|k| a.centre_m[k] - b.centre_m[k]);
        x.hypot(y)
    });
    angles.chain(centres)
}

/// Compares a recorded run with its reference, with trajectories up to `until_s`.
pub fn compare(run: &Recording, reference: &Recording, until_s: f64) -> Differences {
    let mut comparison = Comparison::new(reference, until_s);
    // A recording stores samples and events separately, so its impacts are reused instead of being measured again.
    for sample in &run.samples {
        comparison.sample(sample).expect("Comparison::sample does not write output");
    }
    comparison.impacts = run.impacts.clone();
    comparison.finish(&run.outcome)
}

fn final_force_difference(last: &Sample, expected: &Sample, index: usize) -> Option<f64> {
    let (contact, expected) = (last.contacts.get(index)?, expected.contacts.get(index)?);
    // The gap is infinite without an object.
    let has_object = expected.gap_m.is_finite() || contact.gap_m.is_finite();
    let scale = if expected.normal_n > ZERO_FORCE_N { expected.normal_n } else { 1.0 };
    has_object.then(|| distance(contact.normal_n, expected.normal_n) / scale)
}

/// Difference of two times of first contact; `None` if both are after the compared time.
fn first_contact_difference(time_s: Option<f64>, expected_s: Option<f64>, until_s: f64) -> Option<f64> {
    match (time_s, expected_s) {
        (Some(t), Some(expected)) => (t.min(expected) <= until_s).then(|| distance(t, expected)),
        (Some(t), None) | (None, Some(t)) => (t <= until_s).then_some(f64::INFINITY),
        (None, None) => None,
    }
}

/// Worst relative difference of the impulse over the significant impacts of a contact.
fn worst_impulse_difference(impacts: &Impacts, expected: &Impacts, contact: usize, until_s: f64) -> Option<f64> {
    let ends_within = |impact: &&Impact| impact.end_s() <= until_s;
    let largest = expected.all.iter().filter(ends_within).map(Impact::impulse_n_s).fold(0.0, f64::max);
    let mut found = impacts.of_contact(contact);
    let mut worst = None;
    for expected in expected.of_contact(contact).filter(ends_within) {
        let found = found.next();
        let impulse = expected.impulse_n_s();
        if impulse > 0.0 && impulse >= SIGNIFICANT * largest {
            let difference = found.map_or(f64::INFINITY, |found| distance(found.impulse_n_s(), impulse) / impulse);
            worst = larger(worst, Some(difference));
        }
    }
    worst
}

/// Difference relative to the expected value; `None` where the latter is negligible compared with the largest value.
fn relative_difference(found: f64, expected: f64, largest: f64) -> Option<f64> {
    if expected > 0.0 && expected >= SIGNIFICANT * largest {
        Some(distance(found, expected) / expected)
    } else if found > SIGNIFICANT * largest && found > 0.0 {
        Some(f64::INFINITY)
    } else {
        None
    }
}

/// |a − b|; infinite where that is NaN.
fn distance(a: f64, b: f64) -> f64 {
    let difference = (a - b).abs();
    if difference.is_nan() { f64::INFINITY } else { difference }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::BodyState;

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
    fn positions_contact_times_and_impulses_are_compared_per_pair() {
        let reference = recording(0.0, [pair(Some(0.5), 2.0), pair(None, 0.0), pair(Some(0.7), 0.001)]);
        let found = recording(3e-6, [pair(Some(0.501), 2.1), pair(None, 0.0), pair(None, 0.0)]);
        let differences = compare(&found, &reference, 1.0);
        assert!((differences.path_max() - 3e-6).abs() < 1e-18);
        assert_eq!(differences.path[0].max_at_s, 1.0);
        assert!((differences.contact_time_s[0].expect("a contact") - 1e-3).abs() < 1e-12);
        assert_eq!(differences.contact_time_s[1..], [None, Some(f64::INFINITY)], "one contact is missing");
        assert!((differences.impulse[0].expect("an impulse") - 0.05).abs() < 1e-12);
        assert_eq!(differences.impulse[1..], [None, None], "zero and negligible impulses");
        assert!((largest(&differences.peak_force).expect("a force") - 0.05).abs() < 1e-12);
        let exact = compare(&reference, &reference, 1.0);
        let worst = (largest(&exact.impulse), largest(&exact.contact_time_s));
        assert_eq!((exact.path_max(), worst), (0.0, (Some(0.0), Some(0.0))));
        assert_eq!(exact.worst(&differences), differences);
    }

    #[test]
    fn impulse_missing_in_the_reference_is_an_infinite_difference() {
        let reference = recording(0.0, [pair(None, 0.0); 3]);
        let found = recording(0.0, [pair(Some(0.1), 1.0), pair(None, 0.0), pair(None, 0.0)]);
        assert_eq!(largest(&compare(&found, &reference, 1.0).impulse), Some(f64::INFINITY));
    }
}
