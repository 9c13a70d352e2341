//! Output fits the width of a terminal; output into a pipe is not wrapped.

use std::collections::HashSet;
use std::fs;
use std::io::Read;

use crate::support::cli::{EXPERIMENT_95, assert_contains, directory, json, stderr, stdout};
use crate::support::terminal::{
    TerminalOutput, command, run_on_terminal, run_piped, run_with_stderr_on_terminal, spawn_on_terminal,
};

/// Lines that are wider than `columns`.
fn wide_lines(text: &str, columns: usize) -> Vec<&str> {
    text.lines().filter(|line| line.chars().count() > columns).collect()
}

/// Asserts that the output of a command fits terminals of several widths; returns the last output.
#[track_caller]
fn assert_fits(args: &[&str], widths: &[u16]) -> TerminalOutput {
    let mut last = None;
    for &columns in widths {
        let output = run_on_terminal(columns, &[], args);
        assert!(matches!(output.status, Some(0 | 1)), "{args:?}: {:?}, {}", output.status, output.other_stream);
        assert!(output.screen.lines().count() > 3, "{args:?}:\n{}", output.screen);
        let too_wide = wide_lines(&output.screen, columns.into());
        assert!(too_wide.is_empty(), "{args:?} at {columns}: {too_wide:#?}\n{}", output.screen);
        last = Some(output);
    }
    last.expect("a width")
}

/// Asserts that the terminal shows every word that the command prints into a pipe.
#[track_caller]
fn assert_complete(args: &[&str], columns: u16) {
    let terminal_output = assert_fits(args, &[columns]);
    let words: HashSet<&str> = terminal_output.screen.split_whitespace().collect();
    let output = run_piped(&[], args);
    let missing: Vec<&str> = stdout(&output).split_whitespace().filter(|word| !words.contains(word)).collect();
    assert!(missing.is_empty(), "{args:?} at {columns}: {missing:?}\n{}", terminal_output.screen);
}

/// Path of a test file relative to the working directory, because an absolute path is one word and might not fit the
/// terminal.
fn file(test: &str, name: &str) -> String {
    let path = directory(test).join(name);
    let current_directory = std::env::current_dir().expect("a directory");
    path.strip_prefix(current_directory).unwrap_or(&path).display().to_string()
}

