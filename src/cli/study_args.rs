//! Arguments of `phalanx sweep` about its study and output.

use clap::Args;

/// Options for running a study and printing its results.
#[derive(Debug, Args)]
pub struct StudyArgs {
    /// Discard the results of earlier commands and start again
    #[arg(long)]
    pub restart: bool,

    /// List the planned runs without running them
    #[arg(long)]
    pub list: bool,

    /// Print the JSON Schema of study files, for editors
    #[arg(long, conflicts_with_all = ["study", "out", "list"])]
    pub schema: bool,

    /// Print one JSON document with SI units in its keys instead of tables
    #[arg(long, conflicts_with = "list")]
    pub json: bool,
}
