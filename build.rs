//! What `phalanx --version` says beside the version: the commit that a release is built from, its date, and `-dirty` where the
//! sources have been changed since.
//!
//! Only where git is there and this directory is the checkout itself: what is unpacked within somebody else's repository has not
//! the commits of that. And only in optimised builds (`--release`, `cargo install`): a new commit makes everything stale that says
//! its name, and a build for tests is made again after every commit anyway.

use std::path::Path;
use std::process::Command;

/// What the program is made of.
const SOURCES: [&str; 4] = ["Cargo.toml", "Cargo.lock", "src", "crates"];

fn main() {
    let here = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    let release = std::env::var("PROFILE").is_ok_and(|profile| profile == "release");
    // Said in any case: without it cargo runs this again after the change of any file.
    println!("cargo:rerun-if-changed=build.rs");
    if release && let Some(found) = commit(Path::new(&here)) {
        let version = std::env::var("CARGO_PKG_VERSION").unwrap_or_default();
        println!("cargo:rustc-env=PHALANX_VERSION={version} ({})", found.text);
        for path in found.depends_on.iter().map(String::as_str).chain(SOURCES) {
            println!("cargo:rerun-if-changed={path}");
        }
    }
}

/// A commit, and the files that change with it.
pub struct Commit {
    /// As `0123456789 2026-01-31`, with `-dirty` behind the first.
    pub text: String,
    pub depends_on: Vec<String>,
}

/// The commit that is checked out in a directory; `None` if the directory is not one that git has checked out.
pub fn commit(here: &Path) -> Option<Commit> {
    let git = |args: &[&str]| -> Option<String> {
        let output = Command::new("git").arg("-C").arg(here).args(args).output().ok()?;
        let text = String::from_utf8(output.stdout).ok().filter(|_| output.status.success())?;
        Some(text.trim().to_string())
    };
    let top = git(&["rev-parse", "--show-toplevel"])?;
    if Path::new(&top).canonicalize().ok()? != here.canonicalize().ok()? {
        return None;
    }
    let described = git(&["describe", "--always", "--dirty", "--abbrev=10", "--exclude=*"])?;
    let date = git(&["log", "-1", "--format=%cs"])?;
    let mut depends_on = Vec::new();
    // The branch's own file is there or, packed, in another; HEAD says which branch it is.
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
    for name in ["HEAD", "packed-refs"].into_iter().chain(branch.as_deref()) {
        let path = here.join(git(&["rev-parse", "--git-path", name])?);
        if path.exists() {
            depends_on.push(path.display().to_string());
        }
    }
    Some(Commit { text: format!("{described} {date}"), depends_on })
}
