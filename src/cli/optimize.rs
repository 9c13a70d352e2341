//! `phalanx optimize`: the search of the Python package, whose libraries (pymoo, cma) it uses.

use std::ffi::OsString;
use std::process::{Command, Stdio};

use clap::Args;

use super::{Failure, Status};

/// Search for the best designs of any scene: vary fields within bounds to minimise or maximise results.
///
/// The study file (TOML) names a base scene, the variables with their bounds, the conditions under which every design runs, the
/// objectives and the constraints; scenes/studies/optimize-2f85.toml is an example to copy. The search is part of the Python
/// package, whose libraries it uses: NSGA-II of pymoo for several objectives, CMA-ES of cma for one.
#[derive(Debug, Args)]
#[command(
    disable_help_flag = true,
    after_help = "Examples:\n  phalanx optimize scenes/studies/optimize-2f85.toml --out front.csv --plot front.svg\n  phalanx optimize \
                  my-study.toml --list\n  phalanx optimize --help\n\nExit status: 0 done; 1 no design meets all constraints; 2 bad input, or the \
                  Python package is missing; 3 interrupted (the same command resumes), or files could not be written."
)]
pub(crate) struct OptimizeArgs {
    /// Study file and flags; --help of this command lists them
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "STUDY")]
    rest: Vec<OsString>,
}

/// The interpreters to try.
const INTERPRETERS: [&str; 2] = ["python3", "python"];

/// Ends with status 0 if the package is installed with its optional libraries.
const PROBE: &str =
    "import importlib.util, sys; sys.exit(not all(map(importlib.util.find_spec, ['phalanx', 'pymoo', 'cma'])))";

pub(super) fn run(args: &OptimizeArgs) -> Result<Status, Failure> {
    let has_package = |interpreter: &&str| {
        let mut probe = Command::new(interpreter);
        let status = probe.args(["-c", PROBE]).stdout(Stdio::null()).stderr(Stdio::null()).status();
        status.is_ok_and(|status| status.success())
    };
    let Some(interpreter) = INTERPRETERS.into_iter().find(has_package) else {
        return Err(Failure::bad_input(format!(
            "the search is part of the Python package, which {} has not\n  = help: install it: pip install \
             \"phalanx[optimize]\" (in the source directory: pip install \"./python[optimize]\")",
            INTERPRETERS.join(" or ")
        )));
    };
    let status = Command::new(interpreter).args(["-m", "phalanx.optimize"]).args(&args.rest).status();
    let status = status.map_err(|error| Failure::incomplete(format!("{interpreter}: {error}")))?;
    Ok(match status.code() {
        Some(0) => Status::Done,
        Some(1) => Status::CheckFailed,
        Some(2) => Status::BadInput,
        _ => Status::Incomplete,
    })
}
