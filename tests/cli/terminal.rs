//! What is printed on a terminal fits it, and what is printed into a pipe is for programs.

use std::collections::HashSet;
use std::fs;
use std::io::Read;

use crate::support::cli::{ANCHOR, directory, json, stderr, stdout};
use crate::support::terminal::{Seen, command, errors_on_terminal, on_terminal, piped, start};

/// Lines of a screen that are wider than they may be.
fn wide(text: &str, columns: usize) -> Vec<&str> {
    text.lines().filter(|line| line.chars().count() > columns).collect()
}

/// Runs a command on terminals of several widths; returns what was seen on the last.
#[track_caller]
fn fits(args: &[&str], widths: &[u16]) -> Seen {
    let mut last = None;
    for &columns in widths {
        let seen = on_terminal(columns, &[], args);
        assert!(matches!(seen.status, Some(0 | 1)), "{args:?}: {:?}, {}", seen.status, seen.other);
        assert!(seen.screen.lines().count() > 3, "{args:?}:\n{}", seen.screen);
        let wide = wide(&seen.screen, columns.into());
        assert!(wide.is_empty(), "{args:?} at {columns}: {wide:#?}\n{}", seen.screen);
        last = Some(seen);
    }
    last.expect("a width")
}

/// Everything that the command says in a pipe is on the terminal too, whole.
#[track_caller]
fn complete(args: &[&str], columns: u16) {
    let seen = fits(args, &[columns]);
    let words: HashSet<&str> = seen.screen.split_whitespace().collect();
    let output = piped(&[], args);
    let missing: Vec<&str> = stdout(&output).split_whitespace().filter(|word| !words.contains(word)).collect();
    assert!(missing.is_empty(), "{args:?} at {columns}: {missing:?}\n{}", seen.screen);
}

/// A file of a test as the checks' own directory sees it: a path is one word, and wherever the checkout is, it has to fit.
fn file(test: &str, name: &str) -> String {
    let path = directory(test).join(name);
    let here = std::env::current_dir().expect("a directory");
    path.strip_prefix(here).unwrap_or(&path).display().to_string()
}

