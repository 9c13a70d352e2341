//! Completions and manual pages: for every command, and written like every other file.

use std::fs;
use std::process::{Command, Stdio};

use crate::support::cli::{ANCHOR, directory, phalanx, stderr, stdout, write};

const COMMANDS: [&str; 13] = [
    "new",
    "run",
    "validate",
    "replay",
    "scene",
    "size",
    "statics",
    "volume",
    "sweep",
    "select",
    "optimize",
    "reproduce",
    "study",
];

/// Whether a shell that is here finds a script sound; `None` where it is not here.
fn sound(shell: &str, file: &str) -> Option<bool> {
    let mut command = Command::new(shell);
    let status = command.args(["-n", file]).stdin(Stdio::null()).stderr(Stdio::inherit()).status().ok()?;
    Some(status.success())
}

#[test]
fn completions_are_sound_scripts_that_know_every_command_and_option() {
    let directory = directory("cli_completions");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = phalanx(&["completions", shell]);
        assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""), "{shell}");
        let script = stdout(&output);
        for word in
            COMMANDS.iter().chain(&["completions", "man", "--no-form-closed", "stability", "--quiet", "analytic"])
        {
            // fish says options without their dashes.
            let word = if shell == "fish" { word.trim_start_matches('-') } else { word };
            assert!(script.contains(word), "{shell}: no {word}");
        }
        assert!(!script.contains("\\u00"), "{shell}: a character was taken for one that acts");
        let file = write(&directory, shell, script);
        if ["bash", "zsh", "fish"].contains(&shell) {
            assert_ne!(sound(shell, &file), Some(false), "{shell}");
        }
    }
    let output = phalanx(&["completions", "tcsh"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("tcsh") && stderr(&output).contains("bash, elvish, fish"), "{}", stderr(&output));
}

/// Long options that the help of a command names.
fn options(help: &str) -> Vec<&str> {
    let lines = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
    let words =
        lines.flat_map(|line| line.split([' ', ',']).take_while(|word| word.is_empty() || word.starts_with('-')));
    words.filter(|word| word.starts_with("--")).collect()
}

#[test]
fn every_command_has_a_manual_page_with_all_its_options() {
    let out = directory("cli_man").join("man1");
    let place = out.display().to_string();
    let output = phalanx(&["man", &place]);
    assert_eq!((output.status.code(), stderr(&output)), (Some(0), ""));
    assert!(stdout(&output).starts_with("wrote ") && stdout(&output).contains(&place), "{}", stdout(&output));
    let below = [
        &["scene", "show"][..],
        &["scene", "check"],
        &["scene", "schema"],
        &["study", "stability"],
        &["sweep", "merge"],
    ];
    let all =
        COMMANDS.iter().map(std::slice::from_ref).chain(below).chain([&["study", "step-size"][..], &["man"], &[]]);
    for words in all {
        let name = [&["phalanx"], words].concat().join("-");
        let page = fs::read_to_string(out.join(format!("{name}.1"))).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(page.contains(".TH ") && page.contains(".SH SYNOPSIS"), "{name}");
        let help = phalanx(&[words, &["--help"]].concat());
        let found = options(stdout(&help));
        assert!(found.contains(&"--quiet"), "{name}: {found:?}");
        // A dash that is no hyphen is escaped.
        let page = page.replace("\\-", "-");
        let missing: Vec<&str> = found.into_iter().filter(|option| !page.contains(option)).collect();
        assert!(missing.is_empty(), "{name}: {missing:?}");
    }
    let main = phalanx(&["man"]);
    assert_eq!(stdout(&main), fs::read_to_string(out.join("phalanx.1")).expect("the main page"));
    assert!(stdout(&main).contains("phalanx\\-volume(1)"));
}

#[test]
fn manual_pages_replace_only_manual_pages_of_phalanx() {
    let out = directory("cli_man_own");
    let place = out.display().to_string();
    assert_eq!(phalanx(&["man", &place]).status.code(), Some(0));
    assert_eq!(phalanx(&["man", &place]).status.code(), Some(0), "its own pages");
    let mine = write(&out, "phalanx-run.1", "my notes");
    let refused = phalanx(&["man", &place]);
    assert_eq!(refused.status.code(), Some(2));
    let message = stderr(&refused);
    assert!(message.contains("phalanx-run.1") && message.contains("left alone"), "{message}");
    assert!(message.contains("give another directory") && !message.contains("--out"), "{message}");
    assert_eq!(fs::read_to_string(mine).expect("still there"), "my notes");
    let file = phalanx(&["man", ANCHOR]);
    assert_eq!(file.status.code(), Some(2), "{}", stderr(&file));
    assert!(stderr(&file).contains(ANCHOR), "{}", stderr(&file));
}
