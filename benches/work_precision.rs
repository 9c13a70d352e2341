//! Work and precision of the integrators: one closing of design 95 at several tolerances, and a thousand random designs.
//!
//!     cargo bench --bench work_precision
//!     cargo bench --bench work_precision -- --json work-precision.json --designs 100
//!
//! The comparison with published solvers is a separate crate, benches/solvers.

mod designs;
mod support;

use std::hint::black_box;
use std::path::PathBuf;

use clap::Parser;
use phalanx::scene::{Method, Preset};
use serde::Serialize;

use designs::sample::Drive;
use designs::sweep::{self, Sweep, sweep};
use support::phalanx_solver::PhalanxSolver;
use support::problem::design_95;
use support::table::{self, Comparison, compare};
use support::{BenchSolver, rtols, write};

#[derive(Debug, Parser)]
struct Args {
    /// Also write the results to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,

    /// Number of timed repetitions
    #[arg(long, default_value_t = 45, value_parser = clap::value_parser!(u32).range(1..))]
    repetitions: u32,

    /// Number of random designs of each kind; 0 skips them
    #[arg(long, default_value_t = 1000)]
    designs: usize,

    /// Only integrate this many closings with the engineering preset, for counting instructions
    #[arg(long, value_name = "N")]
    closings: Option<u32>,

    /// Flag added by cargo bench
    #[arg(long, hide = true)]
    bench: bool,
}

#[derive(Serialize)]
struct Document {
    comparison: Comparison,
    designs: Vec<Sweep>,
}

fn main() {
    let args = Args::parse();
    if let Some(closings) = args.closings {
        return integrate_only(closings);
    }
    let comparison = compare(&solvers(), args.repetitions as usize);
    table::print(&comparison);
    let drives = [Drive::Random, Drive::Sized];
    let designs: Vec<Sweep> = drives
        .into_iter()
        .filter(|_| args.designs > 0)
        .map(|drive| {
            let result = sweep(drive, args.designs);
            sweep::print(&result);
            result
        })
        .collect();
    if let Some(path) = args.json {
        write(&path, &Document { comparison, designs });
    }
}

fn solvers() -> Vec<Box<dyn BenchSolver>> {
    let presets = [Preset::Engineering, Preset::Reference].map(PhalanxSolver::from_preset);
    let methods = [Method::Rodas5p, Method::RadauIIa5];
    let sweep = methods.into_iter().flat_map(|method| rtols().map(move |rtol| PhalanxSolver::with_rtol(method, rtol)));
    presets.into_iter().chain(sweep).map(|solver| Box::new(solver) as Box<dyn BenchSolver>).collect()
}

fn integrate_only(closings: u32) {
    let (problem, preset) = (design_95(), PhalanxSolver::from_preset(Preset::Engineering));
    for _ in 0..closings {
        black_box(preset.run(black_box(&problem))).ok();
    }
}
