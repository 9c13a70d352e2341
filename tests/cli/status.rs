//! Exit statuses and error messages: 2 for bad input, 3 for an incomplete run.

use std::fs;
use std::io::Read;
use std::process::Command;

use crate::support::cli::{
    EXPERIMENT_95, assert_contains, assert_rejected, assert_status, directory, json, path_in, path_text, run_json,
    start, stderr, stdout, succeed, variant, write,
};
use mcap::MessageStream;
use serde_json::Value;

#[test]
fn bad_arguments_are_rejected() {
    assert_rejected(&["run"], &["<SCENE>"]);
    assert_rejected(&["run", EXPERIMENT_95, "--jason"], &["--jason", "--json"]);
    assert_rejected(&["run", EXPERIMENT_95, "--model", "magic"], &["magic", "analytic"]);
    for rtol in ["0", "2", "nan", "tight"] {
        assert_rejected(&["run", EXPERIMENT_95, "--rtol", rtol], &[rtol, "between 0 and 1"]);
    }
    for step in ["0 us", "-1 us", "1 mm", "1"] {
        assert_rejected(&["run", EXPERIMENT_95, "--model", "engine", &format!("--step={step}")], &["--step", step]);
    }
    assert_rejected(
        &["run", EXPERIMENT_95, "--model", "engine", "--step", "1 us", "--tolerance", "1 um"],
        &["--tolerance"],
    );
    assert_rejected(&["run", EXPERIMENT_95, "--duration", "30"], &["30", "no unit", "ms"]);
    assert_rejected(&["run", EXPERIMENT_95, "--duration", "30 mm"], &["30 mm"]);
    assert_rejected(&["run", EXPERIMENT_95, "--duration", "0 ms"], &["longer than 0"]);
    assert_rejected(&["run", EXPERIMENT_95, "--duration", "inf s"], &["finite"]);
}

#[test]
fn settings_of_the_other_model_are_rejected() {
    for flag in [["--construction", "reduced"], ["--step", "1 us"], ["--tolerance", "1 um"]] {
        assert_rejected(&["run", EXPERIMENT_95, flag[0], flag[1]], &[flag[0], "analytic model runs", "--model engine"]);
    }
    for flag in [["--preset", "reference"], ["--rtol", "1e-3"]] {
        let args = ["run", EXPERIMENT_95, "--model", "engine", flag[0], flag[1]];
        assert_rejected(&args, &[flag[0], "engine model runs", "--model analytic"]);
    }
}

#[test]
fn bad_scenes_are_rejected_with_their_position() {
    let directory = directory("cli_status_scenes");
    assert_rejected(&["run", "no/such/scene.toml", "--json"], &["no/such/scene.toml", "no such file"]);
    let scene = write(&directory, "unit.toml", "duration = \"20 mm\"\n");
    assert_rejected(&["run", &scene], &["unit.toml:1:12", "20 mm"]);
    let scene = write(&directory, "syntax.toml", "duration = \n");
    assert_rejected(&["run", &scene, "--json"], &["syntax.toml:1"]);
}

#[test]
fn unwritable_logs_are_rejected_before_the_run() {
    let directory = directory("cli_status_logs");
    let missing = path_in(&directory, "nowhere/run.mcap");
    assert_rejected(&["run", EXPERIMENT_95, "--log", &missing], &["nowhere", "does not exist", "mkdir"]);
    assert_rejected(&["run", EXPERIMENT_95, "--log", path_text(&directory)], &["is a directory"]);
    let scene = variant(&directory, "mine.toml", "");
    let before = fs::read(&scene).expect("the scene");
    assert_rejected(&["run", &scene, "--log", &scene], &["the scene itself"]);
    assert_eq!(fs::read(&scene).expect("readable"), before);
}

#[test]
fn incomplete_run_reports_time_and_reason_and_keeps_its_log() {
    let directory = directory("cli_status_budget");
    let scene = variant(&directory, "budget.toml", "[integrator]\nmax_steps = 40");
    let log = &path_in(&directory, "run.mcap");
    let output = assert_status(&["run", &scene, "--json", "--log", log], 3, &["of 20 ms", "40", log]);
    assert!(stderr(&output).starts_with("error: the simulation stopped at "), "{}", stderr(&output));

    let run = json(&output);
    assert_eq!(run["completed"], false);
    let time_s = run["error"]["time_s"].as_f64().expect("a time");
    assert!(time_s > 0.0 && time_s < 0.02);
    assert!(run["error"]["reason"].as_str().expect("a reason").contains("40"));
    assert_eq!(run["criteria"], Value::Null);
    assert_eq!(run["steps"], 40);

    let bytes = fs::read(log).expect("a log");
    let messages: Vec<_> =
        MessageStream::new(&bytes).expect("readable").collect::<Result<_, _>>().expect("readable to the end");
    assert!(messages.iter().filter(|message| message.channel.topic == "/state").count() > 1);
    let last = messages.last().expect("not empty");
    assert_eq!(last.channel.topic, "/events");
    let text = String::from_utf8_lossy(&last.data);
    assert!(text.contains("stopped: ") && text.contains("40"), "{text}");

    // The message suggests --log.
    let output = assert_status(&["run", &scene], 3, &["--log"]);
    assert!(stdout(&output).contains("NOT COMPLETED"));
}

#[test]
fn help_contains_an_example() {
    for args in [&["--help"][..], &["run", "--help"]] {
        let output = succeed(args);
        assert_contains(&output, &["phalanx run scenes/experiment-95.toml", "Exit status"]);
    }
}

#[test]
fn closed_pipe_is_no_error() {
    for extra in [&[][..], &["--json"]] {
        let mut child = start(&[&["run", EXPERIMENT_95], extra].concat());
        drop(child.stdout.take());
        let mut message = String::new();
        child.stderr.take().expect("piped").read_to_string(&mut message).expect("UTF-8 text");
        assert_eq!(child.wait().expect("exit status").code(), Some(0), "{message}");
        assert_eq!(message, "");
    }
}

#[cfg(unix)]
#[test]
fn closed_stdout_is_status_3() {
    for redirection in [">&-", "1</dev/null"] {
        let script = format!("exec \"$@\" {redirection}");
        let output = Command::new("sh")
            .args(["-c", &script, "sh", env!("CARGO_BIN_EXE_phalanx"), "run", EXPERIMENT_95])
            .output();
        let output = output.expect("sh is installed");
        assert_eq!(output.status.code(), Some(3), "{redirection}: {}", stderr(&output));
        assert!(stderr(&output).contains("cannot write to standard output"), "{}", stderr(&output));
    }
}

#[test]
fn scene_command_uses_the_same_statuses() {
    succeed(&["scene", "check", EXPERIMENT_95]);
    assert!(run_json(&["scene", "schema"]).is_object());
    let scene = write(&directory("cli_status_scene"), "bad.toml", "duration = \"20 mm\"\n");
    assert_rejected(&["scene", "check", &scene], &[]);
}
