//! Runs the binary and reads its output.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use serde_json::Value;

pub const EXPERIMENT_95: &str = "scenes/experiment-95.toml";

pub fn phalanx(args: &[&str]) -> Output {
    // Without COLUMNS, tables written to a pipe have no width limit.
    Command::new(env!("CARGO_BIN_EXE_phalanx")).env_remove("COLUMNS").args(args).output().expect("the binary starts")
}

pub fn stdout(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).expect("text")
}

pub fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).expect("text")
}

/// Asserts that a command is rejected soon, with status 2, an empty stdout, and a short error that contains each of
/// `parts`, whose words may be on several lines.
#[track_caller]
pub fn assert_rejected(args: &[&str], parts: &[&str]) {
    let start = Instant::now();
    let output = phalanx(args);
    let message = stderr(&output);
    assert_eq!((output.status.code(), stdout(&output)), (Some(2), ""), "{args:?}: {message}");
    let is_error = message.lines().any(|line| line.starts_with("error: "));
    assert!(is_error && message.len() < 20_000, "{args:?}: {message}");
    assert!(start.elapsed() < Duration::from_secs(10), "{args:?}: {:?}", start.elapsed());
    let unwrapped = message.replace('\n', " ");
    for part in parts {
        assert!(message.contains(part) || unwrapped.contains(part), "{args:?}: no {part:?} in {message}");
    }
}

/// Runs a command that succeeds and parses its JSON document.
#[track_caller]
pub fn run_json(args: &[&str]) -> Value {
    let text = succeed(args);
    serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error} in\n{text}"))
}

/// Parses stdout as one JSON document.
pub fn json(output: &Output) -> Value {
    serde_json::from_str(stdout(output)).unwrap_or_else(|error| panic!("{error} in\n{}", stdout(output)))
}

/// Creates an empty directory for one test.
pub fn directory(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).expect("a directory for the test");
    path
}

/// Writes the scene of experiment 95 with `more` appended; returns its path.
pub fn variant(directory: &Path, name: &str, more: &str) -> String {
    let text = fs::read_to_string(EXPERIMENT_95).expect("the scene of experiment 95");
    write(directory, name, &format!("{text}\n{more}\n"))
}

pub fn write(directory: &Path, name: &str, text: &str) -> String {
    let path = directory.join(name);
    fs::write(&path, text).expect("written");
    path.to_str().expect("a path of plain text").to_string()
}

/// Runs a command that must succeed; returns its standard output.
#[track_caller]
pub fn succeed(args: &[&str]) -> String {
    let output = phalanx(args);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", stderr(&output));
    stdout(&output).to_string()
}

/// Runs a command that must succeed with `--json`; returns its document.
#[track_caller]
pub fn succeed_json(args: &[&str]) -> Value {
    run_json(&[args, &["--json"]].concat())
}

/// Asserts that a text contains all parts.
#[track_caller]
pub fn assert_contains(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "no {part:?} in\n{text}");
    }
}
