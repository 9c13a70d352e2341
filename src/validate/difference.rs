//! Everything in which a run differs from its reference.

use super::{Angle, Impact, Impacts, Rate, Recording, Track};
use crate::scene::Bounds;
use crate::trace::{Event, Outcome, Sample, Sink, SinkError, Site};

/// The phalanges, in the order of every pair of figures here.
const PHALANGES: [Site; 2] = [Site::Proximal, Site::Distal];
/// Impacts with less than this part of the largest impulse are too small to compare.
const SIGNIFICANT: f64 = 0.01;
/// A reference force below this is no force: the difference is then absolute, in N.
const NO_FORCE_N: f64 = 1e-6;

/// Differences of a run from its reference, or the worst of several. Infinite where one of the two has what the other
/// lacks; `None` where neither has it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Differences {
    /// Of q11, q21, q22: largest, its time, root mean square, at the end of what is compared.
    pub angle_max_rad: [f64; 3],
    pub angle_max_at_s: [f64; 3],
    pub angle_rms_rad: [f64; 3],
    pub angle_end_rad: [f64; 3],
    /// Of qd11, qd21, qd22: root mean square.
    pub rate_rms_rad_s: [f64; 3],
    /// Normal force at the end of the run, relative to the reference (in N where that presses with nothing).
    pub final_force: [Option<f64>; 2],
    /// First touch-down of each phalanx.
    pub contact_time_s: [Option<f64>; 2],
    /// Worst relative difference of the normal impulse of an impact of each phalanx.
    pub impulse: [Option<f64>; 2],
    /// Largest opening of a joint.
    pub loop_gap_m: f64,
    /// Largest excess of the energy balance, in J and relative to the motor's work.
    pub energy_created_j: f64,
    pub energy_created: f64,
}

impl Differences {
    /// Largest difference of any of the angles.
    pub fn angle_rad(&self) -> f64 {
        self.angle_max_rad.into_iter().fold(0.0, f64::max)
    }

    /// The worse of each figure.
    pub fn worst(&self, other: &Self) -> Self {
        let mut worst = *self;
        for k in 0..3 {
            if other.angle_max_rad[k] > self.angle_max_rad[k] {
                (worst.angle_max_rad[k], worst.angle_max_at_s[k]) = (other.angle_max_rad[k], other.angle_max_at_s[k]);
            }
            worst.angle_rms_rad[k] = self.angle_rms_rad[k].max(other.angle_rms_rad[k]);
            worst.angle_end_rad[k] = self.angle_end_rad[k].max(other.angle_end_rad[k]);
            worst.rate_rms_rad_s[k] = self.rate_rms_rad_s[k].max(other.rate_rms_rad_s[k]);
        }
        for k in 0..2 {
            worst.final_force[k] = larger(self.final_force[k], other.final_force[k]);
            worst.contact_time_s[k] = larger(self.contact_time_s[k], other.contact_time_s[k]);
            worst.impulse[k] = larger(self.impulse[k], other.impulse[k]);
        }
        worst.loop_gap_m = self.loop_gap_m.max(other.loop_gap_m);
        worst.energy_created_j = self.energy_created_j.max(other.energy_created_j);
        worst.energy_created = self.energy_created.max(other.energy_created);
        worst
    }
}

/// The larger of two figures, as far as there are any.
pub(super) fn larger(a: Option<f64>, b: Option<f64>) -> Option<f64> {
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
    angles: [Track; 3],
    rates: [Track; 3],
    impacts: Impacts,
    excess_j: f64,
    motor_work_j: f64,
}

impl<'a> Comparison<'a> {
    /// Trajectories are compared up to `bounds.until_s`.
    pub fn new(reference: &'a Recording, bounds: &Bounds) -> Self {
        Self {
            reference,
            until_s: bounds.until_s,
            cursor: 0,
            angles: [Track::default(); 3],
            rates: [Track::default(); 3],
            impacts: Impacts::default(),
            excess_j: 0.0,
            motor_work_j: 0.0,
        }
    }

