//! What can be compared of chaotic runs: not trajectories, but statistics of many.
//!
//! Rebounds multiply whatever came before them, the last digit of the torque as well as an integrator's error. Beyond the
//! time up to which a scene compares trajectories ([`Bounds::until_s`](crate::scene::Bounds)), both models therefore run
//! [`RUNS`] times with torques spread evenly over ±[`SPREAD`], far wider than either's error and the same for both, and
//! their means are compared with the standard error of their difference.

use crate::check::pushed;
use crate::scene::{LogRates, Scene};
use crate::trace::{Event, EventKind, Model, Outcome, RunError, Sample, Sink, SinkError, Site, run};
use crate::trace::{GoOn, While};

/// Runs of each model.
pub const RUNS: usize = 24;
/// Half the relative spread of the motor torque over the runs.
pub const SPREAD: f64 = 0.01;
/// Means further apart than so many standard errors are different. With six figures and both models right, one scene in
/// two thousand would be judged wrongly.
pub const MOST_ERRORS: f64 = 4.0;

/// Means over time are sums over a grid this fine.
const SAMPLES_HZ: f64 = 1e5;

/// Names of the figures of a run, with their units.
pub const FIGURES: [&str; 6] = [
    "touchdowns_proximal",
    "touchdowns_distal",
    "impulse_proximal_n_s",
    "impulse_distal_n_s",
    "mean_q21_rad",
    "mean_kinetic_j",
];

/// Mean and standard deviation of a figure over the runs of one model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    pub mean: f64,
    pub deviation: f64,
}

/// One figure in both models.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistic {
    pub name: &'static str,
    pub analytic: Spread,
    pub engine: Spread,
    /// |difference of the means| in standard errors of that difference.
    pub errors: f64,
}

/// Everything that is compared of runs that are too sensitive to be compared one by one.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    pub from_s: f64,
    /// Torques that both models went through to the end.
    pub runs: usize,
    pub figures: Vec<Statistic>,
}

impl Statistics {
    /// Largest difference of a mean, in standard errors.
    pub fn worst(&self) -> f64 {
        self.figures.iter().map(|figure| figure.errors).fold(0.0, f64::max)
    }
}

/// Runs both models over the spread of torques, and compares them from `bounds.until_s` on. Torques that one of the models
/// does not get to the end with (a fold of the linkage) are left out, and counted by that.
///
/// # Errors
/// A run was stopped.
pub fn statistics(scene: &Scene, go_on: GoOn) -> Result<Statistics, RunError> {
    let mut pairs: Vec<[[f64; 6]; 2]> = Vec::with_capacity(RUNS);
    for index in 0..RUNS {
        let place = 2.0 * index as f64 / (RUNS - 1) as f64 - 1.0;
        let scene = pushed(scene, SPREAD * place);
        let both = [Model::Analytic, Model::Engine].map(|model| tally(model, &scene, go_on));
        match both {
            [Ok(analytic), Ok(engine)] => pairs.push([analytic, engine]),
            [Err(error), _] | [_, Err(error)] if error.is_stop() => return Err(error),
            _ => {}
        }
    }
    let spread = |model: usize, figure: usize| Spread::of(pairs.iter().map(|pair| pair[model][figure]));
    let figures = FIGURES.into_iter().enumerate().map(|(figure, name)| {
        let (analytic, engine) = (spread(0, figure), spread(1, figure));
        Statistic { name, analytic, engine, errors: errors(&analytic, &engine, pairs.len()) }
    });
    Ok(Statistics { from_s: scene.bounds.until_s, runs: pairs.len(), figures: figures.collect() })
}

impl Spread {
    fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let count = values.clone().count().max(1) as f64;
        let mean = values.clone().sum::<f64>() / count;
        let square: f64 = values.map(|value| (value - mean).powi(2)).sum();
        Self { mean, deviation: (square / (count - 1.0).max(1.0)).sqrt() }
    }
}

/// Difference of two means in its standard errors (Welch); infinite where figures that do not spread differ, or too few
/// runs are left to say.
fn errors(a: &Spread, b: &Spread, runs: usize) -> f64 {
    let difference = (a.mean - b.mean).abs();
    let error = (a.deviation.hypot(b.deviation)) / (runs as f64).sqrt();
    // What does not spread agrees to rounding, or does not.
    let rounding = 1e-6 * a.mean.abs().max(b.mean.abs());
    if runs < RUNS / 2 {
        f64::INFINITY
    } else if difference <= rounding {
        0.0
    } else {
        difference / error
    }
}

/// The figures of one run from the time on from which it is compared by them.
fn tally(model: Model, scene: &Scene, go_on: GoOn) -> Result<[f64; 6], RunError> {
    let mut tally = Tally { from_s: scene.bounds.until_s, ..Tally::default() };
    let sampled = Scene { log: LogRates { numeric_hz: SAMPLES_HZ, ..scene.log }, ..scene.clone() };
    let outcome = run(model, &sampled, &mut While { sink: &mut tally, go_on })?;
    Ok(tally.figures(&outcome))
}

/// Sums up a run from a time on.
#[derive(Default)]
struct Tally {
    from_s: f64,
    /// The first sample from then on, and the latest.
    first: Option<Sample>,
    last: Option<Sample>,
    touchdowns: [f64; 2],
    /// ∫ q21 dt and ∫ kinetic energy dt.
    q21_rad_s: f64,
    kinetic_j_s: f64,
}

impl Tally {
    fn figures(&self, outcome: &Outcome) -> [f64; 6] {
        let nothing = Sample::of_finger();
        let first = self.first.as_ref().unwrap_or(&nothing);
        let length_s = outcome.last.time_s - first.time_s;
        let [proximal, distal] = self.touchdowns;
        [
            proximal,
            distal,
            outcome.last.contact(Site::Proximal).impulse_n_s - first.contact(Site::Proximal).impulse_n_s,
            outcome.last.contact(Site::Distal).impulse_n_s - first.contact(Site::Distal).impulse_n_s,
            self.q21_rad_s / length_s,
            self.kinetic_j_s / length_s,
        ]
    }
}

impl Sink for Tally {
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
        if event.kind == EventKind::TouchDown && event.time_s >= self.from_s && event.site() != Site::Limit {
            self.touchdowns[event.site() as usize] += 1.0;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_compared_with_their_standard_error() {
        let values = |shift: f64| (0..RUNS).map(move |i| shift + (i % 4) as f64);
        let (a, b) = (Spread::of(values(0.0)), Spread::of(values(1.0)));
        assert!((a.mean - 1.5).abs() < 1e-12 && (b.mean - 2.5).abs() < 1e-12);
        let error = (2.0 * a.deviation.powi(2) / RUNS as f64).sqrt();
        assert!((errors(&a, &b, RUNS) - 1.0 / error).abs() < 1e-12);
        assert_eq!(errors(&a, &a, RUNS), 0.0);
        // What does not spread must agree, and too few runs say nothing.
        let fixed = |mean: f64| Spread { mean, deviation: 0.0 };
        assert_eq!(errors(&fixed(3.0), &fixed(4.0), RUNS), f64::INFINITY);
        assert_eq!(errors(&fixed(3.0), &fixed(3.0), RUNS), 0.0);
        assert_eq!(errors(&a, &a, RUNS / 2 - 1), f64::INFINITY);
    }
}
