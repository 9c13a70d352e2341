//! Completions and manual pages of every command.

use std::fs;
use std::process::{Command, Stdio};

use crate::support::cli::{
    EXPERIMENT_95, assert_rejected, directory, phalanx, stdout, succeed, succeed_silently, write,
};

/// Commands with a manual page of their own; subcommands after a space.
const PAGES: &str = "new,run,validate,replay,scene,size,statics,volume,sweep,select,reproduce,study,man,scene show,scene check,\
                     scene schema,study stability,study step-size,sweep merge";

/// Returns whether a shell accepts the syntax of a script; `None` if the shell is not installed.
fn is_valid_script(shell: &str, file: &str) -> Option<bool> {
    let mut command = Command::new(shell);
    let status = command.args(["-n", file]).stdin(Stdio::null()).stderr(Stdio::inherit()).status().ok()?;
    Some(status.success())
}

#[test]
fn completion_scripts_contain_every_command_and_option() {
    let directory = directory("cli_completions");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = succeed_silently(&["completions", shell]);
        let words = PAGES.split([',', ' ']).chain(["completions", "--no-form-closed", "--quiet", "analytic"]);
        for word in words {
            // fish lists options without dashes.
            let word = if shell == "fish" { word.trim_start_matches('-') } else { word };
            assert!(script.contains(word), "{shell}: no {word}");
        }
        assert!(!script.contains("\\u00"), "{shell}: a harmless character was escaped");
        let file = write(&directory, shell, &script);
        if ["bash", "zsh", "fish"].contains(&shell) {
            assert_ne!(is_valid_script(shell, &file), Some(false), "{shell}");
        }
    }
    assert_rejected(&["completions", "tcsh"], &["tcsh", "bash, elvish, fish"]);
}

/// Long options in the help of a command.
fn options(help: &str) -> Vec<&str> {
    let lines = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
    let words =
        lines.flat_map(|line| line.split([' ', ',']).take_while(|word| word.is_empty() || word.starts_with('-')));
    words.filter(|word| word.starts_with("--")).collect()
}

#[test]
fn every_command_has_a_manual_page_with_all_its_options() {
    let out = directory("cli_man").join("man1");
    let directory_text = out.display().to_string();
    let output = succeed_silently(&["man", &directory_text]);
    assert!(output.starts_with("wrote ") && output.contains(&directory_text), "{output}");
    for words in PAGES.split(',').map(|command| command.split(' ').collect::<Vec<_>>()).chain([Vec::new()]) {
        let name = [&["phalanx"], &words[..]].concat().join("-");
        let page = fs::read_to_string(out.join(format!("{name}.1"))).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(page.contains(".TH ") && page.contains(".SH SYNOPSIS"), "{name}");
        let help = phalanx(&[&words[..], &["--help"]].concat());
        let help_options = options(stdout(&help));
        assert!(help_options.contains(&"--quiet"), "{name}: {help_options:?}");
        // roff escapes dashes.
        let page = page.replace("\\-", "-");
        let missing: Vec<&str> = help_options.into_iter().filter(|option| !page.contains(option)).collect();
        assert!(missing.is_empty(), "{name}: {missing:?}");
    }
    let main_page = phalanx(&["man"]);
    assert_eq!(stdout(&main_page), fs::read_to_string(out.join("phalanx.1")).expect("the main page"));
    assert!(stdout(&main_page).contains("phalanx\\-volume(1)"));
}

#[test]
fn manual_pages_replace_only_manual_pages_of_phalanx() {
    let out = directory("cli_man_own");
    let directory_text = out.display().to_string();
    succeed(&["man", &directory_text]);
    succeed(&["man", &directory_text]);
    let other_file = write(&out, "phalanx-run.1", "my notes");
    let parts = ["phalanx-run.1", "not replaced", "give another directory"];
    let message = assert_rejected(&["man", &directory_text], &parts);
    assert!(!message.contains("--out"), "{message}");
    assert_eq!(fs::read_to_string(other_file).expect("readable"), "my notes");
    assert_rejected(&["man", EXPERIMENT_95], &[EXPERIMENT_95]);
}
