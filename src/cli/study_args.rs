//! Arguments of the commands that run a study: `phalanx sweep` and `phalanx optimize`.

use clap::Args;

/// How a study is run and told of.
#[derive(Debug, Args)]
pub struct StudyArgs {
    /// Begin anew, whatever is there of earlier runs
    #[arg(long)]
    pub restart: bool,

    /// Show what would be run, and run nothing
    #[arg(long)]
    pub list: bool,

    /// Print the JSON Schema of these files, for editors
    #[arg(long, conflicts_with_all = ["study", "out", "list"])]
    pub schema: bool,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long, conflicts_with = "list")]
    pub json: bool,
}
