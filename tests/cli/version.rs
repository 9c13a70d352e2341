//! `--version`: the version, and in a release the commit.

use std::path::Path;
use std::process::Command;

use crate::support::cli::{directory, phalanx, stdout, write};

#[allow(dead_code)]
#[path = "../../build.rs"]
mod build;

fn git(at: &Path, args: &[&str]) {
    let who = ["-c", "user.name=somebody", "-c", "user.email=somebody@example.org", "-c", "commit.gpgsign=false"];
    let output = Command::new("git").arg("-C").arg(at).args(who).args(args).output().expect("git is there");
    assert!(output.status.success(), "git {args:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// `0123456789 2026-01-31`, perhaps with `-dirty` behind the first.
fn is_commit(text: &str) -> bool {
    let Some((hash, date)) = text.split_once(' ') else { return false };
    let hash = hash.strip_suffix("-dirty").unwrap_or(hash);
    let date: Vec<&str> = date.split('-').collect();
    let digits = |of: &str| of.bytes().all(|byte| byte.is_ascii_digit());
    hash.len() >= 10
        && hash.bytes().all(|byte| byte.is_ascii_hexdigit())
        && date.iter().map(|of| of.len()).eq([4, 2, 2])
        && date.iter().all(|of| digits(of))
}

#[test]
fn the_version_is_said_and_in_a_release_the_commit() {
    let version = env!("CARGO_PKG_VERSION");
    let short = phalanx(&["-V"]);
    assert_eq!(stdout(&short), format!("phalanx {version}\n"));
    let long = phalanx(&["--version"]);
    let line = stdout(&long);
    let commit = line.trim_end().strip_prefix(&format!("phalanx {version}")).unwrap_or_else(|| panic!("{line}"));
    if !commit.is_empty() {
        let commit = commit.strip_prefix(" (").and_then(|rest| rest.strip_suffix(')'));
        assert!(commit.is_some_and(is_commit), "{line}");
    }
}

#[test]
fn a_commit_is_found_only_in_its_own_checkout_and_says_what_has_been_changed() {
    let at = directory("cli_version");
    git(&at, &["init", "--quiet"]);
    write(&at, "Cargo.toml", "one");
    git(&at, &["add", "."]);
    git(&at, &["commit", "--quiet", "-m", "first"]);
    let first = build::commit(&at).expect("a checkout");
    assert!(is_commit(&first.text) && !first.text.contains("dirty"), "{}", first.text);
    // HEAD and its branch: a commit changes one of them.
    assert_eq!(first.depends_on.len(), 2, "{:?}", first.depends_on);
    assert!(first.depends_on.iter().all(|path| Path::new(path).is_file()), "{:?}", first.depends_on);

    write(&at, "Cargo.toml", "two");
    let dirty = build::commit(&at).expect("a checkout").text;
    assert_eq!(dirty.replace("-dirty", ""), first.text);
    assert!(is_commit(&dirty) && dirty.contains("-dirty "), "{dirty}");
    git(&at, &["commit", "--quiet", "--all", "-m", "second"]);
    let second = build::commit(&at).expect("a checkout").text;
    assert!(is_commit(&second) && second != first.text && !second.contains("dirty"), "{second}");

    // A tag is no commit's name, and a directory in somebody's repository is not the repository.
    git(&at, &["tag", "v9"]);
    assert_eq!(build::commit(&at).expect("a checkout").text, second);
    std::fs::create_dir(at.join("vendored")).expect("made");
    assert!(build::commit(&at.join("vendored")).is_none());
}
