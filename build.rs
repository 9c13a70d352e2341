//! Adds the commit of a release build to the output of `phalanx --version`, with its date, and `-dirty` if the sources
//! have been changed since.
//!
//! Requires git, and that this directory is the root of a checkout: sources unpacked inside another repository must not
//! report the commit of that repository. Only in optimised builds (`--release`, `cargo install`): otherwise every
//! commit would trigger a rebuild.

use std::path::Path;
use std::process::Command;

/// Sources of the program.
const SOURCES: [&str; 4] = ["Cargo.toml", "Cargo.lock", "src", "crates"];

fn main() {
    let here = std::env::var("CARGO_MANIFEST_DIR").unwrap_or_default();
    let release = std::env::var("PROFILE").is_ok_and(|profile| profile == "release");
    // Without this line cargo reruns the build script after a change of any file.
    println!("cargo:rerun-if-changed=build.rs");
    if release && let Some(found) = commit(Path::new(&here)) {
        let version = std::env::var("CARGO_PKG_VERSION").unwrap_or_default();
        println!("cargo:rustc-env=PHALANX_VERSION={version} ({})", found.text);
        for path in found.depends_on.iter().map(String::as_str).chain(SOURCES) {
            println!("cargo:rerun-if-changed={path}");
        }
    }
}

/// A commit and the files whose changes make it outdated.
pub struct Commit {
    /// Hash and date: `0123456789 2026-01-31`, or `0123456789-dirty 2026-01-31`.
    pub text: String,
    pub depends_on: Vec<String>,
}

/// Returns the commit checked out in a directory; `None` if the directory is not the root of a git checkout.
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
    // HEAD names the branch; the commit of the branch is in a file of its own or in `packed-refs`.
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
    for name in ["HEAD", "packed-refs"].into_iter().chain(branch.as_deref()) {
        let path = here.join(git(&["rev-parse", "--git-path", name])?);
        if path.exists() {
            depends_on.push(path.display().to_string());
        }
    }
    Some(Commit { text: format!("{described} {date}"), depends_on })
}
