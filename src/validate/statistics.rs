//! Comparison of chaotic runs by statistics of many runs instead of trajectories.
//!
//! Rebounds amplify every earlier perturbation, the last digit of the torque as well as an integrator's error. Beyond
//! the time up to which a scene compares trajectories ([`Bounds::until_s`](crate::scene::Bounds)), both models
//! therefore run [`STATISTICS_RUNS`] times with torques spread evenly over ±[`TORQUE_SPREAD`]. The spread is the same
//! for both models and far wider than their errors. The means are compared by the standard error of their difference.

use serde::Serialize;

use crate::check::perturbed;
use crate::scene::{HandContact, LogSettings, Scene, Side};
use crate::trace::{Cancellable, KeepRunning};
use crate::trace::{Event, EventKind, FingerContact, Model, RequiredData, RunError, Sample, Sink, SinkError, run};

/// Number of runs of each model.
pub(crate) const STATISTICS_RUNS: usize = 24;
/// Half the relative spread of the motor torque over the runs.
pub(crate) const TORQUE_SPREAD: f64 = 0.01;
/// Largest accepted difference of two means, in standard errors. For two correct models and six statistics, one scene
/// in two thousand is judged wrongly.
pub const MAX_STANDARD_ERRORS: f64 = 4.0;

/// Sample rate of the integrals over time, Hz.
const INTEGRATION_HZ: f64 = 1e5;

/// Names of the statistics of a run, with their units.
pub(crate) const STATISTIC_NAMES: [&str; 6] = [
    "touchdowns_proximal",
    "touchdowns_distal",
    "impulse_proximal_n_s",
    "impulse_distal_n_s",
    "mean_q21_rad",
    "mean_kinetic_j",
];

/// One statistic of both models: its mean and its standard deviation over the runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Statistic {
    /// Name of the statistic with its unit.
    #[serde(rename = "figure")]
    pub name: &'static str,
    pub analytic_mean: f64,
    pub analytic_deviation: f64,
    pub engine_mean: f64,
    pub engine_deviation: f64,
    /// Absolute difference of the two means, in standard errors of this difference.
    pub standard_errors: f64,
}

/// Statistics of runs that are too sensitive for an individual comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statistics {
    /// Start of the interval that is evaluated, s.
    pub from_s: f64,
    /// Number of motor torques; each is one run of both models.
    pub runs: usize,
    /// Half the relative spread of the torques.
    pub torque_spread: f64,
    /// Number of torques for which both models completed the run.
    pub completed: usize,
    #[serde(rename = "figures")]
    pub statistics: Vec<Statistic>,
}

impl Statistics {
    /// Largest difference of two means, in standard errors.
    pub fn worst(&self) -> f64 {
        self.statistics.iter().map(|statistic| statistic.standard_errors).fold(0.0, f64::max)
    }
}

/// Runs both models over the spread of torques and compares them from `bounds.until_s` on. A torque is excluded, and
/// not counted in [`Statistics::completed`], if one of the models does not complete its run (a fold of the linkage).
///
/// # Errors
/// Returns an error if a run was interrupted.
pub fn compare_statistics(scene: &Scene, keep_running: KeepRunning) -> Result<Statistics, RunError> {
    let mut pairs: Vec<[[f64; 6]; 2]> = Vec::with_capacity(STATISTICS_RUNS);
    for index in 0..STATISTICS_RUNS {
        let position = 2.0 * index as f64 / (STATISTICS_RUNS - 1) as f64 - 1.0;
        let scene = perturbed(scene, TORQUE_SPREAD * position);
        let both = [Model::Analytic, Model::Engine].map(|model| statistics_of_run(model, &scene, keep_running));
        match both {
            [Ok(analytic), Ok(engine)] => pairs.push([analytic, engine]),
            [Err(error), _] | [_, Err(error)] if error.is_stop() => return Err(error),
            _ => {}
        }
    }
    let statistic = |(index, name): (usize, &'static str)| {
        Statistic::new(name, [0, 1].map(|model| pairs.iter().map(|pair| pair[model][index]).collect()))
    };
    Ok(Statistics {
        from_s: scene.bounds.until_s,
        runs: STATISTICS_RUNS,
        torque_spread: TORQUE_SPREAD,
        completed: pairs.len(),
        statistics: STATISTIC_NAMES.into_iter().enumerate().map(statistic).collect(),
    })
}

