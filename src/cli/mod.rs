//! The command line: arguments in, text or JSON out, an exit status.
//!
//! | status | meaning |
//! |---|---|
//! | 0 | done |
//! | 1 | ran, but a check failed: a bound does not hold, or a part of a log is lost |
//! | 2 | bad input: arguments, scene, or a path that cannot be written |
//! | 3 | the simulation could not be completed, or was interrupted, or its results could not be written; the log up to there is kept and readable |

mod answer;
mod browser;
mod capture;
mod completions;
mod explore;
mod folder;
mod hold;
mod interrupt;
#[cfg_attr(not(feature = "live"), path = "no_live.rs")]
mod live;
mod man;
mod new;
/// What a build without the feature says is tested in every build.
#[cfg(all(test, feature = "live"))]
#[allow(dead_code)]
mod no_live;
mod optimize;
mod output;
mod overrides;
mod own;
mod progress;
mod replay;
mod replay_against;
mod replay_args;
mod replay_page;
mod replay_pair;
mod replay_read;
mod replay_recover;
mod replay_side;
mod replay_verify;
mod reproduce;
mod run;
mod run_page;
mod samples;
mod saved;
pub mod scene;
mod scene_figure;
mod select;
pub mod set;
mod simulate;
mod size;
mod statics;
mod statics_gripper;
mod study;
mod study_args;
mod study_stability;
mod sweep;
mod sweep_merge;
mod sweep_progress;
mod sweep_shard;
mod targets;
mod terminal;
mod validate;
mod validate_args;
mod validate_files;
mod volume;
mod volume_args;
mod volume_files;
mod watch;
mod words;

use std::any::TypeId;
use std::fmt::Display;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::builder::Styles;
use clap::builder::styling::AnsiColor;
use clap::error::{ContextKind, ContextValue};
use clap::{Arg, CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::scene::error::shortened;
use crate::scene::{SceneError, nearest};

/// Help of longer lines is tiring to read.
const WIDEST: usize = 100;

/// Only where colours are wanted: on a terminal, and not if NO_COLOR is set.
const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default());

/// What `--version` says: a release names the commit that it was built from.
const VERSION: &str = match option_env!("PHALANX_VERSION") {
    Some(version) => version,
    None => env!("CARGO_PKG_VERSION"),
};

/// Simulates planar, high-speed underactuated grippers: stiff contact with exact events.
#[derive(Debug, Parser)]
#[command(
    name = "phalanx",
    version,
    long_version = VERSION,
    propagate_version = true,
    max_term_width = WIDEST,
    styles = STYLES,
    after_help = "Examples:\n  phalanx new my-gripper.toml\n  phalanx run my-gripper.toml --open\n  phalanx run scenes/experiment-95.toml --log run.mcap\n\nExit \
                  status: 0 done; 1 a check failed; 2 bad input; 3 the simulation could not be completed.\n\nTables and help \
                  fit the terminal; COLUMNS sets another width, also in a pipe, where tables are as wide as need be \
                  otherwise. NO_COLOR takes the colours from help and messages.\n\nThe thesis that help and reports cite is \"Dynamic grasping of objects with a high-speed parallel robot\" (master's thesis)."
)]
struct Cli {
    /// Print results, warnings and errors only: no progress and no notes on stderr
    #[arg(short, long, global = true, display_order = 900)]
    quiet: bool,

    #[command(subcommand)]
    command: Command,
}

/// Makes of one line for each command its word on the command line and the way to what runs it.
macro_rules! commands {
    ($($(#[$attribute:meta])* $name:ident($arguments:ty) => $run:path,)*) => {
        #[derive(Debug, Subcommand)]
        enum Command {
            $($(#[$attribute])* $name($arguments),)*
        }

        impl Command {
            fn run(&self) -> Result<Status, Failure> {
                match self {
                    $(Command::$name(arguments) => $run(arguments),)*
                }
            }
        }
    };
}

commands! {
    New(new::NewArgs) => new::run,
    Run(run::RunArgs) => run::run,
    Explore(explore::ExploreArgs) => explore::run,
    Validate(validate_args::ValidateArgs) => validate::run,
    Replay(replay_args::ReplayArgs) => replay::run,
    /// Show and check scene files, and print their schema
    #[command(
        subcommand,
        after_help = "Examples:\n  phalanx scene show my-gripper.toml\n  phalanx scene check scenes/*.toml\n  phalanx scene \
                      schema > scene.schema.json"
    )]
    Scene(scene::SceneCommand) => scene::run,
    Capture(capture::CaptureArgs) => capture::run,
    Hold(hold::HoldArgs) => hold::run,
    Size(size::SizeArgs) => size::run,
    Statics(statics::StaticsArgs) => statics::run,
    Volume(volume::VolumeArgs) => volume::run,
    Sweep(sweep::SweepArgs) => sweep::run,
    Select(select::SelectArgs) => select::run,
    Optimize(optimize::OptimizeArgs) => optimize::run,
    Reproduce(reproduce::ReproduceArgs) => reproduce::run,
    /// See what a choice of settings does to a result
    #[command(
        subcommand,
        after_help = "Examples:\n  phalanx study stability scenes/experiment-95.toml\n  phalanx study step-size --quick"
    )]
    Study(study::StudyCommand) => study::run,
    Completions(completions::CompletionsArgs) => completions::run,
    Man(man::ManArgs) => man::run,
}

