//! The command line: reads arguments, prints text or JSON, and returns an exit status.
//!
//! | status | meaning |
//! |---|---|
//! | 0 | done |
//! | 1 | ran, but a check failed: a bound is exceeded, or a part of a log is lost |
//! | 2 | bad input: arguments, scene, or a path that cannot be written |
//! | 3 | the simulation could not be completed, was interrupted, or its results could not be written; the log up to that time is kept and readable |

mod grippers;
mod help;
mod optimize;
mod output;
mod page;
mod parsers;
#[cfg(feature = "png")]
mod png;
mod progress;
mod replay;
mod replay_against;
mod replay_read;
mod run;
mod scene;
mod select;
mod set;
mod simulate;
mod statics;
mod sweep;
mod thesis;
mod validate;
mod volume;

use std::any::TypeId;
use std::fmt::Display;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;

use clap::builder::Styles;
use clap::builder::styling::AnsiColor;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, CommandFactory, FromArgMatches, Parser, Subcommand};

use self::parsers::parse_threads;
use crate::files::FORCE;
use crate::scene::error::shortened;
use crate::scene::{SceneError, closest_match};
use phalanx_parallel::set_threads;

/// Maximum width of help text in columns; longer lines are hard to read.
const MAX_HELP_WIDTH: usize = 100;

/// Styles of help and messages. clap applies them only on a terminal and only if NO_COLOR is not set.
const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default());

/// Output of `--version`; a release names the commit that it was built from.
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
    max_term_width = MAX_HELP_WIDTH,
    styles = STYLES,
    after_help = "Examples:\n  phalanx new my-gripper.toml\n  phalanx run my-gripper.toml --open\n  phalanx run scenes/experiment-95.toml --log run.mcap\n\nExit \
                  status: 0 done; 1 a check failed; 2 bad input; 3 the simulation could not be completed.\n\nTables and help \
                  are wrapped to the width of the terminal. COLUMNS sets another width, also for pipes, where tables are not \
                  wrapped by default. NO_COLOR disables the colours of help and messages.\n\nThe thesis that help and reports cite is \"Dynamic grasping of objects with a high-speed parallel robot\" (master's thesis)."
)]
struct Cli {
    /// Print results, warnings and errors only; no progress and no notes on stderr
    #[arg(short, long, global = true, display_order = 900)]
    quiet: bool,

    /// Replace existing output files even if phalanx did not write them; inputs are never replaced
    #[arg(long, global = true, display_order = 901)]
    force: bool,

    /// Number of threads [default: RAYON_NUM_THREADS, else all cores]; results do not depend on it
    #[arg(long, global = true, value_name = "N", default_value_t = 0, hide_default_value = true, value_parser = parse_threads, display_order = 899)]
    threads: usize,

    #[command(subcommand)]
    command: Command,
}

/// Defines the `Command` enum and its dispatch: each line names a command, its arguments and the function that runs it.
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
    New(scene::NewArgs) => scene::run_new,
    Run(run::RunArgs) => run::run,
    Validate(validate::ValidateArgs) => validate::run,
    Replay(replay_read::ReplayArgs) => replay::run,
    /// Show and check scene files, and export them for MuJoCo
    #[command(
        subcommand,
        after_help = "Examples:\n  phalanx scene show my-gripper.toml\n  phalanx scene check scenes/*.toml"
    )]
    Scene(scene::SceneCommand) => scene::run,
    Statics(statics::StaticsArgs) => statics::run_statics,
    Hold(grippers::HoldArgs) => grippers::run_hold,
    Capture(grippers::CaptureArgs) => grippers::run_capture,
    Sweep(sweep::SweepArgs) => sweep::run,
    Optimize(optimize::OptimizeArgs) => optimize::run,
    Explore(page::ExploreArgs) => page::explore,
    Size(statics::SizeArgs) => statics::run_size,
    /// Reproduce the thesis: its figures, the volumes of its designs, and how step size and stiffness affect the engine
    #[command(
        subcommand,
        after_help = "Examples:\n  phalanx thesis reproduce\n  phalanx thesis volume --out volumes\n  phalanx thesis select \
                      results.csv\n  phalanx thesis stability scenes/experiment-95.toml"
    )]
    Thesis(thesis::ThesisCommand) => thesis::run,
    Schema(help::SchemaArgs) => help::run_schema,
    #[command(hide = true)]
    Completions(help::CompletionsArgs) => help::run_completions,
    #[command(hide = true)]
    Man(help::ManArgs) => help::run_man,
}

/// Exit status of a command; see the [module](self) documentation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    Done = 0,
    CheckFailed = 1,
    BadInput = 2,
    Incomplete = 3,
}

