//! Exit statuses, and what is said when something is wrong: 2 for bad input, 3 for a run that breaks off.

use std::fs;
use std::io::Read;
use std::process::{Command, Stdio};

use crate::support::cli::{ANCHOR, directory, json, phalanx, stderr, stdout, variant, write};
use mcap::MessageStream;
use serde_json::Value;

/// Refused with status 2, nothing on stdout, and a message that says each of `parts`.
#[track_caller]
fn refused(args: &[&str], parts: &[&str]) {
    let output = phalanx(args);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {}", stderr(&output));
    assert_eq!(stdout(&output), "", "{args:?}");
    for part in parts {
        assert!(stderr(&output).contains(part), "no {part:?} in\n{}", stderr(&output));
    }
    assert!(stderr(&output).starts_with("error: "), "{}", stderr(&output));
}

#[test]
fn bad_arguments_are_refused() {
    refused(&["run"], &["<SCENE>"]);
    refused(&["run", ANCHOR, "--jason"], &["--jason", "--json"]);
    refused(&["run", ANCHOR, "--model", "magic"], &["magic", "analytic"]);
    for rtol in ["0", "2", "nan", "tight"] {
        refused(&["run", ANCHOR, "--rtol", rtol], &[rtol, "between 0 and 1"]);
    }
    for step in ["0 us", "-1 us", "1 mm", "1"] {
        refused(&["run", ANCHOR, "--model", "engine", &format!("--step={step}")], &["--step", step]);
    }
    refused(&["run", ANCHOR, "--model", "engine", "--step", "1 us", "--tolerance", "1 um"], &["--tolerance"]);
    refused(&["run", ANCHOR, "--duration", "30"], &["30", "no unit", "ms"]);
    refused(&["run", ANCHOR, "--duration", "30 mm"], &["30 mm"]);
    refused(&["run", ANCHOR, "--duration", "0 ms"], &["longer than 0"]);
    refused(&["run", ANCHOR, "--duration", "inf s"], &["finite"]);
}

#[test]
fn settings_of_the_model_that_does_not_run_are_refused() {
    for flag in [["--construction", "reduced"], ["--step", "1 us"], ["--tolerance", "1 um"]] {
        refused(&["run", ANCHOR, flag[0], flag[1]], &[flag[0], "analytic model runs", "--model engine"]);
    }
    for flag in [["--preset", "reference"], ["--rtol", "1e-3"]] {
        let args = ["run", ANCHOR, "--model", "engine", flag[0], flag[1]];
        refused(&args, &[flag[0], "engine model runs", "--model analytic"]);
    }
}

#[test]
fn bad_scenes_are_refused_with_the_place() {
    let directory = directory("cli_status_scenes");
    refused(&["run", "no/such/scene.toml", "--json"], &["no/such/scene.toml", "no such file"]);
    let scene = write(&directory, "unit.toml", "duration = \"20 mm\"\n");
    refused(&["run", &scene], &["unit.toml:1:12", "20 mm"]);
    let scene = write(&directory, "syntax.toml", "duration = \n");
    refused(&["run", &scene, "--json"], &["syntax.toml:1"]);
}

#[test]
fn logs_that_cannot_be_written_are_refused_before_the_run() {
    let directory = directory("cli_status_logs");
    let nowhere = directory.join("nowhere").join("run.mcap");
    refused(&["run", ANCHOR, "--log", nowhere.to_str().expect("text")], &["nowhere", "does not exist", "mkdir"]);
    refused(&["run", ANCHOR, "--log", directory.to_str().expect("text")], &["is a directory"]);
    let scene = variant(&directory, "mine.toml", "");
    let before = fs::read(&scene).expect("the scene");
    refused(&["run", &scene, "--log", &scene], &["the scene itself"]);
    assert_eq!(fs::read(&scene).expect("still there"), before);
}

#[test]
fn a_run_that_breaks_off_says_when_and_why_and_keeps_its_log() {
    let directory = directory("cli_status_budget");
    let scene = variant(&directory, "budget.toml", "[integrator]\nmax_steps = 40");
    let path = directory.join("run.mcap");
    let log = path.to_str().expect("text");
    let output = phalanx(&["run", &scene, "--json", "--log", log]);
    assert_eq!(output.status.code(), Some(3), "{}", stderr(&output));
    let message = stderr(&output);
    assert!(message.starts_with("error: the simulation stopped at "), "{message}");
    assert!(message.contains("of 20 ms") && message.contains("40") && message.contains(log), "{message}");

    let run = json(&output);
    assert_eq!(run["completed"], false);
    let time_s = run["error"]["time_s"].as_f64().expect("a time");
    assert!(time_s > 0.0 && time_s < 0.02);
    assert!(run["error"]["reason"].as_str().expect("a reason").contains("40"));
    assert_eq!(run["criteria"], Value::Null);
    assert_eq!(run["steps"], 40);

    let bytes = fs::read(&path).expect("a log");
    let messages: Vec<_> =
        MessageStream::new(&bytes).expect("readable").collect::<Result<_, _>>().expect("readable to the end");
    assert!(messages.iter().filter(|message| message.channel.topic == "/state").count() > 1);
    let last = messages.last().expect("not empty");
    assert_eq!(last.channel.topic, "/events");
    let text = String::from_utf8_lossy(&last.data);
    assert!(text.contains("stopped: ") && text.contains("40"), "{text}");

    let output = phalanx(&["run", &scene]);
    assert_eq!(output.status.code(), Some(3));
    assert!(stdout(&output).contains("NOT COMPLETED"));
    assert!(stderr(&output).contains("--log"), "the way to keep the run is said");
}

#[test]
fn help_teaches_with_an_example() {
    for args in [&["--help"][..], &["run", "--help"]] {
        let output = phalanx(args);
        assert_eq!(output.status.code(), Some(0));
        assert!(stdout(&output).contains("phalanx run scenes/experiment-95.toml"), "{}", stdout(&output));
        assert!(stdout(&output).contains("Exit status"));
    }
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    for extra in [&[][..], &["--json"]] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_phalanx"))
            .args(["run", ANCHOR])
            .args(extra)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary starts");
        drop(child.stdout.take());
        let mut message = String::new();
        child.stderr.take().expect("piped").read_to_string(&mut message).expect("text");
        assert_eq!(child.wait().expect("ends").code(), Some(0), "{message}");
        assert_eq!(message, "");
    }
}

#[cfg(unix)]
#[test]
fn results_for_a_standard_output_that_is_closed_are_lost_with_status_3() {
    for redirection in [">&-", "1</dev/null"] {
        let script = format!("exec \"$@\" {redirection}");
        let output =
            Command::new("sh").args(["-c", &script, "sh", env!("CARGO_BIN_EXE_phalanx"), "run", ANCHOR]).output();
        let output = output.expect("sh is there");
        assert_eq!(output.status.code(), Some(3), "{redirection}: {}", stderr(&output));
        assert!(stderr(&output).contains("cannot write to standard output"), "{}", stderr(&output));
    }
}

#[test]
fn the_scene_command_answers_with_the_same_statuses() {
    let output = phalanx(&["scene", "check", ANCHOR]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let schema = phalanx(&["scene", "schema"]);
    assert!(json(&schema).is_object());
    let scene = write(&directory("cli_status_scene"), "bad.toml", "duration = \"20 mm\"\n");
    assert_eq!(phalanx(&["scene", "check", &scene]).status.code(), Some(2));
}
