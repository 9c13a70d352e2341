//! `phalanx new`: writes a scene file as a starting point.

use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::PathBuf;

use clap::Args;

use super::output::print;
use super::{Failure, Status};
use crate::files::is_forced;

/// A working gripper scene; comments explain the choices that most grippers need.
const SCENE: &str = include_str!("new.toml");

/// Write a commented scene file as a starting point for your own gripper; it runs without changes.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phalanx new my-gripper.toml\n  phalanx run my-gripper.toml --open")]
pub(crate) struct NewArgs {
    /// File to write; an existing file is replaced only with --force
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
}

/// Runs `phalanx new`.
pub fn run(args: &NewArgs) -> Result<Status, Failure> {
    let path = args.file.display();
    let bad_input = |reason: &str, advice: &str| Failure::bad_input(format!("cannot write {path}: {reason}; {advice}"));
    let mut file =
        OpenOptions::new().write(true).create_new(!is_forced()).create(true).truncate(true).open(&args.file).map_err(
            |error| match error.kind() {
                ErrorKind::AlreadyExists => {
                    bad_input("a file or directory of that name already exists", "give another name")
                }
                _ => bad_input(&error.to_string(), "give a file in a directory where you may write"),
            },
        )?;
    if let Err(error) = file.write_all(SCENE.as_bytes()).and_then(|()| file.sync_all()) {
        let _ = fs::remove_file(&args.file);
        return Err(Failure::incomplete(format!("cannot write {path}: {error}")));
    }
    print(&format!(
        "wrote {path}: a commented scene of a gripper with two phalanges per finger\n\
         watch it close:     phalanx run {path} --open        (or --html FILE.html)\n\
         show all fields:    phalanx scene show {path}\n\
         draw its symbols:   phalanx scene show {path} --figure FILE.svg\n"
    ))?;
    Ok(Status::Done)
}
