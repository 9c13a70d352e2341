//! The integrators of phalanx beside published Rust solvers on the same right-hand side, in one run.
//!
//!     cargo run --release --manifest-path benches/solvers/Cargo.toml -- --json solvers.json
//!
//! The published solvers get the natural, clamped force laws and the exact Jacobian, and know nothing of events.

#[cfg(feature = "diffsol")]
mod bdf;
mod field;
mod published;
mod radau;
mod rodas;
#[path = "../../support/mod.rs"]
mod support;

use std::path::PathBuf;

use clap::Parser;
use phalanx::scene::{Method, Preset};

use support::ours::Ours;
use support::table::{compare, print};
use support::{Contestant, rtols, write};

#[derive(Debug, Parser)]
struct Args {
    /// Also write the figures to this file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,

    /// Repetitions that are timed
    #[arg(long, default_value_t = 45, value_parser = clap::value_parser!(u32).range(1..))]
    repetitions: u32,
}

fn main() {
    let args = Args::parse();
    let comparison = compare(&contestants(), args.repetitions as usize);
    print(&comparison);
    if let Some(path) = args.json {
        write(&path, &comparison);
    }
}

fn contestants() -> Vec<Box<dyn Contestant>> {
    let mut all: Vec<Box<dyn Contestant>> = Vec::new();
    for preset in [Preset::Engineering, Preset::Reference] {
        all.push(Box::new(Ours::preset(preset)));
    }
    for method in [Method::Rodas5p, Method::RadauIIa5] {
        rtols().for_each(|rtol| all.push(Box::new(Ours::at(method, rtol))));
    }
    rtols().for_each(|rtol| all.push(Box::new(radau::DeRadau5 { rtol })));
    rtols().for_each(|rtol| all.push(Box::new(rodas::Rodas4 { rtol })));
    #[cfg(feature = "diffsol")]
    rtols().for_each(|rtol| all.push(Box::new(bdf::Bdf { rtol })));
    all
}
