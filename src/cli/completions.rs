//! `phalanx completions`: what a shell needs to complete commands, options and their values.

use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};

use super::output::print;
use super::{Cli, Failure, Status};

/// Print the completions of a shell: commands, options and values after pressing Tab.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx completions bash > ~/.local/share/bash-completion/completions/phalanx\n  phalanx \
                  completions zsh > ~/.zfunc/_phalanx\n  phalanx completions fish > \
                  ~/.config/fish/completions/phalanx.fish\n\nThe directory has to be there. zsh looks in ~/.zfunc if \
                  ~/.zshrc has `fpath+=~/.zfunc` before `compinit`. A new shell knows them."
)]
pub struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Runs the command.
pub fn run(args: &CompletionsArgs) -> Result<Status, Failure> {
    let mut command = Cli::command();
    let name = command.get_name().to_string();
    let mut script = Vec::new();
    generate(args.shell, &mut command, name, &mut script);
    print(&String::from_utf8_lossy(&script))?;
    Ok(Status::Done)
}