impl Statistic {
    /// Compares the values of the runs of both models by the standard error of the difference of their means (Welch).
    /// That is infinite for different values without scatter, and for fewer than half of the runs.
    fn new(name: &'static str, [analytic, engine]: [Vec<f64>; 2]) -> Self {
        let runs = analytic.len();
        let [(analytic_mean, analytic_deviation), (engine_mean, engine_deviation)] =
            [analytic, engine].map(|values| mean_and_deviation(&values));
        let difference = (analytic_mean - engine_mean).abs();
        let error = analytic_deviation.hypot(engine_deviation) / (runs as f64).sqrt();
        // Values without scatter must agree to rounding.
        let rounding = 1e-6 * analytic_mean.abs().max(engine_mean.abs());
        let standard_errors = match difference <= rounding {
            _ if runs < STATISTICS_RUNS / 2 => f64::INFINITY,
            true => 0.0,
            false => difference / error,
        };
        Statistic { name, analytic_mean, analytic_deviation, engine_mean, engine_deviation, standard_errors }
    }
}

fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (square / (count - 1.0).max(1.0)).sqrt())
}

/// Returns the statistics of one run from `bounds.until_s` on.
fn statistics_of_run(model: Model, scene: &Scene, keep_running: KeepRunning) -> Result<[f64; 6], RunError> {
    let phalanges = [FingerContact::Proximal, FingerContact::Distal];
    let contact = |phalanx| scene.hand.contact_index(HandContact::Finger(Side::Right, phalanx));
    let (from_s, contacts) = (scene.bounds.until_s, phalanges.map(contact));
    let mut sums = StatisticSums { from_s, contacts, ..StatisticSums::default() };
    let sampled = Scene { log: LogSettings { numeric_hz: INTEGRATION_HZ, ..scene.log }, ..scene.clone() };
    let outcome = run(model, &sampled, &mut Cancellable { sink: &mut sums, keep_running })?;
    let first = sums.first.unwrap_or_else(Sample::with_one_finger);
    let length_s = outcome.last.time_s - first.time_s;
    let [proximal_n_s, distal_n_s] = phalanges
        .map(|contact| outcome.last.finger_contact(contact).impulse_n_s - first.finger_contact(contact).impulse_n_s);
    let [proximal, distal] = sums.touchdowns;
    Ok([proximal, distal, proximal_n_s, distal_n_s, sums.q21_rad_s / length_s, sums.kinetic_j_s / length_s])
}

/// Accumulates the statistics of a run from a time on.
#[derive(Default)]
struct StatisticSums {
    from_s: f64,
    /// Contacts of the proximal and the distal phalanx.
    contacts: [Option<usize>; 2],
    /// The first sample from `from_s` on.
    first: Option<Sample>,
    /// Time, q21 and kinetic energy of the latest sample.
    last: Option<[f64; 3]>,
    touchdowns: [f64; 2],
    /// ∫ q21 dt.
    q21_rad_s: f64,
    /// ∫ kinetic energy dt.
    kinetic_j_s: f64,
}

impl Sink for StatisticSums {
    fn required_data(&self) -> RequiredData {
        RequiredData::EVALUATION
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if sample.time_s < self.from_s {
            return Ok(());
        }
        self.first.get_or_insert_with(|| sample.clone());
        let now = [sample.time_s, sample.finger(0).q21_rad, sample.energy().kinetic_j];
        let [time_s, q21_rad, kinetic_j] = self.last.replace(now).unwrap_or(now);
        let half = 0.5 * (now[0] - time_s);
        self.q21_rad_s += half * (q21_rad + now[1]);
        self.kinetic_j_s += half * (kinetic_j + now[2]);
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        let phalanx = self.contacts.iter().position(|contact| *contact == Some(event.contact));
        if let Some(phalanx) = phalanx.filter(|_| event.kind == EventKind::TouchDown && event.time_s >= self.from_s) {
            self.touchdowns[phalanx] += 1.0;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_compared_with_their_standard_error() {
        let values = |shift: f64| (0..STATISTICS_RUNS).map(|i| shift + (i % 4) as f64).collect::<Vec<_>>();
        let errors = |a: Vec<f64>, b: Vec<f64>| Statistic::new("", [a, b]).standard_errors;
        let found = Statistic::new("", [values(0.0), values(1.0)]);
        assert!((found.analytic_mean - 1.5).abs() < 1e-12 && (found.engine_mean - 2.5).abs() < 1e-12);
        let error = (2.0 * found.analytic_deviation.powi(2) / STATISTICS_RUNS as f64).sqrt();
        assert!((found.standard_errors - 1.0 / error).abs() < 1e-12);
        assert_eq!(errors(values(0.0), values(0.0)), 0.0);
        // Values without scatter must agree, and too few runs are inconclusive.
        let fixed = |mean: f64| vec![mean; STATISTICS_RUNS];
        assert_eq!(errors(fixed(3.0), fixed(4.0)), f64::INFINITY);
        assert_eq!(errors(fixed(3.0), fixed(3.0)), 0.0);
        let few = || values(0.0)[..STATISTICS_RUNS / 2 - 1].to_vec();
        assert_eq!(errors(few(), few()), f64::INFINITY);
    }
}
