//! `phalanx completions`: shell completion scripts for commands, options and their values.

use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};

use super::output::print;
use super::{Cli, Failure, Status};

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

/// Runs `phalanx completions`.
pub fn run(args: &CompletionsArgs) -> Result<Status, Failure> {
    let mut command = Cli::command();
    let name = command.get_name().to_string();
    let mut script = Vec::new();
    generate(args.shell, &mut command, name, &mut script);
    print(&String::from_utf8_lossy(&script))?;
    Ok(Status::Done)
}
