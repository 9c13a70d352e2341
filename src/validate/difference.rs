//! Differences between a run and its reference.

use super::{Impact, Impacts, Recording};
use crate::check::REFERENCE_LENGTH_M;
use crate::trace::{ContactSummary, Event, FingerState, Outcome, RequiredData, Sample, Sink, SinkError};

/// Impacts of a finger with less than this fraction of the largest impulse, and pairs of bodies with less than this
/// fraction of the largest impulse or force of all pairs, are not compared.
const SIGNIFICANT: f64 = 0.01;
/// Upper bound of the rounding error of positions in these scenes, m.
const ROUNDING_M: f64 = 1e-15;
/// A reference force below this counts as zero, and the difference is absolute, in N.
const ZERO_FORCE_N: f64 = 1e-6;

/// A compared joint of a finger.
#[derive(Clone, Copy, Debug)]
pub struct Angle {
    name: &'static str,
    angle_rad: fn(&FingerState) -> f64,
    rate_rad_s: fn(&FingerState) -> f64,
}

impl Angle {
    /// All compared joints, in the order of [`Differences::path`].
    pub const ALL: [Angle; 3] = [
        Angle { name: "q11", angle_rad: |finger| finger.q11_rad, rate_rad_s: |finger| finger.qd11_rad_s },
        Angle { name: "q21", angle_rad: |finger| finger.q21_rad, rate_rad_s: |finger| finger.qd21_rad_s },
        Angle { name: "q22", angle_rad: |finger| finger.q22_rad, rate_rad_s: |finger| finger.qd22_rad_s },
    ];

    pub fn name(&self) -> &'static str {
        self.name
    }
}

/// The difference of one quantity over a run. NaN counts as infinite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct RunningDifference {
    max: f64,
    max_at_s: f64,
    end: f64,
    /// ∫ difference² dt by the trapezoidal rule, from `start_s` to `time_s`.
    square_s: f64,
    start_s: Option<f64>,
    time_s: f64,
}

impl RunningDifference {
    /// Adds the difference at a time. Times must not decrease.
    fn push(&mut self, time_s: f64, difference: f64) {
        let difference = distance(difference, 0.0);
        match self.start_s {
            Some(_) => {
                self.square_s += 0.5 * (time_s - self.time_s) * (self.end * self.end + difference * difference);
            }
            None => self.start_s = Some(time_s),
        }
        if difference > self.max {
            (self.max, self.max_at_s) = (difference, time_s);
        }
        (self.end, self.time_s) = (difference, time_s);
    }

    /// Root mean square over the time so far, weighted by time.
    fn rms(&self) -> f64 {
        let length = self.time_s - self.start_s.unwrap_or_default();
        match (self.square_s / length).sqrt() {
            _ if length <= 0.0 => self.end,
            rms if rms.is_nan() => f64::INFINITY,
            rms => rms,
        }
    }

    fn error(&self) -> CoordinateError {
        CoordinateError { max: self.max, max_at_s: self.max_at_s, rms: self.rms(), end: self.end }
    }
}

/// Error of one coordinate over a run: that of an angle is in rad, that of the centre of a body in m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CoordinateError {
    /// Largest absolute difference.
    pub max: f64,
    /// Time of the largest difference, s.
    pub max_at_s: f64,
    /// Root mean square of the difference.
    pub rms: f64,
    /// Difference at the end of the compared interval.
    pub end: f64,
}

impl CoordinateError {
    fn worst(&self, other: &Self) -> Self {
        let max_at_s = if other.max > self.max { other.max_at_s } else { self.max_at_s };
        let (rms, end) = (self.rms.max(other.rms), self.end.max(other.end));
        CoordinateError { max: self.max.max(other.max), max_at_s, rms, end }
    }
}

