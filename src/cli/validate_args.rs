//! Arguments of `phalanx validate`.

use std::path::PathBuf;

use clap::Args;

use super::set::SetArgs;
use crate::trace::overrides::duration;
use crate::validate::{LADDER_TIME_S, LadderOptions};

/// Compare the engine with the analytic model and check the differences against the scene's bounds; --ladder compares
/// speed with error.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx validate scenes/experiment-95.toml\n  phalanx validate scenes/experiment-95.toml --out \
                  report\n  phalanx validate scenes/experiment-95.toml --ladder --json > validation.json\n\nThe section \
                  [validate] of a scene sets its bounds. Exit status: 0 within bounds; 1 out of bounds; 2 bad input; 3 a \
                  simulation could not be completed."
)]
pub struct ValidateArgs {
    /// Scene file (TOML); `phalanx scene schema` describes it
    pub(super) scene: PathBuf,

    #[command(flatten)]
    pub(super) set: SetArgs,

    /// Write reports, a page for a browser, time series of both models, plots and both logs to this directory, which is
    /// created if needed; an existing file is replaced only when the new one is complete
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    pub(super) json: bool,

    /// Also run a ladder of other settings of both models and compare their errors and times; included in --out
    #[arg(long)]
    pub(super) ladder: bool,

    /// Time limit of the ladder, such as "60 s"; settings that exceed it are omitted and listed [default: 10 s]
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub(super) ladder_time: Option<f64>,

    /// Omit slow settings from the ladder: fixed steps below 1e-5 s and reduced coordinates
    #[arg(long)]
    pub(super) quick: bool,
}

impl ValidateArgs {
    /// Returns the options of the ladder if it is requested.
    pub(super) fn ladder_options(&self) -> Option<LadderOptions> {
        let is_requested = self.ladder || self.ladder_time.is_some() || self.out.is_some();
        is_requested.then(|| LadderOptions { quick: self.quick, time_s: self.ladder_time.unwrap_or(LADDER_TIME_S) })
    }
}
