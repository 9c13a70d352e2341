//! Common modules of the work–precision benchmarks: problem, solvers, errors, times, tables.
//!
//! | file | job |
//! |---|---|
//! | `problem` | one closing to integrate; the ensemble of fifteen closings |
//! | `trajectory` | result of one integration, and distances between two |
//! | `phalanx_solver` | the integrators of phalanx |
//! | `precision` | errors of a solver over the ensemble |
//! | `timing` | interleaved timing |
//! | `table` | results as a table |

pub mod phalanx_solver;
pub mod precision;
pub mod problem;
pub mod table;
pub mod timing;
pub mod trajectory;

use std::path::Path;

use problem::Problem;
use serde::Serialize;
use trajectory::{Cost, Trajectory};

/// A solver of a benchmark: a method with its tolerances.
pub trait BenchSolver {
    /// Name of the method.
    fn method(&self) -> &str;

    /// Name of the preset, if the solver is one.
    fn preset(&self) -> Option<&str> {
        None
    }

    /// Relative tolerance.
    fn rtol(&self) -> f64;

    /// Whether the solver is part of phalanx.
    fn is_phalanx(&self) -> bool {
        false
    }

    /// Integrates without an observer, for timing. Returns the cost, or the reason for the failure.
    fn run(&self, problem: &Problem) -> Result<Cost, String>;

    /// Integrates and records the trajectory.
    fn record(&self, problem: &Problem) -> Trajectory;
}

/// Writes the results of a benchmark as JSON; exits the process if that fails.
pub fn write(path: &Path, results: &impl Serialize) {
    let json = serde_json::to_string_pretty(results).map_err(std::io::Error::other);
    if let Err(error) = json.and_then(|text| std::fs::write(path, text + "\n")) {
        eprintln!("cannot write {}: {error}", path.display());
        std::process::exit(1);
    }
}

/// Returns the relative tolerances of a sweep, 1e-3 to 1e-10.
pub fn rtols() -> impl Iterator<Item = f64> {
    (3..=10).map(|digits| 10f64.powi(-digits))
}

/// Returns the absolute tolerances for a relative one (angles in rad, rates in rad/s), in the ratio of the engineering preset.
/// They are far below rtol · 1 rad, because penetrations are 1e-7 to 1e-4 rad.
pub fn absolute_tolerances(rtol: f64) -> (f64, f64) {
    (1e-4 * rtol, 10.0 * rtol)
}
