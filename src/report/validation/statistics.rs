//! Statistics of many runs, under the keys of the JSON document and as a table.

use serde::Serialize;

use crate::validate::{RUNS, SPREAD, Spread, Statistic, Statistics};
use crate::wording::duration;
use crate::wording::figures::figure;
use crate::wording::report::{Report, table};

/// Means over many runs from a time on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StatisticsReport {
    pub from_s: f64,
    /// Torques tried, spread evenly over ± this part, and those that both models went through to the end.
    pub runs: usize,
    pub torque_spread: f64,
    pub completed: usize,
    pub figures: Vec<StatisticReport>,
}

/// One figure of the runs of both models.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StatisticReport {
    /// With its unit.
    pub figure: &'static str,
    pub analytic_mean: f64,
    pub analytic_deviation: f64,
    pub engine_mean: f64,
    pub engine_deviation: f64,
    /// Difference of the means in its standard errors; null if it is not finite.
    pub standard_errors: f64,
}

impl From<&Statistics> for StatisticsReport {
    fn from(found: &Statistics) -> Self {
        let figure = |found: &Statistic| {
            let Statistic { name, analytic, engine, errors } = *found;
            let Spread { mean: analytic_mean, deviation: analytic_deviation } = analytic;
            let Spread { mean: engine_mean, deviation: engine_deviation } = engine;
            StatisticReport {
                figure: name,
                analytic_mean,
                analytic_deviation,
                engine_mean,
                engine_deviation,
                standard_errors: errors,
            }
        };
        StatisticsReport {
            from_s: found.from_s,
            runs: RUNS,
            torque_spread: SPREAD,
            completed: found.runs,
            figures: found.figures.iter().map(figure).collect(),
        }
    }
}

/// The statistics as a table.
pub fn statistics_text(report: &StatisticsReport) -> Report {
    let heading = format!(
        "mean ± deviation from {} on, of {} of {} runs with torques over ±{} %",
        duration(report.from_s),
        report.completed,
        report.runs,
        figure(100.0 * report.torque_spread, 2)
    );
    let mut rows = vec![[heading.as_str(), "analytic", "engine", "standard errors apart"].map(String::from).to_vec()];
    for found in &report.figures {
        let both = |mean: f64, deviation: f64| format!("{} ± {}", figure(mean, 4), figure(deviation, 2));
        rows.push(vec![
            found.figure.to_string(),
            both(found.analytic_mean, found.analytic_deviation),
            both(found.engine_mean, found.engine_deviation),
            figure(found.standard_errors, 2),
        ]);
    }
    table(&rows)
}
