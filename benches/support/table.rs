//! The result: one row a contestant, as a table of text and as JSON.

use serde::Serialize;

use super::Contestant;
use super::precision::{Errors, Referenced, measure};
use super::problem::{Problem, ensemble};
use super::timing::{Times, interleaved};
use super::track::largest;

/// One contestant.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    pub method: String,
    pub preset: Option<String>,
    pub ours: bool,
    pub rtol: f64,
    pub errors: Errors,
    pub time: Times,
    /// Median time over that of the engineering preset in the same run.
    pub ratio: f64,
}

/// Precision and work of all contestants.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Largest distance of the two references.
    pub floor_rad: f64,
    pub rows: Vec<Row>,
}

/// Measures all contestants over the ensemble of design 95.
pub fn compare(contestants: &[Box<dyn Contestant>], rounds: usize) -> Comparison {
    let cases: Vec<Referenced> = ensemble().into_iter().map(Referenced::new).collect();
    let errors: Vec<Errors> = contestants.iter().map(|c| measure(c.as_ref(), &cases)).collect();
    let problems: Vec<&Problem> = cases.iter().map(|case| &case.problem).collect();
    let times = interleaved(contestants, &problems, rounds);
    let engineering = contestants.iter().position(|c| c.preset() == Some("engineering"));
    let unit = engineering.map_or(f64::NAN, |i| times[i].median_s);
    let rows = contestants.iter().zip(errors).zip(times).map(|((contestant, errors), time)| Row {
        method: contestant.method().to_string(),
        preset: contestant.preset().map(str::to_string),
        ours: contestant.is_ours(),
        rtol: contestant.rtol(),
        errors,
        time,
        ratio: time.median_s / unit,
    });
    Comparison { floor_rad: largest(cases.iter().map(Referenced::floor)), rows: rows.collect() }
}

/// Prints the table.
pub fn print(comparison: &Comparison) {
    println!("One 20 ms closing of design 95 over {} members of the ensemble.", super::problem::MEMBERS);
    println!("The two references are {:.1e} rad apart; errors are against the further one.\n", comparison.floor_rad);
    println!(
        "{:<34} {:>6} | {:>6} {:>8} {:>8} | {:>8} {:>8} | {:>5} | {:>9} {:>9} {:>6} | {:>6} {:>6} {:>6} {:>6}",
        "method",
        "rtol",
        "right",
        "angle",
        "worst",
        "touch s",
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
        let Errors { right, of, stepped_over, cost, .. } = &row.errors;
        let name = match &row.preset {
            Some(preset) => format!("{} ({preset})", row.method),
            None => row.method.clone(),
        };
        println!(
            "{name:<34} {:>6.0e} | {:>6} {:>8} {:>8} | {:>8} {:>8} | {:>5} | {:>9.1} {:>9.1} {:>6.2} | {:>6} {:>6} {:>6} {:>6}{}",
            row.rtol,
            format!("{right}/{of}"),
            scientific(row.errors.angle_median_rad),
            scientific(row.errors.angle_worst_rad),
            scientific(row.errors.touch_worst_s),
            row.errors.impulse_worst.map_or("n/a".into(), scientific),
            stepped_over.map_or("-".into(), |n| n.to_string()),
            row.time.median_s * 1e6,
            row.time.min_s * 1e6,
            row.ratio,
            cost.steps,
            cost.rejected,
            cost.rhs,
            cost.jacobians,
            row.errors.failure.as_ref().map_or(String::new(), |why| format!("  {} failed: {why}", row.errors.failed)),
        );
    }
}

/// 1.2e-3; a dash where a run failed or missed a contact.
pub fn scientific(x: f64) -> String {
    if x.is_finite() { format!("{x:.1e}") } else { "-".into() }
}