/// Writes results of the first runs of the thesis study.
fn results(name: &str) -> String {
    let path = file(name, "results.csv");
    let output = run_piped(&[], &["sweep", "scenes/studies/thesis.toml", "--limit", "96", "--out", &path]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    path
}

#[test]
fn tables_fit_the_terminal_completely() {
    let results = results("cli_terminal_tables");
    let log = file("cli_terminal_log", "run.mcap");
    assert_eq!(run_piped(&[], &["run", EXPERIMENT_95, "--log", &log]).status.code(), Some(0));
    for columns in [60, 80, 120] {
        assert_complete(&["thesis", "select", &results, "--no-form-closed", "--no-pfp"], columns);
        assert_complete(&["statics", EXPERIMENT_95, "--mu-static", "0,0.4,0.8"], columns);
        assert_complete(&["size", EXPERIMENT_95], columns);
        assert_complete(&["sweep", "scenes/studies/thesis.toml", "--list"], columns);
        assert_complete(&["replay", &log], columns);
        assert_complete(&["scene", "check", EXPERIMENT_95, "scenes/free-swing.toml"], columns);
    }
}

#[test]
fn reports_with_wall_times_fit_the_terminal() {
    let results = results("cli_terminal_sweep");
    let widths = [60, 80];
    assert_fits(&["run", EXPERIMENT_95], &widths);
    assert_fits(&["run", "scenes/laws/two-free.toml"], &widths);
    assert_fits(&["sweep", "scenes/studies/thesis.toml", "--limit", "96", "--out", &results], &widths);
    assert_fits(
        &["thesis", "volume", "--base", "15.5 mm, 19 mm", "--mu-static", "0,0.2,0.4,0.6,0.8", "--resolution", "3"],
        &widths,
    );
    assert_fits(&["thesis", "stability", EXPERIMENT_95, "--quick"], &[80]);
    assert_fits(&["thesis", "step-size", "--quick"], &[80]);
    assert_fits(&["validate", "scenes/laws/step-size.toml", "--ladder", "--quick", "--set", "duration=2 ms"], &[80]);
    let validated = assert_fits(&["validate", "scenes/free-swing.toml", "--ladder", "--quick"], &[80]);
    assert!(validated.screen.contains("speed against error"), "{}", validated.screen);
}

#[test]
fn tables_in_pipes_are_unwrapped_unless_columns_is_set() {
    let results = results("cli_terminal_pipe");
    let args = ["thesis", "select", &results, "--no-form-closed", "--no-pfp"];
    let piped = run_piped(&[], &args);
    let widest = stdout(&piped).lines().map(|line| line.chars().count()).max();
    assert!(widest > Some(120), "{widest:?}");
    // In a pipe a ranking has one line per run.
    assert_eq!(stdout(&piped).matches("r_WC\n").count(), 1);
    assert_eq!(run_on_terminal(500, &[], &args).screen, stdout(&piped));
    for columns in ["0", "wide", "-4", ""] {
        assert_eq!(stdout(&run_piped(&[("COLUMNS", columns)], &args)), stdout(&piped), "{columns}");
    }
    let narrow_output = run_piped(&[("COLUMNS", " 80 ")], &args);
    assert_eq!(wide_lines(stdout(&narrow_output), 80), [""; 0]);
    let wide_output = run_on_terminal(80, &[("COLUMNS", "500")], &args);
    assert_eq!(wide_output.screen, stdout(&piped));
    // JSON documents are never wrapped.
    let args = [&args[..], &["--json"]].concat();
    assert_eq!(run_on_terminal(40, &[], &args).screen, stdout(&run_piped(&[], &args)));
}

#[test]
fn help_fits_the_terminal_and_respects_colour_settings() {
    let is_styled = |text: &str| text.contains('\u{1b}');
    let commands = ",run ,validate ,replay ,scene show ,sweep ,optimize ,schema ,thesis volume ,thesis select ,thesis reproduce ,\
                    thesis stability ,thesis step-size ,size ,statics ,new ,completions ,man ";
    let long_help = commands.split(',').map(|command| format!("{command}--help"));
    for command in long_help.chain(["run -h".to_string()]) {
        let args: Vec<&str> = command.split(' ').collect();
        for columns in [80, 120] {
            let uncoloured = run_on_terminal(columns, &[("NO_COLOR", "1")], &args).screen;
            assert!(uncoloured.contains("Usage:") && !is_styled(&uncoloured), "{uncoloured}");
            let at_most = usize::from(columns).min(100);
            assert_eq!(wide_lines(&uncoloured, at_most), [""; 0], "{args:?} at {columns}");
        }
        assert!(args.contains(&"-h") || run_on_terminal(80, &[("NO_COLOR", "1")], &args).screen.contains("Examples:"));
    }
    assert!(is_styled(&run_on_terminal(80, &[], &["--help"]).screen));
    assert!(!is_styled(&run_on_terminal(80, &[("CLICOLOR", "0")], &["--help"]).screen));
    assert!(!is_styled(&run_on_terminal(80, &[("TERM", "dumb")], &["--help"]).screen));
    assert!(!is_styled(stdout(&run_piped(&[], &["--help"]))));
    assert!(is_styled(stdout(&run_piped(&[("CLICOLOR_FORCE", "1")], &["--help"]))));
}

/// Output of a command on stderr until it shows the remaining time; then the command is killed.
fn progress(args: &[&str]) -> String {
    let (mut child, mut terminal, _) = spawn_on_terminal(command(args, &[]), true, 100);
    let mut screen = String::new();
    let mut bytes = [0; 256];
    while !screen.contains(" left") && screen.len() < 100_000 {
        match terminal.read(&mut bytes) {
            Ok(count) if count > 0 => screen.push_str(&String::from_utf8_lossy(&bytes[..count])),
            _ => break,
        }
    }
    child.kill().expect("a running command");
    let _ = child.wait();
    screen
}

#[test]
fn long_commands_show_progress_and_remaining_time() {
    // One command with many parts and one with a single run; both would run much longer than this test.
    let volume = progress(&["thesis", "volume", "--resolution", "60", "--mu-static", "0.5", "--threads", "1"]);
    assert_contains(&volume, &["[", " %  ", " of 864000, designs", " s, ", " left"]);
    let run =
        progress(&["run", EXPERIMENT_95, "--model", "engine", "--step", "1 us", "--duration", "5 s", "--no-check"]);
    assert_contains(&run, &["[", " %  ", " of 5 s  ", " s, ", " left"]);
}

#[test]
fn quiet_commands_print_only_results_warnings_and_errors() {
    let results = results("cli_terminal_quiet");
    let sweep_args = ["sweep", "scenes/studies/thesis.toml", "--limit", "96", "--out", &results, "--json"];
    let verbose = run_piped(&[], &sweep_args);
    assert!(stderr(&verbose).contains("nothing was run"), "{}", stderr(&verbose));
    for args in [[&["-q"], &sweep_args[..]].concat(), [&sweep_args[..], &["--quiet"]].concat()] {
        let quiet = run_piped(&[], &args);
        assert_eq!((stderr(&quiet), quiet.status.code()), ("", Some(0)));
        assert_eq!(json(&quiet), json(&verbose));
    }
    let with_warning = run_piped(&[], &["thesis", "volume", "-q", "--base", "15.5 mm, 155 mm", "--resolution", "2"]);
    assert!(stderr(&with_warning).contains("warning: no design exists"), "{}", stderr(&with_warning));
    let failed = run_piped(&[], &["-q", "run", "no/such/scene.toml"]);
    assert!(stderr(&failed).starts_with("error: ") && failed.status.code() == Some(2), "{}", stderr(&failed));
}

#[test]
fn short_commands_show_no_progress() {
    for args in [&["statics", EXPERIMENT_95][..], &["run", EXPERIMENT_95], &["run", EXPERIMENT_95, "-q"]] {
        let output = run_with_stderr_on_terminal(args);
        assert_eq!((output.screen.as_str(), output.status), ("", Some(0)), "{args:?}");
        assert!(!output.other_stream.is_empty());
    }
}

#[test]
fn files_are_not_wrapped() {
    let out = directory("cli_terminal_files");
    let out_text = out.display().to_string();
    let args = ["thesis", "volume", "--resolution", "2", "--mu-static", "0,0.2,0.4,0.6,0.8", "--out", &out_text];
    let output = run_on_terminal(40, &[], &args);
    assert_eq!(output.status, Some(0), "{}", output.other_stream);
    let text = fs::read_to_string(out.join("table.txt")).expect("the tables");
    assert!(!wide_lines(&text, 60).is_empty(), "{text}");
    assert!(!text.contains('\u{1b}'));
}
