//! Comparison of chaotic runs by statistics of many runs instead of trajectories.
//!
//! Rebounds amplify every earlier perturbation, the last digit of the torque as well as an integrator's error. Beyond
//! the time up to which a scene compares trajectories ([`Bounds::until_s`](crate::scene::Bounds)), both models
//! therefore run [`STATISTICS_RUNS`] times with torques spread evenly over ±[`TORQUE_SPREAD`]. The spread is the same
//! for both models and far wider than their errors. The means are compared by the standard error of their difference.

use crate::check::perturbed;
use crate::scene::{LogRates, Scene};
use crate::trace::{Cancellable, KeepRunning};
use crate::trace::{Event, EventKind, FingerContact, Model, Outcome, RunError, Sample, Sink, SinkError, run};

/// Number of runs of each model.
pub const STATISTICS_RUNS: usize = 24;
/// Half the relative spread of the motor torque over the runs.
pub const TORQUE_SPREAD: f64 = 0.01;
/// Largest accepted difference of two means, in standard errors. With six statistics and two correct models, one scene
/// in two thousand is judged wrongly.
pub const MAX_STANDARD_ERRORS: f64 = 4.0;

/// Sample rate of the integrals over time, Hz.
const INTEGRATION_HZ: f64 = 1e5;

/// Names of the statistics of a run, with their units.
pub const STATISTIC_NAMES: [&str; 6] = [
    "touchdowns_proximal",
    "touchdowns_distal",
    "impulse_proximal_n_s",
    "impulse_distal_n_s",
    "mean_q21_rad",
    "mean_kinetic_j",
];

/// Mean and standard deviation of a statistic over the runs of one model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanAndDeviation {
    pub mean: f64,
    pub deviation: f64,
}

/// One statistic in both models.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistic {
    pub name: &'static str,
    pub analytic: MeanAndDeviation,
    pub engine: MeanAndDeviation,
    /// Absolute difference of the means, in standard errors of that difference.
    pub standard_errors: f64,
}

/// Statistics of runs that are too sensitive to be compared individually.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    /// Start of the evaluated time, s.
    pub from_s: f64,
    /// Number of torques for which both models completed the run.
    pub runs: usize,
    pub statistics: Vec<Statistic>,
}

impl Statistics {
    /// Largest difference of a mean, in standard errors.
    pub fn worst(&self) -> f64 {
        self.statistics.iter().map(|statistic| statistic.standard_errors).fold(0.0, f64::max)
    }
}

/// Runs both models over the spread of torques and compares them from `bounds.until_s` on. Torques for which one of the
/// models does not complete the run (a fold of the linkage) are excluded and not counted in [`Statistics::runs`].
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
    let over_runs =
        |model: usize, index: usize| MeanAndDeviation::from_values(pairs.iter().map(|pair| pair[model][index]));
    let statistics = STATISTIC_NAMES.into_iter().enumerate().map(|(index, name)| {
        let (analytic, engine) = (over_runs(0, index), over_runs(1, index));
        Statistic { name, analytic, engine, standard_errors: standard_errors(&analytic, &engine, pairs.len()) }
    });
    Ok(Statistics { from_s: scene.bounds.until_s, runs: pairs.len(), statistics: statistics.collect() })
}

impl MeanAndDeviation {
    fn from_values(values: impl Iterator<Item = f64> + Clone) -> Self {
        let count = values.clone().count().max(1) as f64;
        let mean = values.clone().sum::<f64>() / count;
        let square: f64 = values.map(|value| (value - mean).powi(2)).sum();
        Self { mean, deviation: (square / (count - 1.0).max(1.0)).sqrt() }
    }
}

/// Difference of two means in its standard errors (Welch). Infinite for different values without scatter, and for fewer
/// than half of the runs.
fn standard_errors(a: &MeanAndDeviation, b: &MeanAndDeviation, runs: usize) -> f64 {
    let difference = (a.mean - b.mean).abs();
    let error = (a.deviation.hypot(b.deviation)) / (runs as f64).sqrt();
    // Values without scatter must agree to rounding.
    let rounding = 1e-6 * a.mean.abs().max(b.mean.abs());
    if runs < STATISTICS_RUNS / 2 {
        f64::INFINITY
    } else if difference <= rounding {
        0.0
    } else {
        difference / error
    }
}

