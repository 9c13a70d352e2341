//! `phalanx new`: a scene file to begin with.

use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::PathBuf;

use clap::Args;

use super::output::print;
use super::{Failure, Status};

/// A gripper that grasps, with every choice that most grippers make said in a comment.
const SCENE: &str = include_str!("new.toml");

/// Write a commented scene file to begin your own gripper with; it runs as it is.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  phalanx new my-gripper.toml\n  phalanx run my-gripper.toml --open")]
pub struct NewArgs {
    /// The new file; one that is there already is left alone
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
}

/// Runs the command.
pub fn run(args: &NewArgs) -> Result<Status, Failure> {
    let path = args.file.display();
    let refused = |why: &str, way: &str| Failure::bad_input(format!("cannot write {path}: {why}; {way}"));
    // Made anew or not at all: whatever has the name already is somebody's work.
    let mut file =
        OpenOptions::new().write(true).create_new(true).open(&args.file).map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => {
                refused("there is something of that name already, and it is left as it is", "give another name")
            }
            _ => refused(&error.to_string(), "give a file in a directory where you may write"),
        })?;
    if let Err(error) = file.write_all(SCENE.as_bytes()).and_then(|()| file.sync_all()) {
        let _ = fs::remove_file(&args.file);
        return Err(Failure::incomplete(format!("cannot write {path}: {error}")));
    }
    print(&format!(
        "wrote {path}: a gripper of two phalanges, with comments\n\
         see it close:    phalanx run {path} --open        (or --html FILE.html)\n\
         see it all:      phalanx scene show {path}\n\
         see its letters: phalanx scene show {path} --figure FILE.svg\n"
    ))?;
    Ok(Status::Done)
}
