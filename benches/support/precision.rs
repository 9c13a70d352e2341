//! Errors of a contestant over the ensemble.

use phalanx::scene::Method;
use serde::Serialize;

use super::Contestant;
use super::ours::Ours;
use super::problem::Problem;
use super::track::{Cost, Ended, Track, angle_distance, impulse_distance, largest, touch_distance};

/// A trajectory is right if no angle is ever further than this from the reference.
pub const RIGHT_RAD: f64 = 1e-3;

/// δ_max of the contact law. The deepest the finger of the ensemble goes is a third of it.
const STEPPED_OVER_M: f64 = 1e-5;

/// A closing with two independent references: two methods at tolerances where both have converged.
pub struct Referenced {
    pub problem: Problem,
    pub references: [Track; 2],
}

/// Settings of the reference trajectories: Radau IIA 5 at 1e-11 and Rodas5P at 1e-12.
pub fn reference_settings() -> [Ours; 2] {
    [Ours::new(Method::RadauIIa5, 1e-11, 1e-13, 1e-9), Ours::new(Method::Rodas5p, 1e-12, 1e-14, 1e-10)]
}

impl Referenced {
    pub fn new(problem: Problem) -> Self {
        let references = reference_settings().map(|settings| settings.follow(&problem));
        Self { problem, references }
    }

    /// How far the two references are apart: errors below it say nothing.
    pub fn floor(&self) -> f64 {
        angle_distance(&self.references[0], &self.references[1])
    }

    /// A distance from the further one of the two references.
    fn distance_to_both(&self, distance: impl Fn(&Track) -> f64) -> f64 {
        largest(self.references.iter().map(distance))
    }
}

/// Errors over an ensemble; infinite ones, where a run failed or missed a contact, are null in JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Errors {
    pub right: usize,
    pub of: usize,
    /// Largest angle error along the trajectory.
    pub angle_median_rad: f64,
    pub angle_worst_rad: f64,
    /// Error of the time of a first touch.
    pub touch_median_s: f64,
    pub touch_worst_s: f64,
    /// Relative error of ∫ F_n dt; null where the contestant does not carry it.
    pub impulse_worst: Option<f64>,
    /// Complete runs that went deeper into the object than δ_max of the contact law, or never touched it: a step passed
    /// over the contact. Null where steps land on contacts.
    pub stepped_over: Option<usize>,
    /// Runs that did not reach the end, and why the first of them did not.
    pub failed: usize,
    pub failure: Option<String>,
    /// Means over the ensemble.
    pub cost: Cost,
}

/// Runs a contestant over the ensemble.
pub fn measure(contestant: &dyn Contestant, ensemble: &[Referenced]) -> Errors {
    let tracks: Vec<Track> = ensemble.iter().map(|case| contestant.follow(&case.problem)).collect();
    let pairs = || tracks.iter().zip(ensemble);
    let angle = sorted(pairs().map(|(t, case)| case.distance_to_both(|r| angle_distance(t, r))));
    let touch = sorted(pairs().map(|(t, case)| case.distance_to_both(|r| touch_distance(t, r))));
    let impulses: Option<Vec<f64>> =
        pairs().map(|(t, case)| Some(case.distance_to_both(|r| impulse_distance(t, r).unwrap_or(0.0)))).collect();
    let carries_impulse = tracks.iter().all(|t| t.impulse.is_some());
    let looks = tracks.iter().all(|t| t.deepest_m.is_some());
    let missed = |t: &Track| t.deepest_m.is_some_and(|d| d > STEPPED_OVER_M) || t.touch_s.contains(&None);
    let over = |t: &&Track| t.ended == Ended::Complete && missed(t);
    let failures = || {
        tracks.iter().filter_map(|t| match &t.ended {
            Ended::Complete => None,
            Ended::Singular(time_s) => Some(format!("singularity at {:.3} ms", time_s * 1e3)),
            Ended::Failed(reason) => Some(reason.clone()),
        })
    };
    let mean = |pick: fn(&Cost) -> u64| tracks.iter().map(|t| pick(&t.cost)).sum::<u64>() / tracks.len() as u64;
    Errors {
        right: angle.iter().filter(|e| **e <= RIGHT_RAD).count(),
        of: angle.len(),
        angle_median_rad: median(&angle),
        angle_worst_rad: worst(&angle),
        touch_median_s: median(&touch),
        touch_worst_s: worst(&touch),
        impulse_worst: impulses.filter(|_| carries_impulse).map(|x| largest(x.into_iter())),
        stepped_over: looks.then(|| tracks.iter().filter(over).count()),
        failed: failures().count(),
        failure: failures().next(),
        cost: Cost {
            rhs: mean(|c| c.rhs),
            jacobians: mean(|c| c.jacobians),
            steps: mean(|c| c.steps),
            rejected: mean(|c| c.rejected),
        },
    }
}

/// In ascending order.
pub fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

/// The middle of sorted values; not a number if there are none.
pub fn median(sorted: &[f64]) -> f64 {
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The last of sorted values; not a number if there are none.
pub fn worst(sorted: &[f64]) -> f64 {
    sorted.last().copied().unwrap_or(f64::NAN)
}
