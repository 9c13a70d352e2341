//! Everything in which a run differs from its reference.

use super::{Angle, Impact, Impacts, Rate, Recording, Track};
use crate::check::LENGTH_M;
use crate::trace::{ContactSummary, Event, Outcome, Sample, Sink, SinkError};

/// Impacts of a finger with less than this part of the largest impulse, and pairs of bodies with less than this part of the
/// largest figure of all, are too small to compare in it.
const SIGNIFICANT: f64 = 0.01;
/// Places of the size of these scenes are rounded to less than this, m.
const ROUNDING_M: f64 = 1e-15;
/// A reference force below this is no force: the difference is then absolute, in N.
const NO_FORCE_N: f64 = 1e-6;

/// How far one coordinate is off along the way: an angle in rad, the centre of a body in m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Off {
    /// Largest difference, and when it was.
    pub max: f64,
    pub max_at_s: f64,
    /// Root mean square.
    pub rms: f64,
    /// At the end of what is compared.
    pub end: f64,
}

/// Differences of a run from its reference, or the worst of several. Infinite where one of the two has what the other
/// lacks; `None` where neither has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Differences {
    /// Of q11, q21, q22 of every finger, then of the centre of every body.
    pub path: Vec<Off>,
    /// Of qd11, qd21, qd22 of every finger: root mean square.
    pub rate_rms_rad_s: Vec<f64>,
    /// Of the angle of every body, at the end.
    pub angle_end_rad: Vec<f64>,
    /// Of every contact between surfaces: first touch-down.
    pub contact_time_s: Vec<Option<f64>>,
    /// Worst relative difference of the normal impulse of an impact; of pairs of bodies, of that over the run.
    pub impulse: Vec<Option<f64>>,
    /// Normal force at the end of the run, relative to the reference (in N where that presses with nothing).
    pub final_force: Vec<Option<f64>>,
    /// Largest normal force, relative.
    pub peak_force: Vec<Option<f64>>,
    /// Largest opening of a joint.
    pub loop_gap_m: f64,
    /// Largest excess of the energy balance, in J and relative to the motor's work; of bodies, to the energy there is.
    pub energy_created_j: f64,
    pub energy_created: f64,
}

impl Differences {
    /// Largest difference of any coordinate; centres beside angles count in [lengths](LENGTH_M).
    pub fn path_max(&self) -> f64 {
        let unit = if self.has_fingers() { LENGTH_M } else { 1.0 };
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
        self.path[..self.rate_rms_rad_s.len()].iter().map(|off| off.max).fold(0.0, f64::max)
    }

    /// Largest distance of the centres of any body.
    pub fn centre_max(&self) -> f64 {
        self.path[self.rate_rms_rad_s.len()..].iter().map(|off| off.max).fold(0.0, f64::max)
    }

    /// The worse of each figure.
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

/// The largest of several figures, as far as there are any.
pub fn largest(figures: &[Option<f64>]) -> Option<f64> {
    figures.iter().copied().fold(None, larger)
}

fn larger(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.max(b)),
        (some, None) | (None, some) => some,
    }
}

/// A [`Sink`] that compares a run with its reference as it goes by, and keeps next to nothing of it.
pub struct Comparison<'a> {
    reference: &'a Recording,
    until_s: f64,
    cursor: usize,
    path: Vec<Track>,
    rates: Vec<Track>,
    impacts: Impacts,
    excess_j: f64,
    motor_work_j: f64,
    energy_j: f64,
}

impl<'a> Comparison<'a> {
    /// Trajectories are compared up to `until_s`.
    pub fn new(reference: &'a Recording, until_s: f64) -> Self {
        let Sample { fingers, bodies, .. } = &reference.outcome.last;
        let (angles, rates) = (Angle::ALL.len() * fingers.len(), Rate::ALL.len() * fingers.len());
        Self {
            reference,
            until_s,
            cursor: 0,
            path: vec![Track::default(); angles + bodies.len()],
            rates: vec![Track::default(); rates],
            impacts: Impacts::default(),
            excess_j: 0.0,
            motor_work_j: 0.0,
            energy_j: 0.0,
        }
    }

    /// Largest depth of a contact in either model.
    fn deepest_m(&self, index: usize, outcome: &Outcome) -> f64 {
        let runs = [outcome, &self.reference.outcome];
        let depths = runs.map(|run| run.contacts.get(index).map_or(f64::NAN, |contact| contact.max_penetration_m));
        depths[0].max(depths[1])
    }