/// Differences of a run from its reference, or the worst differences of several runs. A value is infinite if only one
/// of the two runs has the quantity, and `None` if neither has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Differences {
    /// Errors of q11, q21, q22 of every finger, then of the centre of every body.
    pub path: Vec<CoordinateError>,
    /// RMS errors of qd11, qd21, qd22 of every finger.
    pub rate_rms_rad_s: Vec<f64>,
    /// Error of the angle of every body.
    pub turn: Vec<CoordinateError>,
    /// Difference of the time of the first touch-down, for every contact between surfaces, s.
    pub contact_time_s: Vec<Option<f64>>,
    /// Worst relative difference of the normal impulse of an impact. For pairs of bodies, that of the impulse over the
    /// whole run.
    pub impulse: Vec<Option<f64>>,
    /// Difference of the normal force at the end of the run, relative to the reference; in N if the reference force is
    /// zero.
    pub final_force: Vec<Option<f64>>,
    /// Relative difference of the largest normal force.
    pub peak_force: Vec<Option<f64>>,
    /// Largest opening of a joint, m.
    pub loop_gap_m: f64,
    /// Largest excess of the energy balance, J.
    pub energy_created_j: f64,
    /// The same excess, relative to the work of the motor; in scenes without joints, to the largest energy of the run.
    pub energy_created: f64,
}

impl Differences {
    /// Largest difference of any coordinate. In scenes with fingers, distances are divided by [`REFERENCE_LENGTH_M`].
    pub fn path_max(&self) -> f64 {
        let unit = if self.has_fingers() { REFERENCE_LENGTH_M } else { 1.0 };
        self.angle_max().max(self.centre_max() / unit)
    }

    pub(super) fn has_fingers(&self) -> bool {
        !self.rate_rms_rad_s.is_empty()
    }

    /// Largest difference of an angle of any finger; in a mechanism, of any body.
    pub(crate) fn angle_max(&self) -> f64 {
        let angles = if self.has_fingers() { &self.path[..self.rate_rms_rad_s.len()] } else { &self.turn };
        angles.iter().map(|error| error.max).fold(0.0, f64::max)
    }

    /// Largest distance between the centres of any body.
    pub(crate) fn centre_max(&self) -> f64 {
        self.path[self.rate_rms_rad_s.len()..].iter().map(|error| error.max).fold(0.0, f64::max)
    }

    /// Returns the larger of the two values for each difference.
    pub fn worst(&self, other: &Self) -> Self {
        let each = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a.max(*b)).collect();
        let each_known =
            |a: &[Option<f64>], b: &[Option<f64>]| a.iter().zip(b).map(|(a, b)| largest(&[*a, *b])).collect();
        Differences {
            path: self.path.iter().zip(&other.path).map(|(a, b)| a.worst(b)).collect(),
            rate_rms_rad_s: each(&self.rate_rms_rad_s, &other.rate_rms_rad_s),
            turn: self.turn.iter().zip(&other.turn).map(|(a, b)| a.worst(b)).collect(),
            contact_time_s: each_known(&self.contact_time_s, &other.contact_time_s),
            impulse: each_known(&self.impulse, &other.impulse),
            final_force: each_known(&self.final_force, &other.final_force),
            peak_force: each_known(&self.peak_force, &other.peak_force),
            loop_gap_m: self.loop_gap_m.max(other.loop_gap_m),
            energy_created_j: self.energy_created_j.max(other.energy_created_j),
            energy_created: self.energy_created.max(other.energy_created),
        }
    }
}

/// Returns the largest of the values that are not `None`.
pub fn largest(values: &[Option<f64>]) -> Option<f64> {
    values.iter().copied().flatten().reduce(f64::max)
}

/// A [`Sink`] that compares a run with its reference without storing its samples.
pub struct Comparison<'a> {
    reference: &'a Recording,
    until_s: f64,
    cursor: usize,
    path: Vec<RunningDifference>,
    rates: Vec<RunningDifference>,
    turns: Vec<RunningDifference>,
    impacts: Impacts,
    excess_j: f64,
    motor_work_j: f64,
    energy_j: f64,
}

impl<'a> Comparison<'a> {
    /// Creates a comparison of trajectories up to the time `until_s`.
    pub fn new(reference: &'a Recording, until_s: f64) -> Self {
        let counts = reference.outcome.last.counts();
        let angles = Angle::ALL.len() * counts.fingers;
        Self {
            reference,
            until_s,
            cursor: 0,
            path: vec![RunningDifference::default(); angles + counts.bodies],
            rates: vec![RunningDifference::default(); angles],
            turns: vec![RunningDifference::default(); counts.bodies],
            impacts: Impacts::default(),
            excess_j: 0.0,
            motor_work_j: 0.0,
            energy_j: 0.0,
        }
    }

