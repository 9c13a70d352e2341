//! What `phalanx validate` is asked.

use std::path::PathBuf;

use clap::Args;

use super::set::SetArgs;
use crate::trace::overrides::duration;
use crate::validate::{Climb, LADDER_TIME_S};

/// Compare the engine with the analytic model, and judge it by the scene's bounds; with a ladder, weigh speed against error.
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

    /// Write everything there: reports, a page to look at in a browser, series of both models, pictures, both logs; the
    /// directory is made if need be, and an older file is replaced only when the new one is whole
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long)]
    pub(super) json: bool,

    /// Compare and time other settings of both models as well: speed against error. --out has them too
    #[arg(long)]
    pub(super) ladder: bool,

    /// Time that the ladder may take, such as "60 s": settings beyond it are left out, and named [default: 10 s]
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub(super) ladder_time: Option<f64>,

    /// Leave settings that take long out of the ladder: fixed steps below 1e-5 s and reduced coordinates
    #[arg(long)]
    pub(super) quick: bool,
}

impl ValidateArgs {
    /// The ladder, where one is wanted.
    pub(super) fn climb(&self) -> Option<Climb> {
        let wanted = self.ladder || self.ladder_time.is_some() || self.out.is_some();
        wanted.then(|| Climb { quick: self.quick, time_s: self.ladder_time.unwrap_or(LADDER_TIME_S) })
    }
}
