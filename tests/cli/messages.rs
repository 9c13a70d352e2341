//! Exit statuses and error messages: 2 for bad input, with the allowed values or advice; 3 for an incomplete run.

use std::fs;
use std::io::Read;
use std::process::Command;

use crate::support::cli::{
    self, EXPERIMENT_95, assert_status, directory, json, path_in, phalanx, start, stderr, stdout, succeed, variant,
    write,
};
use mcap::MessageStream;
use serde_json::Value;

/// Asserts that a command is rejected with a message of short lines.
#[track_caller]
fn assert_rejected(args: &[&str], parts: &[&str]) {
    let message = cli::assert_rejected(args, parts);
    assert!(message.lines().all(|line| line.chars().count() < 300) && !message.contains("'-- -"), "{message}");
}

#[test]
fn invalid_arguments_are_rejected_with_the_allowed_values() {
    let cases: [(&[&str], &[&str]); 16] = [
        (&["rn"], &["'run'"]),
        (&["scene", "shw"], &["'show'"]),
        (&["run"], &["<SCENE>"]),
        (&["run", "no/such/scene.toml", "--json"], &["no/such/scene.toml", "no such file"]),
        (&["statics", EXPERIMENT_95, "--motor", "480 Nmm"], &["`Nmm` (did you mean N*mm?)"]),
        (&["statics", EXPERIMENT_95, "--mu-static", "-1"], &["'-1' for '--mu-static", "0 or more"]),
        (&["thesis", "volume", "--mu-static", "-1"], &["'-1' for '--mu-static", "0 or more"]),
        (&["thesis", "volume", "--base", "-1 mm"], &["more than 0", "12 mm"]),
        (&["thesis", "volume", "--base", "1 deg"], &["is an angle", "give lengths such as"]),
        (&["thesis", "volume", "--resolution", "-1"], &["`-1`", "1 or more"]),
        (&["thesis", "select", "none.csv", "--max-rebound", "-1"], &["percentage of 0 or more"]),
        (&["thesis", "select", "none.csv", "--best", "-1"], &["0 or more"]),
        (&["sweep", "none.toml", "--out", "x.csv", "--limit", "-1"], &["1 or more"]),
        (&["thesis", "reproduce", "--threads", "-1"], &["threads from 1 to 1024"]),
        (&["thesis", "stability", EXPERIMENT_95, "--stiffness", "-1"], &["above 0"]),
        (&["thesis", "stability", EXPERIMENT_95, "--stiffness", "nan"], &["above 0"]),
    ];
    for (args, parts) in cases {
        assert_rejected(args, parts);
    }
    let run_cases: [(&[&str], &[&str]); 24] = [
        (&["--jason"], &["--jason", "--json"]),
        // A flag is not accepted as the name of a file.
        (&["--log", "--json"], &["--log"]),
        (&["--model", "magic"], &["magic", "analytic"]),
        (&["--rtol", "-1"], &["'-1' for '--rtol", "between 0 and 1"]),
        (&["--rtol", "0"], &["between 0 and 1"]),
        (&["--rtol", "2"], &["between 0 and 1"]),
        (&["--rtol", "nan"], &["nan", "between 0 and 1"]),
        (&["--rtol", "tight"], &["tight", "between 0 and 1"]),
        (&["--duration", "30"], &["30", "no unit", "ms"]),
        (&["--duration", "30 mm"], &["30 mm"]),
        (&["--duration", "0 ms"], &["longer than 0"]),
        (&["--duration", "-1 ms"], &["longer than 0", "30 ms"]),
        (&["--duration", "inf s"], &["finite"]),
        (&["--duration", "1e300s"], &["too large", "3600 s at most"]),
        (&["--numeric-rate", "-1 Hz"], &["more than 0", "10 kHz"]),
        (&["--model", "engine", "--step", "0 us"], &["--step", "0 us"]),
        (&["--model", "engine", "--step", "-1 us"], &["longer than 0", "1 us"]),
        (&["--model", "engine", "--step", "1 mm"], &["--step", "1 mm"]),
        (&["--model", "engine", "--step", "1"], &["--step", "1"]),
        (&["--model", "engine", "--step", "1 us", "--tolerance", "1 um"], &["--tolerance"]),
        // Settings of the other model.
        (&["--step", "1 us"], &["--step", "analytic model runs", "--model engine"]),
        (&["--tolerance", "1 um"], &["--tolerance", "analytic model runs", "--model engine"]),
        (&["--model", "engine", "--preset", "reference"], &["--preset", "engine model runs", "--model analytic"]),
        (&["--model", "engine", "--rtol", "1e-3"], &["--rtol", "engine model runs", "--model analytic"]),
    ];
    for (args, parts) in run_cases {
        assert_rejected(&[&["run", EXPERIMENT_95], args].concat(), parts);
    }
}