/// Returns the statistics of one run from `bounds.until_s` on.
fn statistics_of_run(model: Model, scene: &Scene, keep_running: KeepRunning) -> Result<[f64; 6], RunError> {
    let mut sums = StatisticSums { from_s: scene.bounds.until_s, ..StatisticSums::default() };
    let sampled = Scene { log: LogRates { numeric_hz: INTEGRATION_HZ, ..scene.log }, ..scene.clone() };
    let outcome = run(model, &sampled, &mut Cancellable { sink: &mut sums, keep_running })?;
    Ok(sums.statistics(&outcome))
}

/// Accumulates the statistics of a run from a time on.
#[derive(Default)]
struct StatisticSums {
    from_s: f64,
    /// The first sample from `from_s` on.
    first: Option<Sample>,
    /// The latest sample.
    last: Option<Sample>,
    touchdowns: [f64; 2],
    /// ∫ q21 dt.
    q21_rad_s: f64,
    /// ∫ kinetic energy dt.
    kinetic_j_s: f64,
}

impl StatisticSums {
    fn statistics(&self, outcome: &Outcome) -> [f64; 6] {
        let default_sample = Sample::with_one_finger();
        let first = self.first.as_ref().unwrap_or(&default_sample);
        let length_s = outcome.last.time_s - first.time_s;
        let [proximal, distal] = self.touchdowns;
        [
            proximal,
            distal,
            outcome.last.contact(FingerContact::Proximal).impulse_n_s
                - first.contact(FingerContact::Proximal).impulse_n_s,
            outcome.last.contact(FingerContact::Distal).impulse_n_s - first.contact(FingerContact::Distal).impulse_n_s,
            self.q21_rad_s / length_s,
            self.kinetic_j_s / length_s,
        ]
    }
}

impl Sink for StatisticSums {
    fn sample(&mut self, sample: &Sample) -> Result<(), SinkError> {
        if sample.time_s < self.from_s {
            return Ok(());
        }
        self.first.get_or_insert_with(|| sample.clone());
        let before = self.last.as_ref().unwrap_or(sample);
        let half = 0.5 * (sample.time_s - before.time_s);
        self.q21_rad_s += half * (before.finger().q21_rad + sample.finger().q21_rad);
        self.kinetic_j_s += half * (before.energy.kinetic_j + sample.energy.kinetic_j);
        match &mut self.last {
            Some(last) => last.clone_from(sample),
            None => self.last = Some(sample.clone()),
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), SinkError> {
        if event.kind == EventKind::TouchDown
            && event.time_s >= self.from_s
            && event.finger_contact() != FingerContact::Limit
        {
            self.touchdowns[event.finger_contact() as usize] += 1.0;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_compared_with_their_standard_error() {
        let values = |shift: f64| (0..STATISTICS_RUNS).map(move |i| shift + (i % 4) as f64);
        let (a, b) = (MeanAndDeviation::from_values(values(0.0)), MeanAndDeviation::from_values(values(1.0)));
        assert!((a.mean - 1.5).abs() < 1e-12 && (b.mean - 2.5).abs() < 1e-12);
        let error = (2.0 * a.deviation.powi(2) / STATISTICS_RUNS as f64).sqrt();
        assert!((standard_errors(&a, &b, STATISTICS_RUNS) - 1.0 / error).abs() < 1e-12);
        assert_eq!(standard_errors(&a, &a, STATISTICS_RUNS), 0.0);
        // Values without scatter must agree, and too few runs are inconclusive.
        let fixed = |mean: f64| MeanAndDeviation { mean, deviation: 0.0 };
        assert_eq!(standard_errors(&fixed(3.0), &fixed(4.0), STATISTICS_RUNS), f64::INFINITY);
        assert_eq!(standard_errors(&fixed(3.0), &fixed(3.0), STATISTICS_RUNS), 0.0);
        assert_eq!(standard_errors(&a, &a, STATISTICS_RUNS / 2 - 1), f64::INFINITY);
    }
}