/// How a command ended, see the [module](self).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    Done = 0,
    CheckFailed = 1,
    BadInput = 2,
    Incomplete = 3,
}

/// Why a command did not do what it was asked: what to print on stderr, and the exit status.
#[derive(Debug)]
pub struct Failure {
    pub message: String,
    pub status: Status,
}

impl Failure {
    /// Something the user gave is wrong.
    pub fn bad_input(message: impl Display) -> Self {
        Failure { message: format!("error: {message}"), status: Status::BadInput }
    }

    /// A run, or the writing of its results, broke off.
    pub fn incomplete(message: impl Display) -> Self {
        Failure { message: format!("error: {message}"), status: Status::Incomplete }
    }
}

impl From<SceneError> for Failure {
    /// The scene's message shows the place in the file, and begins with `error:` itself.
    fn from(error: SceneError) -> Self {
        Failure { message: error.to_string(), status: Status::BadInput }
    }
}

/// Runs the command that the process was started with.
pub fn main() -> ExitCode {
    interrupt::survive_file_limits();
    let matches = command_line().try_get_matches().unwrap_or_else(|error| refuse(meant(error)));
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| refuse(error));
    if cli.quiet {
        output::be_quiet();
    }
    let status = cli.command.run().unwrap_or_else(|failure| {
        output::complain(&failure.message);
        failure.status
    });
    ExitCode::from(status as u8)
}

/// Ends with what is wrong with the arguments, which may be longer than anybody reads.
fn refuse(error: clap::Error) -> ! {
    let text = error.render().to_string();
    if error.use_stderr() && shortened(&text) != text {
        output::complain(text.trim_end());
        std::process::exit(error.exit_code());
    }
    error.exit()
}

/// The command line as it is read: help is as wide as the terminal, or as COLUMNS says.
fn command_line() -> clap::Command {
    let command = taking_negatives(Cli::command());
    match terminal::width() {
        Some(width) => command.term_width(width.min(WIDEST)),
        None => command,
    }
}

/// Lets every flag of a value take one that begins with a minus: what is wrong with `--rtol -1` the flag itself says best.
/// Flags of files and of words from a list go on refusing what looks like another flag.
fn taking_negatives(command: clap::Command) -> clap::Command {
    let takes = |arg: &Arg| {
        let free = arg.get_value_parser().type_id() != TypeId::of::<PathBuf>() && arg.get_possible_values().is_empty();
        let one = arg.get_action().takes_values() && arg.get_num_args().is_none_or(|count| count.min_values() == 1);
        arg.get_long().is_some() && free && one
    };
    let command = command.mut_args(|arg| if takes(&arg) { arg.allow_hyphen_values(true) } else { arg });
    command.mut_subcommands(taking_negatives)
}

/// Suggests a command for a mistyped one where clap does not: it compares words of two letters with nothing.
fn meant(mut error: clap::Error) -> clap::Error {
    if let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand)
        && error.get(ContextKind::SuggestedSubcommand).is_none()
    {
        let command = Cli::command();
        // Of `phalanx scene shwo` the second word is wrong.
        let above = std::env::args().skip(1).find(|arg| !arg.starts_with('-')).filter(|first| first != word);
        let among = above.and_then(|first| command.find_subcommand(first)).unwrap_or(&command);
        let names: Vec<&str> = among.get_subcommands().map(clap::Command::get_name).collect();
        if let Some(name) = nearest(word, &names) {
            let name = ContextValue::Strings(vec![name.to_string()]);
            error.insert(ContextKind::SuggestedSubcommand, name);
        }
    }
    error
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_sound() {
        taking_negatives(Cli::command()).debug_assert();
    }
}