/// Failure of a command: the message for stderr and the exit status.
#[derive(Debug)]
pub struct Failure {
    pub message: String,
    pub status: Status,
}

impl Failure {
    /// Failure caused by invalid arguments, or an invalid scene or path.
    pub(crate) fn bad_input(message: impl Display) -> Self {
        Failure { message: format!("error: {message}"), status: Status::BadInput }
    }

    /// Creates the failure of a run that was not completed, or whose results could not be written.
    pub fn incomplete(message: impl Display) -> Self {
        Failure { message: format!("error: {message}"), status: Status::Incomplete }
    }
}

impl From<SceneError> for Failure {
    /// The message of a scene error shows the position in the file and already begins with `error:`.
    fn from(error: SceneError) -> Self {
        Failure { message: error.to_string(), status: Status::BadInput }
    }
}

/// Runs the command given by the command-line arguments of the process.
pub fn main() -> ExitCode {
    progress::fail_writes_beyond_file_limit();
    let matches = build_command().try_get_matches().unwrap_or_else(|error| exit_with_error(suggest(error)));
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| exit_with_error(error));
    output::QUIET.store(cli.quiet, Ordering::Relaxed);
    FORCE.store(cli.force, Ordering::Relaxed);
    set_threads(cli.threads);
    let status = cli.command.run().unwrap_or_else(|failure| {
        output::print_diagnostic(&failure.message);
        failure.status
    });
    ExitCode::from(status as u8)
}

/// Prints an error of the arguments and exits. Very long messages are shortened.
fn exit_with_error(error: clap::Error) -> ! {
    let text = error.render().to_string();
    if error.use_stderr() && shortened(&text) != text {
        output::print_diagnostic(text.trim_end());
        std::process::exit(error.exit_code());
    }
    error.exit()
}

/// Builds the command line parser. Help is as wide as the terminal, or as COLUMNS requests.
fn build_command() -> clap::Command {
    let command = allow_negative_values(Cli::command());
    match output::terminal_width() {
        Some(width) => command.term_width(width.min(MAX_HELP_WIDTH)),
        None => command,
    }
}

/// Lets flags accept values that begin with a minus: the flag's own parser gives the best message for `--rtol -1`.
/// Flags that take a file or one of several listed values still reject anything that looks like another flag.
fn allow_negative_values(command: clap::Command) -> clap::Command {
    let accepts_negatives = |arg: &Arg| {
        let is_free_text =
            arg.get_value_parser().type_id() != TypeId::of::<PathBuf>() && arg.get_possible_values().is_empty();
        let takes_value =
            arg.get_action().takes_values() && arg.get_num_args().is_none_or(|count| count.min_values() == 1);
        arg.get_long().is_some() && is_free_text && takes_value
    };
    let command = command.mut_args(|arg| if accepts_negatives(&arg) { arg.allow_hyphen_values(true) } else { arg });
    command.mut_subcommands(allow_negative_values)
}

/// Former names of commands and flags, with their present ones.
const FORMER_NAMES: [(&str, &str); 11] = [
    ("reproduce", "phalanx thesis reproduce"),
    ("volume", "phalanx thesis volume"),
    ("select", "phalanx thesis select"),
    ("study", "phalanx thesis"),
    ("schema", "phalanx schema scene"),
    ("--schema", "phalanx schema study"),
    ("--html", "--plot FILE.html"),
    ("--svg", "--plot FILE.svg"),
    ("--figure", "--plot FILE.svg"),
    ("--live", "--log FILE.mcap"),
    ("--color-by", "--colour-by"),
];

