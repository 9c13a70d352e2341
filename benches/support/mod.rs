//! What the work–precision benches share: the problem, the contestants, errors, times, tables.
//!
//! | file | job |
//! |---|---|
//! | `problem` | one closing to be integrated; the ensemble of fifteen |
//! | `track` | what one integration of it looked like, and how far two are apart |
//! | `ours` | the integrators of this crate as contestants |
//! | `precision` | errors of a contestant over the ensemble |
//! | `timing` | interleaved times |
//! | `table` | rows of the result, as text |

pub mod ours;
pub mod precision;
pub mod problem;
pub mod table;
pub mod timing;
pub mod track;

use std::path::Path;

use problem::Problem;
use serde::Serialize;
use track::{Cost, Track};

/// One way to integrate a closing: a method with its tolerances.
pub trait Contestant {
    fn method(&self) -> &str;

    /// Name of the preset, where it is one.
    fn preset(&self) -> Option<&str> {
        None
    }

    /// Relative tolerance.
    fn rtol(&self) -> f64;

    /// Whether it is one of this crate.
    fn is_ours(&self) -> bool {
        false
    }

    /// Integrates with nobody watching, to be timed; what it cost, or why it failed.
    fn run(&self, problem: &Problem) -> Result<Cost, String>;

    /// Integrates and records the trajectory.
    fn follow(&self, problem: &Problem) -> Track;
}

/// Writes the figures of a bench as JSON; where that fails there is nothing left to do.
pub fn write(path: &Path, figures: &impl Serialize) {
    let written = serde_json::to_string_pretty(figures).map_err(std::io::Error::other);
    if let Err(error) = written.and_then(|text| std::fs::write(path, text + "\n")) {
        eprintln!("cannot write {}: {error}", path.display());
        std::process::exit(1);
    }
}

/// Relative tolerances of a sweep, 1e-3 to 1e-10.
pub fn rtols() -> impl Iterator<Item = f64> {
    (3..=10).map(|digits| 10f64.powi(-digits))
}

/// Absolute tolerances that go with a relative one, (angles in rad, rates in rad/s): those of the engineering preset,
/// moved along with it. They lie far below rtol · 1 rad, for penetrations are 1e-7 to 1e-4 rad.
pub fn absolute(rtol: f64) -> (f64, f64) {
    (1e-4 * rtol, 10.0 * rtol)
}
