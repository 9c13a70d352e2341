//! Help outside the program: `phalanx schema` for editors, `phalanx completions`, shell completion scripts, and `phalanx man`, manual
//! pages.

use std::io;
use std::path::{Path, PathBuf};

use clap::{Args, Command, CommandFactory, ValueEnum};
use clap_complete::{Shell, generate};
use clap_mangen::Man;

use super::output::{print, reserve, save};
use super::{Cli, Failure, Status};
use crate::scene;
use crate::study::{optimisation, sweep};

/// Print the JSON Schema of scene files, study files or optimisations, for editors.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx schema scene > scene.schema.json\n  phalanx schema study > study.schema.json\n  phalanx schema \
                  optimize > optimize.schema.json"
)]
pub(crate) struct SchemaArgs {
    #[arg(value_enum)]
    file: SchemaFile,
}

/// A kind of file with a schema.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum SchemaFile {
    /// Scene files of every kind
    Scene,
    /// Study files of `phalanx sweep`
    Study,
    /// Study files of `phalanx optimize`
    Optimize,
}

pub(super) fn run_schema(args: &SchemaArgs) -> Result<Status, Failure> {
    print(&match args.file {
        SchemaFile::Scene => scene::schema(),
        SchemaFile::Study => sweep::schema(),
        SchemaFile::Optimize => optimisation::schema(),
    })
}

/// Print a shell completion script for commands, options and values.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx completions bash > ~/.local/share/bash-completion/completions/phalanx\n  phalanx \
                  completions zsh > ~/.zfunc/_phalanx\n  phalanx completions fish > \
                  ~/.config/fish/completions/phalanx.fish\n\nThe directory must exist. zsh searches ~/.zfunc if \
                  ~/.zshrc contains `fpath+=~/.zfunc` before `compinit`. Start a new shell to use the completions."
)]
pub(crate) struct CompletionsArgs {
    /// Shell to generate the script for
    shell: Shell,
}

pub(super) fn run_completions(args: &CompletionsArgs) -> Result<Status, Failure> {
    let mut command = Cli::command();
    let name = command.get_name().to_string();
    let mut script = Vec::new();
    generate(args.shell, &mut command, name, &mut script);
    print(&String::from_utf8_lossy(&script))
}

/// Print the manual page of phalanx, or write the pages of phalanx and all its commands to a directory.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx man | man -l -\n  phalanx man ~/.local/share/man/man1\n\nAfter the second command, `man \
                  phalanx-run` shows the page of `phalanx run`."
)]
pub(crate) struct ManArgs {
    /// Write phalanx.1, phalanx-run.1 and so on to this directory, which is created if needed; only pages written by
    /// phalanx are replaced
    dir: Option<PathBuf>,
}

pub(super) fn run_man(args: &ManArgs) -> Result<Status, Failure> {
    let pages = pages().map_err(|error| Failure::incomplete(format!("cannot write the pages: {error}")))?;
    let Some(dir) = &args.dir else {
        return print(pages.first().map_or("", |(_, page)| page));
    };
    let names: Vec<&str> = pages.iter().map(|(name, _)| name.as_str()).collect();
    let write = |out: &Path| pages.iter().try_for_each(|(name, page)| save(&out.join(name), page));
    let directory = reserve(&[], &[], (Some(dir), &names));
    directory.and_then(|directory| directory.write_with(write)).map_err(|Failure { message, status }| {
        // This command takes the directory as an argument and has no --out.
        Failure { message: message.replace("another --out", "another directory"), status }
    })?;
    print(&format!("wrote {} pages to {}\n", pages.len(), dir.display()))
}

/// Returns the file names and texts of the manual pages: the main command first, then its subcommands.
fn pages() -> io::Result<Vec<(String, String)>> {
    let mut command = Cli::command().disable_help_subcommand(true);
    // Completes the names of subcommands and propagates the global options.
    command.build();
    let mut pages = Vec::new();
    add_pages(&command, &mut pages)?;
    Ok(pages)
}

fn add_pages(command: &Command, pages: &mut Vec<(String, String)>) -> io::Result<()> {
    let name = command.get_display_name().unwrap_or_else(|| command.get_name()).to_string();
    let mut page = Vec::new();
    Man::new(command.clone()).render(&mut page)?;
    pages.push((format!("{name}.1"), String::from_utf8_lossy(&page).into_owned()));
    let mut subcommands = command.get_subcommands().filter(|subcommand| !subcommand.is_hide_set());
    subcommands.try_for_each(|subcommand| add_pages(subcommand, pages))
}
