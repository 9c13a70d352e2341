//! `--version`: the version and, in a release, the commit.

use std::path::Path;
use std::process::Command;

use crate::support::cli::{directory, phalanx, stdout, write};

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