    /// Returns a figure of a contact in the run and in the reference.
    fn both(&self, index: usize, outcome: &Outcome, figure: fn(&ContactSummary) -> f64) -> [f64; 2] {
        [outcome, &self.reference.outcome].map(|run| run.contacts.get(index).map_or(f64::NAN, figure))
    }

    /// Whether a contact of discs overlaps by rounding only in both models.
    fn is_rounding(&self, index: usize, outcome: &Outcome) -> bool {
        let [depth_m, expected_m] = self.both(index, outcome, |contact| contact.max_penetration_m);
        depth_m.max(expected_m) <= ROUNDING_M
    }

    /// Relative difference of a figure of a contact over the run; `None` where the figure is negligible compared with
    /// the largest of all contacts, or the contact force of a pair of discs is negligible in both models.
    ///
    /// The force of a pair is negligible if the discs overlap by rounding only, or if the largest force is negligible
    /// compared with the spring force alone. In the latter case the contact law clamps the force to zero, and the
    /// remaining force during separation is too short to be resolved by steps.
    fn total(&self, index: usize, outcome: &Outcome, figure: fn(&ContactSummary) -> f64) -> Option<f64> {
        let peak_spring_n = self.reference.peak_spring_n.get(index).copied().unwrap_or(0.0);
        let peaks = self.both(index, outcome, |contact| contact.peak_normal_n);
        if (peak_spring_n > 0.0 && self.is_rounding(index, outcome))
            || peaks.iter().all(|peak| *peak < SIGNIFICANT * peak_spring_n)
        {
            return None;
        }
        let negligible = SIGNIFICANT * self.reference.outcome.contacts.iter().map(figure).fold(0.0, f64::max);
        match self.both(index, outcome, figure) {
            [found, expected] if expected > 0.0 && expected >= negligible => Some(distance(found, expected) / expected),
            [found, _] => (found > negligible && found > 0.0).then_some(f64::INFINITY),
        }
    }

    /// Difference of the times of first contact; `None` if both are after the compared time.
    fn first_contact(&self, index: usize, outcome: &Outcome) -> Option<f64> {
        let first_s = |outcome: &Outcome| outcome.contacts.get(index).and_then(|contact| contact.first_s);
        match (first_s(outcome), first_s(&self.reference.outcome)) {
            (Some(t), Some(expected)) => (t.min(expected) <= self.until_s).then(|| distance(t, expected)),
            // Discs that overlap by rounding only do not count as in contact.
            _ if self.reference.peak_spring_n.get(index).is_some() && self.is_rounding(index, outcome) => None,
            (Some(t), None) | (None, Some(t)) => (t <= self.until_s).then_some(f64::INFINITY),
            (None, None) => None,
        }
    }

    /// Worst relative difference of the impulse over the significant impacts of a contact.
    fn worst_impulse(&self, contact: usize) -> Option<f64> {
        let expected = &self.reference.impacts;
        let ends_within = |impact: &&Impact| impact.end_s() <= self.until_s;
        let largest = expected.all.iter().filter(ends_within).map(Impact::impulse_n_s).fold(0.0, f64::max);
        let found = self.impacts.of_contact(contact).map(Some).chain(std::iter::repeat(None));
        let pairs = expected.of_contact(contact).filter(ends_within).zip(found);
        let differences = pairs.filter_map(|(expected, found)| {
            let impulse = expected.impulse_n_s();
            let is_significant = impulse > 0.0 && impulse >= SIGNIFICANT * largest;
            is_significant
                .then(|| found.map_or(f64::INFINITY, |found| distance(found.impulse_n_s(), impulse) / impulse))
        });
        differences.reduce(f64::max)
    }

    /// Relative difference of a normal force at the end of the run; `None` if that is beyond the compared time.
    fn final_force(&self, index: usize, last: &Sample) -> Option<f64> {
        let (contact, expected) = (last.contacts().nth(index)?, self.reference.outcome.last.contacts().nth(index)?);
        let scale = if expected.normal_n > ZERO_FORCE_N { expected.normal_n } else { 1.0 };
        (last.time_s <= self.until_s).then(|| distance(contact.normal_n, expected.normal_n) / scale)
    }

