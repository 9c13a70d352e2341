//! `phalanx man`: manual pages.

use std::io;
use std::path::PathBuf;

use clap::{Args, Command, CommandFactory};
use clap_mangen::Man;

use super::output::print;
use super::targets::reserve;
use super::{Cli, Failure, Status};

/// Print the manual page of phalanx, or write one for it and for each of its commands.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  phalanx man | man -l -\n  phalanx man ~/.local/share/man/man1\n\nAfter the second, `man \
                  phalanx-run` shows the page of `phalanx run`."
)]
pub struct ManArgs {
    /// Write phalanx.1, phalanx-run.1 and so on there; the directory is made if need be, and only pages that were written by
    /// phalanx are replaced
    dir: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &ManArgs) -> Result<Status, Failure> {
    let pages =
        pages(Cli::command()).map_err(|error| Failure::incomplete(format!("cannot write the pages: {error}")))?;
    let Some(dir) = &args.dir else {
        print(pages.first().map_or("", |(_, page)| page))?;
        return Ok(Status::Done);
    };
    let (names, texts): (Vec<&str>, Vec<String>) =
        pages.iter().map(|(name, page)| (name.as_str(), page.clone())).unzip();
    // The directory is no --out here.
    let folder = reserve(&[], &[], ("", Some(dir), &names));
    folder.and_then(|folder| folder.map_or(Ok(()), |folder| folder.write(&names, &texts))).map_err(
        |Failure { message, status }| Failure {
            message: message.replace("another --out", "another directory"),
            status,
        },
    )?;
    print(&format!("wrote {} pages to {}\n", names.len(), dir.display()))?;
    Ok(Status::Done)
}

/// Names of files and their texts: the whole command first, then all below it.
fn pages(command: Command) -> io::Result<Vec<(String, String)>> {
    let mut command = command.disable_help_subcommand(true);
    // Names in full, and options that every command takes.
    command.build();
    let mut pages = Vec::new();
    add(&command, &mut pages)?;
    Ok(pages)
}

fn add(command: &Command, pages: &mut Vec<(String, String)>) -> io::Result<()> {
    let name = command.get_display_name().unwrap_or_else(|| command.get_name()).to_string();
    let mut page = Vec::new();
    Man::new(command.clone()).render(&mut page)?;
    pages.push((format!("{name}.1"), String::from_utf8_lossy(&page).into_owned()));
    command.get_subcommands().filter(|below| !below.is_hide_set()).try_for_each(|below| add(below, pages))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_page() {
        let pages = pages(Cli::command()).expect("pages");
        let names: Vec<&str> = pages.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names.first(), Some(&"phalanx.1"));
        for name in ["phalanx-run.1", "phalanx-scene.1", "phalanx-scene-show.1", "phalanx-study-stability.1"] {
            assert!(names.contains(&name), "{names:?}");
        }
    }
}
