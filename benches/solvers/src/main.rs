//! Compares the integrators of phalanx with published Rust solvers on the same right-hand side, in one run.
//!
//!     cargo run --release --manifest-path benches/solvers/Cargo.toml -- --json solvers.json
//!
//! With --cases it measures a closing finger, a closing gripper and a grasp cycle for the work–precision diagrams of
//! tools/work_precision.py, with the solvers that take systems of any size.
//!
//! The published solvers use the clamped force laws and the exact Jacobian, without event location.

// Only these solvers take systems of any size.
#![cfg_attr(not(any(feature = "cvode", feature = "diffsol")), allow(dead_code, unused_mut))]

#[cfg(feature = "diffsol")]
mod bdf;
mod case;
#[cfg(feature = "cvode")]
mod cvode;
mod diagram;
mod equations;
mod external_solver;
mod radau;
mod rodas;
#[path = "../../support/mod.rs"]
mod support;
mod vector_field;

use std::path::PathBuf;

use clap::Parser;
use phalanx::scene::{Method, Preset};

use diagram::{Diagram, MEMBERS, measure};
use support::phalanx_solver::PhalanxSolver;
use support::table::{compare, print};
use support::{BenchSolver, rtols, write};

#[derive(Debug, Parser)]
struct Args {
    /// Also write the results to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,

    /// Number of timed repetitions
    #[arg(long, default_value_t = 45, value_parser = clap::value_parser!(u32).range(1..))]
    repetitions: u32,

    /// Measure these cases for the work–precision diagrams
    #[arg(long, value_name = "CASE", num_args = 1..)]
    cases: Vec<CaseName>,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum CaseName {
    Finger,
    Gripper,
    Cycle,
}

impl CaseName {
    fn measure(self, rounds: usize) -> Diagram {
        let members = 0..MEMBERS;
        match self {
            Self::Finger => {
                let members: Vec<_> = members.map(case::finger).collect();
                measure("finger", &members, rounds)
            }
            Self::Gripper => {
                let members: Vec<_> = members.map(case::gripper).collect();
                measure("gripper", &members, rounds)
            }
            Self::Cycle => {
                let members: Vec<_> = members.map(case::cycle).collect();
                measure("cycle", &members, rounds)
            }
        }
    }
}

fn main() {
    let args = Args::parse();
    if !args.cases.is_empty() {
        let diagrams: Vec<Diagram> = args.cases.iter().map(|case| case.measure(args.repetitions as usize)).collect();
        match args.json {
            Some(path) => write(&path, &diagrams),
            None => println!("{diagrams:#?}"),
        }
        return;
    }
    let comparison = compare(&solvers(), args.repetitions as usize);
    print(&comparison);
    if let Some(path) = args.json {
        write(&path, &comparison);
    }
}

fn solvers() -> Vec<Box<dyn BenchSolver>> {
    let mut all: Vec<Box<dyn BenchSolver>> = Vec::new();
    for preset in [Preset::Engineering, Preset::Reference] {
        all.push(Box::new(PhalanxSolver::from_preset(preset)));
    }
    for method in [Method::Rodas5p, Method::RadauIIa5] {
        rtols().for_each(|rtol| all.push(Box::new(PhalanxSolver::with_rtol(method, rtol))));
    }
    rtols().for_each(|rtol| all.push(Box::new(radau::DeRadau5 { rtol })));
    rtols().for_each(|rtol| all.push(Box::new(rodas::Rodas4 { rtol })));
    #[cfg(feature = "diffsol")]
    rtols().for_each(|rtol| all.push(Box::new(bdf::Bdf { rtol })));
    #[cfg(feature = "cvode")]
    rtols().for_each(|rtol| all.push(Box::new(cvode::Cvode { rtol })));
    all
}
