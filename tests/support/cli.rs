//! Runs the binary and reads what it leaves.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

pub const ANCHOR: &str = "scenes/experiment-95.toml";

pub fn phalanx(args: &[&str]) -> Output {
    // Tables are as wide as need be in a pipe unless somebody says otherwise.
    Command::new(env!("CARGO_BIN_EXE_phalanx")).env_remove("COLUMNS").args(args).output().expect("the binary starts")
}

pub fn stdout(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).expect("text")
}

pub fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).expect("text")
}

/// The one document on stdout.
pub fn json(output: &Output) -> Value {
    serde_json::from_str(stdout(output)).unwrap_or_else(|error| panic!("{error} in\n{}", stdout(output)))
}

/// An empty directory for one test.
pub fn directory(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).expect("a directory for the test");
    path
}

/// The anchor scene with lines appended to it.
pub fn variant(directory: &Path, name: &str, more: &str) -> String {
    let text = fs::read_to_string(ANCHOR).expect("the anchor scene");
    write(directory, name, &format!("{text}\n{more}\n"))
}

pub fn write(directory: &Path, name: &str, text: &str) -> String {
    let path = directory.join(name);
    fs::write(&path, text).expect("written");
    path.to_str().expect("a path of plain text").to_string()
}