    /// Returns the differences, after the end of the run.
    pub fn finish(self, outcome: &Outcome) -> Differences {
        let reference = &self.reference.outcome;
        let has_fingers = reference.last.counts().fingers > 0;
        let surfaces = || (0..reference.contacts.len()).filter(|&index| !reference.last.is_stop(index));
        let impulse = |index: usize| match has_fingers {
            true => self.worst_impulse(index),
            false => self.total(index, outcome, |contact| contact.impulse_n_s),
        };
        let energy_j = if has_fingers { self.motor_work_j } else { self.energy_j };
        Differences {
            path: self.path.iter().map(RunningDifference::error).collect(),
            rate_rms_rad_s: self.rates.iter().map(RunningDifference::rms).collect(),
            turn: self.turns.iter().map(RunningDifference::error).collect(),
            contact_time_s: surfaces().map(|index| self.first_contact(index, outcome)).collect(),
            impulse: surfaces().map(impulse).collect(),
            final_force: surfaces().map(|index| self.final_force(index, &outcome.last)).collect(),
            peak_force: surfaces().map(|index| self.total(index, outcome, |contact| contact.peak_normal_n)).collect(),
            loop_gap_m: outcome.loop_gap_m,
            energy_created_j: self.excess_j,
            energy_created: if self.excess_j > 0.0 { self.excess_j / energy_j } else { 0.0 },
        }
    }
}

impl Sink for Comparison<'_> {
    fn required_data(&self) -> RequiredData {
        RequiredData::EVALUATION
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.impacts.sample(sample)?;
        let energy = &sample.energy();
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
        let fingers = sample.fingers().zip(expected.fingers());
        let rates = fingers.flat_map(|(a, b)| Angle::ALL.map(|joint| (joint.rate_rad_s)(&a) - (joint.rate_rad_s)(&b)));
        let turns = sample.bodies().zip(expected.bodies()).map(|(a, b)| a.angle_rad - b.angle_rad);
        let errors = rates.chain(turns);
        for (running, error) in self.rates.iter_mut().chain(&mut self.turns).zip(errors) {
            running.push(sample.time_s, error);
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.impacts.event(event)
    }
}

/// Returns the errors of the coordinates of a sample: q11, q21, q22 of every finger, then the distances between
/// the centres of all bodies.
pub(crate) fn coordinate_errors(sample: &Sample, expected: &Sample) -> impl Iterator<Item = f64> {
    let fingers = sample.fingers().zip(expected.fingers());
    let angles = fingers.flat_map(|(a, b)| Angle::ALL.map(|joint| (joint.angle_rad)(&a) - (joint.angle_rad)(&b)));
    let centres = sample.bodies().zip(expected.bodies()).map(|(a, b)| {
        let [x, y] = [0, 1].map(|k| a.centre_m[k] - b.centre_m[k]);
        x.hypot(y)
    });
    angles.chain(centres)
}

/// Compares a recorded run with its reference; trajectories are compared up to `until_s`.
pub fn compare(run: &Recording, reference: &Recording, until_s: f64) -> Differences {
    let mut comparison = Comparison::new(reference, until_s);
    // A recording stores samples and events separately, so its impacts are reused instead of being measured again.
    for sample in &run.samples {
        comparison.sample(sample).expect("Comparison::sample does not write output");
    }
    comparison.impacts = run.impacts.clone();
    comparison.finish(&run.outcome)
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
        let sample = |time_s: f64| {
            let body = BodyState { centre_m: [shift_m * time_s, 0.0], ..BodyState::default() };
            Sample::of(time_s, &[], &[body], &[])
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

    #[test]
    fn rms_is_weighted_by_time() {
        let mut running = RunningDifference::default();
        // 3 for one second in a hundred samples, then 0 for three seconds in one sample.
        for k in 0..=100 {
            running.push(0.01 * f64::from(k), -3.0);
        }
        running.push(1.0, 0.0);
        running.push(4.0, 0.0);
        assert!((running.rms() - 1.5).abs() < 1e-12, "{}", running.rms());
        assert_eq!((running.max, running.max_at_s, running.end), (3.0, 0.0, 0.0));
    }

    #[test]
    fn nan_is_an_infinite_difference() {
        let mut running = RunningDifference::default();
        running.push(0.0, 0.0);
        running.push(1.0, f64::NAN);
        running.push(2.0, 0.0);
        assert_eq!((running.max, running.max_at_s, running.rms()), (f64::INFINITY, 1.0, f64::INFINITY));
    }
}