#[test]
fn invalid_scenes_are_rejected_with_their_position() {
    let directory = directory("messages_scenes");
    let text = fs::read_to_string(EXPERIMENT_95).expect("the scene");
    for (name, text, parts) in [
        ("nm.toml", text.replace("480 N*mm", "0.48 Nm"), &["nm.toml:12", "did you mean N*m?", "N*mm"][..]),
        ("far.toml", text.replace("\"15.5 mm\"", "\"1e300 mm\""), &["far.toml:6", "too large", "1000 m at most"]),
        ("unit.toml", "duration = \"20 mm\"\n".to_string(), &["unit.toml:1:12", "20 mm"]),
        ("syntax.toml", "duration = \n".to_string(), &["syntax.toml:1"]),
    ] {
        assert_rejected(&["run", &write(&directory, name, &text)], parts);
    }
}

#[test]
fn long_texts_are_shortened_in_messages() {
    let (dir, long) = (directory("messages_long"), "a".repeat(100_000));
    assert_rejected(&["run", EXPERIMENT_95, "--set", &long], &["there is no `=`"]);
    assert_rejected(&["run", EXPERIMENT_95, "--set", &format!("{long}=1")], &["unknown key"]);
    let long_field = format!("object.radius={}", "a ".repeat(50_000));
    for args in [["run", EXPERIMENT_95, "--set", &long_field], ["hold", EXPERIMENT_95, "--from", &long]] {
        assert!((10..3000).contains(&stderr(&phalanx(&args)).len()), "{}", stderr(&phalanx(&args)));
    }
    // Only a hundred keys are examined. Comparing every key with every other would take minutes.
    let keys: String = (0..60_000).map(|key| format!("k{key} = 1\n")).collect();
    assert_rejected(&["run", &write(&dir, "keys.toml", &keys), "--set", "palm=false"], &["100 problems or more"]);
}

#[test]
fn log_given_as_scene_is_rejected() {
    let log = &path_in(&directory("messages_log"), "closing.mcap");
    succeed(&["run", EXPERIMENT_95, "--log", log]);
    let suggestion = format!("phalanx replay {log}");
    for command in ["run", "validate", "statics", "size"] {
        assert_rejected(&[command, log], &["is the log of a run (MCAP), not a scene", &suggestion]);
    }
}

#[test]
fn help_of_value_names_is_well_formed() {
    let output = phalanx(&["thesis", "select", "--help"]);
    assert!(stdout(&output).contains("--bound <BOUND>") && stdout(&output).contains("COLUMN >= VALUE"));
    for command in ["run", "validate", "replay", "size", "statics", "volume", "sweep", "select", "reproduce"] {
        let help = phalanx(&[command, "--help"]);
        let flags = stdout(&help).lines().filter(|line| line.trim_start().starts_with("--"));
        for line in flags {
            assert_eq!(line.matches('<').count(), line.matches('>').count(), "{line}");
        }
    }
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
    assert!(messages.iter().filter(|message| message.channel.topic == "/joint/q11").count() > 1);
    let last = messages.last().expect("not empty");
    assert_eq!(last.channel.topic, "/events");
    let text = String::from_utf8_lossy(&last.data);
    assert!(text.contains("stopped: ") && text.contains("40"), "{text}");

    // The message suggests --log.
    let output = assert_status(&["run", &scene], 3, &["--log"]);
    assert!(stdout(&output).contains("NOT COMPLETED"));
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
fn former_names_answer_with_the_present_ones() {
    for (args, present) in [
        (&["reproduce"][..], "phalanx thesis reproduce"),
        (&["volume", "--out", "x"], "phalanx thesis volume"),
        (&["select", "x.csv"], "phalanx thesis select"),
        (&["study", "step-size"], "phalanx thesis"),
        (&["scene", "schema"], "phalanx schema scene"),
        (&["sweep", "--schema"], "phalanx schema study"),
        (&["run", EXPERIMENT_95, "--html", "x.html"], "--plot FILE.html"),
        (&["hold", EXPERIMENT_95, "--svg=x.svg"], "--plot FILE.svg"),
        (&["scene", "show", EXPERIMENT_95, "--figure", "x.svg"], "--plot FILE.svg"),
        (&["run", EXPERIMENT_95, "--live"], "--log FILE.mcap"),
    ] {
        assert_rejected(args, &[&format!("it is now `{present}")]);
    }
    for name in ["x", "x.pdf"] {
        let allowed = if cfg!(feature = "png") { ".svg, .png or .html" } else { ".svg or .html" };
        assert_rejected(&["statics", EXPERIMENT_95, "--plot", name], &[&format!("the name must end in {allowed}")]);
    }
    #[cfg(not(feature = "png"))]
    assert_rejected(&["statics", EXPERIMENT_95, "--plot", "x.png"], &["cargo install --features png"]);
}

#[test]
fn a_picture_can_be_a_page() {
    let page = path_in(&directory("cli_picture_page"), "grasp.html");
    for force in [&[][..], &["--quiet"]] {
        cli::succeed_silently(&[&["statics", EXPERIMENT_95, "--plot", &page], force].concat());
        let text = std::fs::read_to_string(&page).expect("a page");
        assert!(text.starts_with("<!DOCTYPE html>") && text.contains("<svg"), "{text}");
    }
}
