//! `phalanx optimize`: the search of the Python package, whose libraries (pymoo, cma) it uses.

use std::env;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use clap::Args;

use super::parsers::{count, model, picture, preset};
use super::{Failure, Status};
use crate::scene::Preset;
use crate::trace::Model;

/// Search for the best designs of any scene: vary fields within bounds to minimise or maximise results.
///
/// The study file (TOML) names a base scene, the variables with their bounds, the conditions under which every design runs, the
/// objectives and the constraints; scenes/studies/optimize-2f85.toml is an example to copy. The search is part of the Python
/// package, whose libraries it uses: NSGA-II of pymoo for several objectives, CMA-ES of cma for one.
///
/// Each design is a row of OUT, with its generation and whether it is on the front. Its runs are rows of a second table (OUT
/// with the suffix .runs.parquet), with the columns of `phalanx sweep`. Repeating an interrupted command resumes the search
/// and gives the same result.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx optimize scenes/studies/optimize-2f85.toml --out front.csv --plot front.svg\n  phalanx optimize \
                  my-study.toml --out front.parquet --scenes front --json\n  phalanx optimize my-study.toml --list\n\nExit status: 0 done; 1 no \
                  design meets all constraints; 2 bad input, or the Python package is missing; 3 interrupted (the same command resumes), or \
                  files could not be written."
)]
// The package reads the flags; this command checks and explains them.
pub(crate) struct OptimizeArgs {
    /// Study file (TOML); `phalanx schema optimize` describes it
    study: PathBuf,

    /// Write all designs to this file, as CSV or Parquet according to its extension
    #[arg(long, value_name = "FILE", required_unless_present = "list")]
    out: Option<PathBuf>,

    /// Draw the designs and the front, or write a page that also has the tables and the scenes of the front; can be repeated
    #[arg(long, value_name = "FILE.svg|png|html", value_parser = picture(&["svg", "png", "html"]))]
    plot: Vec<PathBuf>,

    /// Write each design of the front as a scene to this directory: design-N.toml, and start.toml
    #[arg(long, value_name = "DIR")]
    scenes: Option<PathBuf>,

    /// Simulation model, instead of the one in the study
    #[arg(long, value_parser = model())]
    model: Option<Model>,

    /// Preset of integrator method and tolerances of the analytic model, instead of those of the scene
    #[arg(long, value_parser = preset())]
    preset: Option<Preset>,

    /// Number of designs to print [default: 10]
    #[arg(long, value_name = "NUMBER", value_parser = count(1..=1_000_000, "10"))]
    best: Option<usize>,

    /// Discard the results of earlier commands and start again
    #[arg(long)]
    restart: bool,

    /// List variables, objectives and constraints without running the search
    #[arg(long)]
    list: bool,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    json: bool,
}

/// The interpreters to try.
const INTERPRETERS: [&str; 2] = ["python3", "python"];

/// Ends with status 0 if the package is installed with the libraries of the search.
const PROBE: &str =
    "import importlib.util, sys; sys.exit(not all(map(importlib.util.find_spec, ['phalanx', 'pymoo', 'cma'])))";

pub(super) fn run(_: &OptimizeArgs) -> Result<Status, Failure> {
    let has_package = |interpreter: &&str| {
        let mut probe = Command::new(interpreter);
        let status = probe.args(["-c", PROBE]).stdout(Stdio::null()).stderr(Stdio::null()).status();
        status.is_ok_and(|status| status.success())
    };
    let Some(interpreter) = INTERPRETERS.into_iter().find(has_package) else {
        return Err(Failure::bad_input(format!(
            "the search is part of the Python package, which {} cannot import with its libraries\n  = help: install it: pip \
             install \"phalanx[optimize]\"; in the source directory of phalanx: pip install \"./python[optimize]\"",
            INTERPRETERS.join(" or ")
        )));
    };
    let mut rest: Vec<OsString> = env::args_os().skip(1).collect();
    // Flags of all commands may precede the name of this one.
    if let Some(index) = rest.iter().position(|argument| argument == "optimize") {
        rest.remove(index);
    }
    let status = Command::new(interpreter).args(["-m", "phalanx.optimize"]).args(rest).status();
    let status = status.map_err(|error| Failure::incomplete(format!("{interpreter}: {error}")))?;
    Ok(match status.code() {
        Some(0) => Status::Done,
        Some(1) => Status::CheckFailed,
        Some(2) => Status::BadInput,
        _ => Status::Incomplete,
    })
}
