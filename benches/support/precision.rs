//! Errors of a solver over the ensemble.

use phalanx::scene::Method;
use serde::Serialize;

use super::BenchSolver;
use super::phalanx_solver::PhalanxSolver;
use super::problem::Problem;
use super::trajectory::{Cost, EndState, Trajectory, angle_distance, contact_time_distance, impulse_distance, largest};

/// Largest angle error of an accurate trajectory.
pub const ACCURATE_RAD: f64 = 1e-3;

/// δ_max of the contact law. The finger of the ensemble penetrates by at most a third of it.
const MAX_PENETRATION_M: f64 = 1e-5;

/// A closing with two independent references: two methods at tolerances at which both have converged.
pub struct Referenced {
    pub problem: Problem,
    pub references: [Trajectory; 2],
}

/// Returns the settings of the reference trajectories: Radau IIA 5 at 1e-11 and Rodas5P at 1e-12.
pub fn reference_settings() -> [PhalanxSolver; 2] {
    [
        PhalanxSolver::new(Method::RadauIIa5, 1e-11, 1e-13, 1e-9),
        PhalanxSolver::new(Method::Rodas5p, 1e-12, 1e-14, 1e-10),
    ]
}

impl Referenced {
    pub fn new(problem: Problem) -> Self {
        let references = reference_settings().map(|settings| settings.record(&problem));
        Self { problem, references }
    }

    /// Returns the distance of the two references. Smaller errors are not significant.
    pub fn floor(&self) -> f64 {
        angle_distance(&self.references[0], &self.references[1])
    }

    /// Returns the larger of the distances from the two references.
    fn distance_to_references(&self, distance: impl Fn(&Trajectory) -> f64) -> f64 {
        largest(self.references.iter().map(distance))
    }
}

/// Errors over an ensemble. Infinite errors, of runs that failed or missed a contact, are null in JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Errors {
    /// Number of runs with an angle error of at most [`ACCURATE_RAD`].
    #[serde(rename = "right")]
    pub accurate: usize,
    /// Number of runs.
    #[serde(rename = "of")]
    pub total: usize,
    /// Largest angle error along the trajectory.
    pub angle_median_rad: f64,
    pub angle_worst_rad: f64,
    /// Error of the time of a first contact.
    #[serde(rename = "touch_median_s")]
    pub contact_time_median_s: f64,
    #[serde(rename = "touch_worst_s")]
    pub contact_time_worst_s: f64,
    /// Relative error of ∫ F_n dt; null if the solver does not integrate it.
    pub impulse_worst: Option<f64>,
    /// Complete runs with a penetration above δ_max of the contact law or without contact: a step passed over the contact.
    /// Null for solvers with event location.
    pub stepped_over: Option<usize>,
    /// Number of runs that failed, and the reason of the first failure.
    pub failed: usize,
    pub failure: Option<String>,
    /// Mean cost over the ensemble.
    pub cost: Cost,
}

/// Runs a solver over the ensemble.
pub fn measure(solver: &dyn BenchSolver, ensemble: &[Referenced]) -> Errors {
    let trajectories: Vec<Trajectory> = ensemble.iter().map(|case| solver.record(&case.problem)).collect();
    let pairs = || trajectories.iter().zip(ensemble);
    let angle = sorted(pairs().map(|(t, case)| case.distance_to_references(|r| angle_distance(t, r))));
    let contact_time = sorted(pairs().map(|(t, case)| case.distance_to_references(|r| contact_time_distance(t, r))));
    let impulses: Option<Vec<f64>> =
        pairs().map(|(t, case)| Some(case.distance_to_references(|r| impulse_distance(t, r).unwrap_or(0.0)))).collect();
    let has_impulse = trajectories.iter().all(|t| t.impulse.is_some());
    let has_penetration = trajectories.iter().all(|t| t.max_penetration_m.is_some());
    let missed_contact = |t: &Trajectory| {
        t.max_penetration_m.is_some_and(|d| d > MAX_PENETRATION_M) || t.first_contact_s.contains(&None)
    };
    let stepped_over = |t: &&Trajectory| t.end_state == EndState::Complete && missed_contact(t);
    let failures = || {
        trajectories.iter().filter_map(|t| match &t.end_state {
            EndState::Complete => None,
            EndState::Singular(time_s) => Some(format!("singularity at {:.3} ms", time_s * 1e3)),
            EndState::Failed(reason) => Some(reason.clone()),
        })
    };
    let mean =
        |count: fn(&Cost) -> u64| trajectories.iter().map(|t| count(&t.cost)).sum::<u64>() / trajectories.len() as u64;
    Errors {
        accurate: angle.iter().filter(|e| **e <= ACCURATE_RAD).count(),
        total: angle.len(),
        angle_median_rad: median(&angle),
        angle_worst_rad: worst(&angle),
        contact_time_median_s: median(&contact_time),
        contact_time_worst_s: worst(&contact_time),
        impulse_worst: impulses.filter(|_| has_impulse).map(|x| largest(x.into_iter())),
        stepped_over: has_penetration.then(|| trajectories.iter().filter(stepped_over).count()),
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

/// Returns the values in ascending order.
pub fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

/// Returns the median of sorted values; NaN without values.
pub fn median(sorted: &[f64]) -> f64 {
    sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Returns the last of sorted values; NaN without values.
pub fn worst(sorted: &[f64]) -> f64 {
    sorted.last().copied().unwrap_or(f64::NAN)
}