/// Results of the first runs of the thesis' study.
fn results(name: &str) -> String {
    let path = file(name, "results.csv");
    let output = piped(&[], &["sweep", "scenes/studies/thesis.toml", "--limit", "96", "--out", &path]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    path
}

#[test]
fn tables_fit_the_terminal_and_nothing_is_lost_or_broken() {
    let results = results("cli_terminal_tables");
    let log = file("cli_terminal_log", "run.mcap");
    assert_eq!(piped(&[], &["run", ANCHOR, "--log", &log]).status.code(), Some(0));
    for columns in [60, 80, 120] {
        complete(&["select", &results, "--no-form-closed", "--no-pfp"], columns);
        complete(&["statics", ANCHOR, "--mu-static", "0,0.4,0.8"], columns);
        complete(&["size", ANCHOR], columns);
        complete(&["sweep", "scenes/studies/thesis.toml", "--list"], columns);
        complete(&["replay", &log], columns);
        complete(&["scene", "check", ANCHOR, "scenes/free-swing.toml"], columns);
    }
}

#[test]
fn reports_with_wall_times_fit_the_terminal() {
    let results = results("cli_terminal_sweep");
    let widths = [60, 80];
    fits(&["run", ANCHOR], &widths);
    fits(&["run", "scenes/laws/two-free.toml"], &widths);
    fits(&["sweep", "scenes/studies/thesis.toml", "--limit", "96", "--out", &results], &widths);
    fits(&["volume", "--base", "15.5 mm, 19 mm", "--mu-static", "0,0.2,0.4,0.6,0.8", "--resolution", "3"], &widths);
    fits(&["study", "stability", ANCHOR, "--quick"], &[80]);
    fits(&["study", "step-size", "--quick"], &[80]);
    fits(&["validate", "scenes/laws/step-size.toml", "--ladder", "--quick", "--set", "duration=2 ms"], &[80]);
    let validated = fits(&["validate", "scenes/free-swing.toml", "--ladder", "--quick"], &[80]);
    assert!(validated.screen.contains("speed against error"), "{}", validated.screen);
}

#[test]
fn pipes_get_tables_as_wide_as_they_are_and_columns_says_another_width() {
    let results = results("cli_terminal_pipe");
    let args = ["select", &results, "--no-form-closed", "--no-pfp"];
    let plain = piped(&[], &args);
    let widest = stdout(&plain).lines().map(|line| line.chars().count()).max();
    assert!(widest > Some(120), "{widest:?}");
    // A ranking in a pipe is one line for each run.
    assert_eq!(stdout(&plain).matches("r_WC\n").count(), 1);
    assert_eq!(on_terminal(500, &[], &args).screen, stdout(&plain));
    for columns in ["0", "wide", ""] {
        assert_eq!(stdout(&piped(&[("COLUMNS", columns)], &args)), stdout(&plain), "{columns}");
    }
    let narrow = piped(&[("COLUMNS", "80")], &args);
    assert_eq!(wide(stdout(&narrow), 80), [""; 0]);
    let told = on_terminal(80, &[("COLUMNS", "500")], &args);
    assert_eq!(told.screen, stdout(&plain));
    // A document is for programs, whatever shows it.
    let document = on_terminal(40, &[], &["select", &results, "--no-form-closed", "--no-pfp", "--json"]);
    assert_eq!(document.screen, stdout(&piped(&[], &["select", &results, "--no-form-closed", "--no-pfp", "--json"])));
}

#[test]
fn help_fits_the_terminal_and_has_colours_only_where_they_are_wanted() {
    let bold = |text: &str| text.contains('\u{1b}');
    for args in [
        &["--help"][..],
        &["run", "--help"],
        &["validate", "--help"],
        &["replay", "--help"],
        &["scene", "show", "--help"],
        &["volume", "--help"],
        &["sweep", "--help"],
        &["select", "--help"],
        &["reproduce", "--help"],
        &["study", "stability", "--help"],
        &["study", "step-size", "--help"],
        &["size", "--help"],
        &["statics", "--help"],
        &["new", "--help"],
        &["completions", "--help"],
        &["man", "--help"],
        &["run", "-h"],
    ] {
        for columns in [80, 120] {
            let plain = on_terminal(columns, &[("NO_COLOR", "1")], args).screen;
            assert!(plain.contains("Usage:") && !bold(&plain), "{plain}");
            let at_most = usize::from(columns).min(100);
            assert_eq!(wide(&plain, at_most), [""; 0], "{args:?} at {columns}");
        }
        assert!(args.contains(&"-h") || on_terminal(80, &[("NO_COLOR", "1")], args).screen.contains("Examples:"));
    }
    assert!(bold(&on_terminal(80, &[], &["--help"]).screen));
    assert!(!bold(&on_terminal(80, &[("CLICOLOR", "0")], &["--help"]).screen));
    assert!(!bold(&on_terminal(80, &[("TERM", "dumb")], &["--help"]).screen));
    assert!(!bold(stdout(&piped(&[], &["--help"]))));
    assert!(bold(stdout(&piped(&[("CLICOLOR_FORCE", "1")], &["--help"]))));
}

/// What a command shows on stderr until it says how long it takes yet; it is ended then.
fn progress(args: &[&str]) -> String {
    let (mut child, mut ours, _) = start(command(args, &[]), true, 100);
    let mut seen = String::new();
    let mut bytes = [0; 256];
    while !seen.contains(" left") && seen.len() < 100_000 {
        match ours.read(&mut bytes) {
            Ok(count) if count > 0 => seen.push_str(&String::from_utf8_lossy(&bytes[..count])),
            _ => break,
        }
    }
    child.kill().expect("still at work");
    let _ = child.wait();
    seen
}

#[test]
fn long_commands_say_how_far_they_are_and_how_long_they_take_yet() {
    // Of many parts, and of one; both take far longer than anybody waits here.
    let volume = progress(&["volume", "--resolution", "60", "--mu-static", "0.5", "--threads", "1"]);
    for part in ["[", " %  ", " of 864000, designs", " s, ", " left"] {
        assert!(volume.contains(part), "no {part:?} in {volume:?}");
    }
    let run = progress(&["run", ANCHOR, "--model", "engine", "--step", "1 us", "--duration", "5 s", "--no-check"]);
    for part in ["[", " %  ", " of 5 s  ", " s, ", " left"] {
        assert!(run.contains(part), "no {part:?} in {run:?}");
    }
}

#[test]
fn quiet_commands_say_results_warnings_and_errors_only() {
    let results = results("cli_terminal_quiet");
    let again = ["sweep", "scenes/studies/thesis.toml", "--limit", "96", "--out", &results, "--json"];
    let loud = piped(&[], &again);
    assert!(stderr(&loud).contains("nothing was run"), "{}", stderr(&loud));
    for args in [[&["-q"], &again[..]].concat(), [&again[..], &["--quiet"]].concat()] {
        let quiet = piped(&[], &args);
        assert_eq!((stderr(&quiet), quiet.status.code()), ("", Some(0)));
        assert_eq!(json(&quiet), json(&loud));
    }
    let warned = piped(&[], &["volume", "-q", "--base", "15.5 mm, 155 mm", "--resolution", "2"]);
    assert!(stderr(&warned).contains("warning: no design exists"), "{}", stderr(&warned));
    let wrong = piped(&[], &["-q", "run", "no/such/scene.toml"]);
    assert!(stderr(&wrong).starts_with("error: ") && wrong.status.code() == Some(2), "{}", stderr(&wrong));
}

#[test]
fn short_commands_show_no_progress() {
    for args in [&["statics", ANCHOR][..], &["run", ANCHOR], &["run", ANCHOR, "-q"]] {
        let seen = errors_on_terminal(args);
        assert_eq!((seen.screen.as_str(), seen.status), ("", Some(0)), "{args:?}");
        assert!(!seen.other.is_empty());
    }
}

#[test]
fn files_are_as_wide_as_they_are_whatever_the_terminal() {
    let out = directory("cli_terminal_files");
    let place = out.display().to_string();
    let args = ["volume", "--resolution", "2", "--mu-static", "0,0.2,0.4,0.6,0.8", "--out", &place];
    let seen = on_terminal(40, &[], &args);
    assert_eq!(seen.status, Some(0), "{}", seen.other);
    let text = fs::read_to_string(out.join("table.txt")).expect("the tables");
    assert!(!wide(&text, 60).is_empty(), "{text}");
    assert!(!text.contains('\u{1b}'));
}
