//! Completions and manual pages of every command, and `--version`: the version and, in a release, the commit.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::support::cli::{
    EXPERIMENT_95, assert_rejected, directory, phalanx, stdout, succeed, succeed_silently, write,
};

/// Commands with a manual page of their own; subcommands after a space.
const PAGES: &str = "new,run,validate,replay,scene,statics,hold,capture,sweep,optimize,explore,size,thesis,schema,scene show,scene check,\
                     scene export,thesis reproduce,thesis volume,thesis select,thesis stability,thesis step-size,sweep merge";

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
    assert!(stdout(&main_page).contains("phalanx\\-thesis(1)"));
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

#[allow(dead_code)]
#[path = "../../build.rs"]
mod build;

fn git(at: &Path, args: &[&str]) {
    let identity = ["-c", "user.name=somebody", "-c", "user.email=somebody@example.org", "-c", "commit.gpgsign=false"];
    let output = Command::new("git").arg("-C").arg(at).args(identity).args(args).output().expect("git is installed");
    assert!(output.status.success(), "git {args:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Returns whether a text has the form `0123456789 2026-01-31`, optionally with `-dirty` after the hash.
fn is_commit(text: &str) -> bool {
    let Some((hash, date)) = text.split_once(' ') else { return false };
    let hash = hash.strip_suffix("-dirty").unwrap_or(hash);
    let date: Vec<&str> = date.split('-').collect();
    let is_numeric = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    hash.len() >= 10
        && hash.bytes().all(|byte| byte.is_ascii_hexdigit())
        && date.iter().map(|part| part.len()).eq([4, 2, 2])
        && date.iter().all(|part| is_numeric(part))
}

#[test]
fn version_of_release_includes_commit() {
    let version = env!("CARGO_PKG_VERSION");
    let short_version = phalanx(&["-V"]);
    assert_eq!(stdout(&short_version), format!("phalanx {version}\n"));
    let long_version = phalanx(&["--version"]);
    let line = stdout(&long_version);
    let commit = line.trim_end().strip_prefix(&format!("phalanx {version}")).unwrap_or_else(|| panic!("{line}"));
    if !commit.is_empty() {
        let commit = commit.strip_prefix(" (").and_then(|rest| rest.strip_suffix(')'));
        assert!(commit.is_some_and(is_commit), "{line}");
    }
}

#[test]
fn commit_is_found_in_its_checkout_and_marked_if_dirty() {
    let at = directory("cli_version");
    git(&at, &["init", "--quiet"]);
    write(&at, "Cargo.toml", "one");
    git(&at, &["add", "."]);
    git(&at, &["commit", "--quiet", "-m", "first"]);
    let first = build::commit(&at).expect("a checkout");
    assert!(is_commit(&first.text) && !first.text.contains("dirty"), "{}", first.text);
    // The version depends on HEAD and its branch, because a commit changes one of them.
    assert_eq!(first.depends_on.len(), 2, "{:?}", first.depends_on);
    assert!(first.depends_on.iter().all(|path| Path::new(path).is_file()), "{:?}", first.depends_on);

    write(&at, "Cargo.toml", "two");
    let modified = build::commit(&at).expect("a checkout").text;
    assert_eq!(modified.replace("-dirty", ""), first.text);
    assert!(is_commit(&modified) && modified.contains("-dirty "), "{modified}");
    git(&at, &["commit", "--quiet", "--all", "-m", "second"]);
    let second = build::commit(&at).expect("a checkout").text;
    assert!(is_commit(&second) && second != first.text && !second.contains("dirty"), "{second}");

    // Tags do not change the name of the commit, and a directory inside another repository is not its checkout.
    git(&at, &["tag", "v9"]);
    assert_eq!(build::commit(&at).expect("a checkout").text, second);
    std::fs::create_dir(at.join("vendored")).expect("created");
    assert!(build::commit(&at.join("vendored")).is_none());
}