/// Names the present name of a former one, and suggests a command for a mistyped one of two letters, for which clap makes no
/// suggestion.
fn suggest(mut error: clap::Error) -> clap::Error {
    let former = [ContextKind::InvalidSubcommand, ContextKind::InvalidArg].into_iter().find_map(|kind| {
        let Some(ContextValue::String(word)) = error.get(kind) else { return None };
        FORMER_NAMES.into_iter().find(|(former, _)| word.split([' ', '=']).next() == Some(former))
    });
    if let Some((_, present)) = former
        && matches!(error.kind(), ErrorKind::InvalidSubcommand | ErrorKind::UnknownArgument)
    {
        [ContextKind::SuggestedSubcommand, ContextKind::SuggestedArg]
            .into_iter()
            .for_each(|kind| _ = error.remove(kind));
        let tip = format!("it is now `{present}`");
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
        return error;
    }
    if let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand)
        && error.get(ContextKind::SuggestedSubcommand).is_none()
    {
        let command = Cli::command();
        // In `phalanx scene shwo`, the second word is the mistyped one.
        let parent_name = std::env::args().skip(1).find(|arg| !arg.starts_with('-')).filter(|first| first != word);
        let parent = parent_name.and_then(|first| command.find_subcommand(first)).unwrap_or(&command);
        let names: Vec<&str> = parent.get_subcommands().map(clap::Command::get_name).collect();
        if let Some(name) = closest_match(word, &names) {
            let name = ContextValue::Strings(vec![name.to_string()]);
            error.insert(ContextKind::SuggestedSubcommand, name);
        }
    }
    error
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    #[test]
    fn command_line_is_valid() {
        allow_negative_values(Cli::command()).debug_assert();
    }

    /// Pages with commands: the README, and those of the directories.
    fn pages() -> Vec<(PathBuf, String)> {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let of_directory = |directory: &str| fs::read_dir(root.join(directory)).expect("a directory").flatten();
        let files =
            ["src/docs", "book/pages", "tools/viewers"].into_iter().flat_map(of_directory).map(|entry| entry.path());
        let files = files.chain(["README.md", "CONTRIBUTING.md", "python/README.md"].map(|name| root.join(name)));
        let pages = files.filter(|file| file.extension().is_some_and(|extension| extension == "md"));
        pages.map(|file| (file.clone(), fs::read_to_string(file).expect("a page"))).collect()
    }

    /// Splits a line of a shell into words, up to a comment, a pipe or a redirection.
    fn words(line: &str) -> Vec<String> {
        let (mut words, mut word, mut quote, mut is_word) = (Vec::new(), String::new(), None, false);
        for c in line.chars().chain([' ']) {
            match (quote, c) {
                (Some(open), _) if c == open => quote = None,
                (None, '"' | '\'') => (quote, is_word) = (Some(c), true),
                (None, '#' | '|' | '>' | ';' | '&') if !is_word => break,
                (None, ' ') if is_word => (words.push(std::mem::take(&mut word)), is_word = false).1,
                (None, ' ') => {}
                _ => (word.push(c), is_word = true).1,
            }
        }
        words
    }

    /// Commands in code blocks parse, and name shipped files that exist.
    #[test]
    fn commands_of_the_documents_are_valid() {
        let mut count = 0;
        for (file, text) in pages() {
            let mut is_code = false;
            for line in text.lines() {
                is_code = if line.starts_with("```") { !is_code } else { is_code };
                let line = line.trim_start_matches("$ ");
                let line = line
                    .strip_prefix("cargo run --release -- ")
                    .map_or_else(|| line.to_string(), |rest| format!("phalanx {rest}"));
                if !is_code || !line.starts_with("phalanx ") {
                    continue;
                }
                count += 1;
                let words = words(&line);
                let parsed = allow_negative_values(Cli::command()).try_get_matches_from(&words);
                let is_help = |error: &clap::Error| !error.use_stderr();
                assert!(
                    parsed.as_ref().is_ok_and(|_| true) || parsed.as_ref().is_err_and(is_help),
                    "{}: {line}: {parsed:?}",
                    file.display()
                );
                let mut shipped = words.iter().filter(|word| word.starts_with("scenes/") && !word.contains(['*', ':']));
                let missing = shipped.find(|path| !Path::new(env!("CARGO_MANIFEST_DIR")).join(path).exists());
                assert_eq!(missing, None, "{}: {line}", file.display());
            }
        }
        assert!(count >= 70, "{count} commands");
    }

    /// Commands within sentences exist, with their flags.
    #[test]
    fn commands_in_sentences_exist() {
        let command = Cli::command();
        let mut count = 0;
        for (file, text) in pages() {
            for code in
                text.split('`').skip(1).step_by(2).filter(|code| code.starts_with("phalanx ") && !code.contains('\n'))
            {
                let mut found = &command;
                let mut flags = Vec::new();
                for word in words(code).iter().skip(1) {
                    match found.find_subcommand(word) {
                        Some(inner) => found = inner,
                        None if word.starts_with("--") => {
                            flags.push(word.split('=').next().unwrap_or_default().to_string())
                        }
                        None => {}
                    }
                }
                let second = words(code).get(1).cloned().unwrap_or_default();
                let is_command = found.get_name() != "phalanx" || second.starts_with('-') || second == "help";
                assert!(is_command, "{}: no command in `{code}`", file.display());
                let names: Vec<String> = [&command, found]
                    .into_iter()
                    .flat_map(|each| each.get_arguments())
                    .filter_map(|arg| Some(format!("--{}", arg.get_long()?)))
                    .collect();
                let unknown =
                    flags.iter().find(|flag| !names.contains(flag) && *flag != "--help" && *flag != "--version");
                assert_eq!(unknown, None, "{}: `{code}`", file.display());
                count += 1;
            }
        }
        assert!(count > 60, "{count} commands");
    }
}