    /// Whether a pair of discs carried no force to speak of in either model: it overlapped by rounding, or its largest force is next to
    /// nothing beside that of its spring alone. The law held the force at zero then, and what is left of it as the surfaces part is too
    /// short for steps.
    fn carries_nothing(&self, index: usize, outcome: &Outcome) -> bool {
        let spring_n = self.reference.spring_n.get(index).copied().unwrap_or(0.0);
        let runs = [outcome, &self.reference.outcome];
        let peaks = runs.map(|run| run.contacts.get(index).map_or(f64::NAN, |contact| contact.peak_normal_n));
        let by_rounding = spring_n > 0.0 && self.deepest_m(index, outcome) <= ROUNDING_M;
        by_rounding || peaks.iter().all(|peak| *peak < SIGNIFICANT * spring_n)
    }

    /// The differences, once the run is over.
    pub fn finish(self, outcome: &Outcome) -> Differences {
        let reference = &self.reference.outcome;
        let compared: Vec<usize> =
            (0..reference.contacts.len()).filter(|&index| !reference.last.is_stop(index)).collect();
        let of_fingers = !reference.last.fingers.is_empty();
        let over_the_run = |figure: fn(&ContactSummary) -> f64| -> Vec<Option<f64>> {
            let largest = reference.contacts.iter().map(figure).fold(0.0, f64::max);
            let of = |&index: &usize| {
                let found = outcome.contacts.get(index).map_or(f64::NAN, figure);
                if self.carries_nothing(index, outcome) {
                    return None;
                }
                relative(found, figure(&reference.contacts[index]), largest)
            };
            compared.iter().map(of).collect()
        };
        let first_s = |outcome: &Outcome, index: usize| outcome.contacts.get(index).and_then(|contact| contact.first_s);
        // Discs that overlap by rounding in both runs are in contact in neither.
        let touch = |&index: &usize| {
            let (found, expected) = (first_s(outcome, index), first_s(reference, index));
            let one_lacks = found.is_some() != expected.is_some();
            let of_discs = self.reference.spring_n.get(index).is_some();
            if one_lacks && of_discs && self.deepest_m(index, outcome) <= ROUNDING_M {
                None
            } else {
                first_touch(found, expected, self.until_s)
            }
        };
        let ends_within = outcome.last.time_s <= self.until_s;
        let final_force = |&index: &usize| match ends_within {
            true => final_force(&outcome.last, &reference.last, index),
            // The end lies beyond what is compared.
            false => None,
        };
        let turned = outcome.last.bodies.iter().zip(&reference.last.bodies);
        let off = |track: &Track| Off { max: track.max, max_at_s: track.max_at_s, rms: track.rms(), end: track.end };
        let energy_j = if of_fingers { self.motor_work_j } else { self.energy_j };
        Differences {
            path: self.path.iter().map(off).collect(),
            rate_rms_rad_s: self.rates.iter().map(Track::rms).collect(),
            angle_end_rad: turned.map(|(found, expected)| distance(found.angle_rad, expected.angle_rad)).collect(),
            contact_time_s: compared.iter().map(touch).collect(),
            impulse: match of_fingers {
                true => {
                    let of = |&index: &usize| impulses(&self.impacts, &self.reference.impacts, index, self.until_s);
                    compared.iter().map(of).collect()
                }
                false => over_the_run(|contact| contact.impulse_n_s),
            },
            final_force: compared.iter().map(final_force).collect(),
            peak_force: over_the_run(|contact| contact.peak_normal_n),
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
        // A reference may end early, where the object of a gripper is thrown out.
        if sample.time_s > self.until_s.min(self.reference.outcome.last.time_s) {
            return Ok(());
        }
        let Some(expected) = self.reference.at(sample.time_s, &mut self.cursor) else { return Ok(()) };
        for (track, off) in self.path.iter_mut().zip(off(sample, &expected)) {
            track.push(sample.time_s, off);
        }
        let fingers = sample.fingers.iter().zip(&expected.fingers);
        let rates = fingers.flat_map(|(a, b)| Rate::ALL.map(|rate| rate.of(a) - rate.of(b)));
        for (track, off) in self.rates.iter_mut().zip(rates) {
            track.push(sample.time_s, off);
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.impacts.event(event)
    }
}

/// How far the coordinates of a sample are off: q11, q21, q22 of every finger, and the distances of the centres of all bodies.
pub fn off(sample: &Sample, expected: &Sample) -> impl Iterator<Item = f64> {
    let fingers = sample.fingers.iter().zip(&expected.fingers);
    let angles = fingers.flat_map(|(a, b)| Angle::ALL.map(|angle| angle.difference(a, b)));
    let centres = sample.bodies.iter().zip(&expected.bodies).map(|(a, b)| {
        let [x, y] = [0, 1].map(|k| a.centre_m[k] - b.centre_m[k]);
        x.hypot(y)
    });
    angles.chain(centres)
}

/// Compares a run that was kept with its reference, trajectories up to `until_s`.
pub fn compare(run: &Recording, reference: &Recording, until_s: f64) -> Differences {
    let mut comparison = Comparison::new(reference, until_s);
    // Events and samples of a kept run are apart: impacts are already measured, and only samples are gone through
    // again.
    for sample in &run.samples {
        comparison.sample(sample).expect("comparing writes nothing");
    }
    comparison.impacts = run.impacts.clone();
    comparison.finish(&run.outcome)
}

fn final_force(last: &Sample, expected: &Sample, index: usize) -> Option<f64> {
    let (contact, expected) = (last.contacts.get(index)?, expected.contacts.get(index)?);
    // Without an object there is nothing to press on.
    let there = expected.gap_m.is_finite() || contact.gap_m.is_finite();
    let scale = if expected.normal_n > NO_FORCE_N { expected.normal_n } else { 1.0 };
    there.then(|| distance(contact.normal_n, expected.normal_n) / scale)
}

/// Difference of two first touches, unless both come after what is compared.
fn first_touch(time_s: Option<f64>, expected_s: Option<f64>, until_s: f64) -> Option<f64> {
    match (time_s, expected_s) {
        (Some(t), Some(expected)) => (t.min(expected) <= until_s).then(|| distance(t, expected)),
        (Some(t), None) | (None, Some(t)) => (t <= until_s).then_some(f64::INFINITY),
        (None, None) => None,
    }
}

/// Worst relative difference of the impulse of the impacts that matter.
fn impulses(impacts: &Impacts, expected: &Impacts, contact: usize, until_s: f64) -> Option<f64> {
    let whole = |impact: &&Impact| impact.end_s() <= until_s;
    let largest = expected.all.iter().filter(whole).map(Impact::impulse_n_s).fold(0.0, f64::max);
    let mut found = impacts.of(contact);
    let mut worst = None;
    for expected in expected.of(contact).filter(whole) {
        let found = found.next();
        let impulse = expected.impulse_n_s();
        if impulse > 0.0 && impulse >= SIGNIFICANT * largest {
            let difference = found.map_or(f64::INFINITY, |found| distance(found.impulse_n_s(), impulse) / impulse);
            worst = larger(worst, Some(difference));
        }
    }
    worst
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

/// |a − b|; infinite where that is no number.
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
    fn places_touches_and_impulses_are_compared_pair_by_pair() {
        let reference = recording(0.0, [pair(Some(0.5), 2.0), pair(None, 0.0), pair(Some(0.7), 0.001)]);
        let found = recording(3e-6, [pair(Some(0.501), 2.1), pair(None, 0.0), pair(None, 0.0)]);
        let differences = compare(&found, &reference, 1.0);
        assert!((differences.path_max() - 3e-6).abs() < 1e-18);
        assert_eq!(differences.path[0].max_at_s, 1.0);
        assert!((differences.contact_time_s[0].expect("touches") - 1e-3).abs() < 1e-12);
        assert_eq!(differences.contact_time_s[1..], [None, Some(f64::INFINITY)], "one touch is missing");
        assert!((differences.impulse[0].expect("an impulse") - 0.05).abs() < 1e-12);
        assert_eq!(differences.impulse[1..], [None, None], "nothing, and next to nothing");
        assert!((largest(&differences.peak_force).expect("a force") - 0.05).abs() < 1e-12);
        let exact = compare(&reference, &reference, 1.0);
        let worst = (largest(&exact.impulse), largest(&exact.contact_time_s));
        assert_eq!((exact.path_max(), worst), (0.0, (Some(0.0), Some(0.0))));
        assert_eq!(exact.worst(&differences), differences);
    }

    #[test]
    fn an_impulse_out_of_nothing_is_infinitely_wrong() {
        let reference = recording(0.0, [pair(None, 0.0); 3]);
        let found = recording(0.0, [pair(Some(0.1), 1.0), pair(None, 0.0), pair(None, 0.0)]);
        assert_eq!(largest(&compare(&found, &reference, 1.0).impulse), Some(f64::INFINITY));
    }
}
