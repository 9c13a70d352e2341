//! Runs the binary and reads its output.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
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
/// `parts`, whose words may be on several lines; returns the error.
#[track_caller]
pub fn assert_rejected(args: &[&str], parts: &[&str]) -> String {
    let start = Instant::now();
    let output = phalanx(args);
    let message = stderr(&output);
    assert_eq!((output.status.code(), stdout(&output)), (Some(2), ""), "{args:?}: {message}");
    let is_error = message.lines().any(|line| line.starts_with("error: "));
    assert!(is_error && message.len() < 20_000, "{args:?}: {message}");
    assert!(start.elapsed() < Duration::from_secs(10), "{args:?}: {:?}", start.elapsed());
    let unwrapped = message.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in parts {
        assert!(message.contains(part) || unwrapped.contains(part), "{args:?}: no {part:?} in {message}");
    }
    message.to_string()
}

/// Asserts the exit status of a command, and that its standard error contains each of `parts`.
#[track_caller]
pub fn assert_status(args: &[&str], status: i32, parts: &[&str]) -> Output {
    let output = phalanx(args);
    assert_eq!(output.status.code(), Some(status), "{args:?}: {}", stderr(&output));
    assert_contains(stderr(&output), parts);
    output
}

/// Starts a command with both output streams in pipes.
pub fn start(args: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_phalanx"));
    command.args(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary starts")
}

/// Sends a signal, such as `INT`, to a running command.
#[track_caller]
pub fn signal(child: &Child, name: &str) {
    let status = Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).status();
    assert!(status.expect("kill is installed").success(), "the command ended before the signal");
}

/// Path of a file in a directory, as an argument.
pub fn path_in(directory: &Path, name: &str) -> String {
    path_text(&directory.join(name)).to_string()
}

/// A path as an argument.
pub fn path_text(path: &Path) -> &str {
    path.to_str().expect("a path of plain text")
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
    path_text(&write_bytes(directory, name, text.as_bytes())).to_string()
}

/// Writes a file; returns its path.
pub fn write_bytes(directory: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = directory.join(name);
    fs::write(&path, bytes).expect("written");
    path
}

/// Runs a command that must succeed; returns its standard output.
#[track_caller]
pub fn succeed(args: &[&str]) -> String {
    stdout(&assert_status(args, 0, &[])).to_string()
}

/// Runs a command that must succeed without a message on standard error; returns its standard output.
#[track_caller]
pub fn succeed_silently(args: &[&str]) -> String {
    let output = assert_status(args, 0, &[]);
    assert_eq!(stderr(&output), "", "{args:?}");
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