    /// The differences, once the run is over.
    pub fn finish(self, outcome: &Outcome) -> Differences {
        let reference = &self.reference.outcome;
        Differences {
            angle_max_rad: self.angles.map(|track| track.max),
            angle_max_at_s: self.angles.map(|track| track.max_at_s),
            angle_rms_rad: self.angles.map(|track| track.rms()),
            angle_end_rad: self.angles.map(|track| track.end),
            rate_rms_rad_s: self.rates.map(|track| track.rms()),
            final_force: match outcome.last.time_s <= self.until_s {
                true => final_forces(&outcome.last, &reference.last),
                // The end lies beyond what is compared.
                false => [None; 2],
            },
            contact_time_s: PHALANGES
                .map(|site| first_touch(outcome.site(site).first_s, reference.site(site).first_s, self.until_s)),
            impulse: PHALANGES.map(|site| impulses(&self.impacts, &self.reference.impacts, site, self.until_s)),
            loop_gap_m: outcome.loop_gap_m,
            energy_created_j: self.excess_j,
            energy_created: if self.excess_j > 0.0 { self.excess_j / self.motor_work_j } else { 0.0 },
        }
    }
}

impl Sink for Comparison<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.impacts.sample(sample)?;
        self.excess_j = self.excess_j.max(sample.energy.balance_j);
        self.motor_work_j = self.motor_work_j.max(sample.energy.motor_work_j.abs());
        if sample.time_s > self.until_s {
            return Ok(());
        }
        let Some(expected) = self.reference.at(sample.time_s, &mut self.cursor) else { return Ok(()) };
        for (track, angle) in self.angles.iter_mut().zip(Angle::ALL) {
            track.push(sample.time_s, angle.difference(sample, &expected));
        }
        for (track, rate) in self.rates.iter_mut().zip(Rate::ALL) {
            track.push(sample.time_s, rate.of(sample) - rate.of(&expected));
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        self.impacts.event(event)
    }
}

/// Compares a run that was kept with its reference.
pub fn compare(run: &Recording, reference: &Recording, bounds: &Bounds) -> Differences {
    let mut comparison = Comparison::new(reference, bounds);
    // Events and samples of a kept run are apart: impacts are already measured, and only samples are gone through
    // again.
    for sample in &run.samples {
        comparison.sample(sample).expect("comparing writes nothing");
    }
    comparison.impacts = run.impacts.clone();
    comparison.finish(&run.outcome)
}

fn final_forces(last: &Sample, expected: &Sample) -> [Option<f64>; 2] {
    PHALANGES.map(|site| {
        let (contact, expected) = (last.contact(site), expected.contact(site));
        // Without an object there is nothing to press on.
        let there = expected.gap_m.is_finite() || contact.gap_m.is_finite();
        let scale = if expected.normal_n > NO_FORCE_N { expected.normal_n } else { 1.0 };
        there.then(|| distance(contact.normal_n, expected.normal_n) / scale)
    })
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
fn impulses(impacts: &Impacts, expected: &Impacts, site: Site, until_s: f64) -> Option<f64> {
    let whole = |impact: &&Impact| impact.end_s() <= until_s;
    let largest = expected.all.iter().filter(whole).map(Impact::impulse_n_s).fold(0.0, f64::max);
    let mut found = impacts.of(site as usize);
    let mut worst = None;
    for expected in expected.of(site as usize).filter(whole) {
        let found = found.next();
        let impulse = expected.impulse_n_s();
        if impulse > 0.0 && impulse >= SIGNIFICANT * largest {
            let difference = found.map_or(f64::INFINITY, |found| distance(found.impulse_n_s(), impulse) / impulse);
            worst = larger(worst, Some(difference));
        }
    }
    worst
}

/// |a − b|; infinite where that is no number.
pub(super) fn distance(a: f64, b: f64) -> f64 {
    let difference = (a - b).abs();
    if difference.is_nan() { f64::INFINITY } else { difference }
}
