//! What `phalanx validate` is asked.

use std::path::PathBuf;

use clap::Args;

use super::set::SetArgs;

/// Compare the engine with the analytic model, judge it by the scene's bounds, and weigh speed against error.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx validate scenes/experiment-95.toml\n  phalanx validate scenes/experiment-95.toml --out \
                  report\n  phalanx validate scenes/experiment-95.toml --quick --json > validation.json\n\nThe section \
                  [validate] of a scene sets its bounds. Exit status: 0 within bounds; 1 out of bounds; 2 bad input; 3 a \
                  simulation could not be completed."
)]
pub struct ValidateArgs {
    /// Scene file (TOML); `phalanx scene schema` describes it
    pub(super) scene: PathBuf,

    #[command(flatten)]
    pub(super) set: SetArgs,

    /// Write everything there: reports, a page to look at in a browser, series of both models, pictures, both logs; the
    /// directory is made if need be, and an older file is replaced only when the new one is whole
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    pub(super) json: bool,

    /// Leave out the settings that take long: fixed steps below 1e-5 s and reduced coordinates
    #[arg(long)]
    pub(super) quick: bool,
}
