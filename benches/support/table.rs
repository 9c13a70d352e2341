//! Results as a text table and as JSON, with one row per solver.

use serde::Serialize;

use super::BenchSolver;
use super::precision::{Errors, Referenced, measure};
use super::problem::{Problem, ensemble};
use super::timing::{Times, measure_interleaved};
use super::trajectory::largest;

/// Result of one solver.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub method: String,
    pub preset: Option<String>,
    #[serde(rename = "ours")]
    pub is_phalanx: bool,
    pub rtol: f64,
    pub errors: Errors,
    pub time: Times,
    /// Median time relative to the engineering preset in the same benchmark.
    pub ratio: f64,
}

/// Precision and work of all solvers.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Largest distance between the two references.
    pub floor_rad: f64,
    pub rows: Vec<Row>,
}

/// Measures all solvers over the ensemble of design 95.
pub fn compare(solvers: &[Box<dyn BenchSolver>], rounds: usize) -> Comparison {
    let cases: Vec<Referenced> = ensemble().into_iter().map(Referenced::new).collect();
    let errors: Vec<Errors> = solvers.iter().map(|c| measure(c.as_ref(), &cases)).collect();
    let problems: Vec<&Problem> = cases.iter().map(|case| &case.problem).collect();
    let times = measure_interleaved(solvers, &problems, rounds);
    let engineering = solvers.iter().position(|c| c.preset() == Some("engineering"));
    let engineering_s = engineering.map_or(f64::NAN, |i| times[i].median_s);
    let rows = solvers.iter().zip(errors).zip(times).map(|((solver, errors), time)| Row {
        method: solver.method().to_string(),
        preset: solver.preset().map(str::to_string),
        is_phalanx: solver.is_phalanx(),
        rtol: solver.rtol(),
        errors,
        time,
        ratio: time.median_s / engineering_s,
    });
    Comparison { floor_rad: largest(cases.iter().map(Referenced::floor)), rows: rows.collect() }
}

/// Prints the table.
pub fn print(comparison: &Comparison) {
    println!("One 20 ms closing of design 95 over {} members of the ensemble.", super::problem::MEMBERS);
    println!(
        "The two references differ by {:.1e} rad; errors are relative to the one that is farther away.\n",
        comparison.floor_rad
    );
    println!(
        "{:<34} {:>6} | {:>6} {:>8} {:>8} | {:>8} {:>8} | {:>5} | {:>9} {:>9} {:>6} | {:>6} {:>6} {:>6} {:>6}",
        "method",
        "rtol",
        "accurate",
        "angle",
        "worst",
        "contact s",
        "impulse",
        "over",
        "median µs",
        "min µs",
        "ratio",
        "steps",
        "reject",
        "rhs",
        "jac"
    );
    for row in &comparison.rows {
        let Errors { accurate, total, stepped_over, cost, .. } = &row.errors;
        let name = match &row.preset {
            Some(preset) => format!("{} ({preset})", row.method),
            None => row.method.clone(),
        };
        println!(
            "{name:<34} {:>6.0e} | {:>6} {:>8} {:>8} | {:>8} {:>8} | {:>5} | {:>9.1} {:>9.1} {:>6.2} | {:>6} {:>6} {:>6} {:>6}{}",
            row.rtol,
            format!("{accurate}/{total}"),
            scientific(row.errors.angle_median_rad),
            scientific(row.errors.angle_worst_rad),
            scientific(row.errors.contact_time_worst_s),
            row.errors.impulse_worst.map_or("n/a".into(), scientific),
            stepped_over.map_or("-".into(), |n| n.to_string()),
            row.time.median_s * 1e6,
            row.time.min_s * 1e6,
            row.ratio,
            cost.steps,
            cost.rejected,
            cost.rhs,
            cost.jacobians,
            row.errors
                .failure
                .as_ref()
                .map_or(String::new(), |reason| format!("  {} failed: {reason}", row.errors.failed)),
        );
    }
}

/// Formats a number like 1.2e-3, and an infinite error as a dash.
pub fn scientific(x: f64) -> String {
    if x.is_finite() { format!("{x:.1e}") } else { "-".into() }
}
