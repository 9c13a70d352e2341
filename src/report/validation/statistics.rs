//! Statistics of many runs, under the keys of the JSON document and as a table.

use serde::Serialize;

use crate::format::format_duration;
use crate::format::numbers::format_number;
use crate::format::report::{Report, table};
use crate::validate::{MeanAndDeviation, STATISTICS_RUNS, Statistic, Statistics, TORQUE_SPREAD};

/// Comparison of means over many runs from a time on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StatisticsReport {
    pub from_s: f64,
    /// Number of torques.
    pub runs: usize,
    /// Half the relative spread of the torques.
    pub torque_spread: f64,
    /// Number of torques for which both models completed the run.
    pub completed: usize,
    pub figures: Vec<StatisticReport>,
}

/// One statistic of both models.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StatisticReport {
    /// Name with unit.
    pub figure: &'static str,
    pub analytic_mean: f64,
    pub analytic_deviation: f64,
    pub engine_mean: f64,
    pub engine_deviation: f64,
    /// Difference of the means in standard errors; null if it is not finite.
    pub standard_errors: f64,
}

impl From<&Statistics> for StatisticsReport {
    fn from(found: &Statistics) -> Self {
        let report = |found: &Statistic| {
            let Statistic { name, analytic, engine, standard_errors } = *found;
            let MeanAndDeviation { mean: analytic_mean, deviation: analytic_deviation } = analytic;
            let MeanAndDeviation { mean: engine_mean, deviation: engine_deviation } = engine;
            StatisticReport {
                figure: name,
                analytic_mean,
                analytic_deviation,
                engine_mean,
                engine_deviation,
                standard_errors,
            }
        };
        StatisticsReport {
            from_s: found.from_s,
            runs: STATISTICS_RUNS,
            torque_spread: TORQUE_SPREAD,
            completed: found.runs,
            figures: found.statistics.iter().map(report).collect(),
        }
    }
}

/// Returns the statistics as a table.
pub fn statistics_table(report: &StatisticsReport) -> Report {
    let heading = format!(
        "mean ± deviation from {} on, for {} of {} runs with torques over ±{} %",
        format_duration(report.from_s),
        report.completed,
        report.runs,
        format_number(100.0 * report.torque_spread, 2)
    );
    let mut rows =
        vec![[heading.as_str(), "analytic", "engine", "difference, standard errors"].map(String::from).to_vec()];
    for found in &report.figures {
        let with_deviation =
            |mean: f64, deviation: f64| format!("{} ± {}", format_number(mean, 4), format_number(deviation, 2));
        rows.push(vec![
            found.figure.to_string(),
            with_deviation(found.analytic_mean, found.analytic_deviation),
            with_deviation(found.engine_mean, found.engine_deviation),
            format_number(found.standard_errors, 2),
        ]);
    }
    table(&rows)
}
