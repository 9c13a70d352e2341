//! Prepares optimised builds (`--release`, `cargo install`):
//!
//! * The output of `phalanx --version` gets the commit of the build with its date, and `-dirty` if the sources have been changed
//!   since. Requires git, and that this directory is the root of a checkout: sources unpacked inside another repository must not
//!   report the commit of that repository.
//! * The program gets the explorer's WebAssembly module, so that `phalanx explore` needs no further file. It is the file named by
//!   `PHALANX_EXPLORER_MODULE`, or `explorer.wasm.gz` in this directory (published packages contain it), or built from
//!   `crates/explorer` if the toolchain has the target. An empty `PHALANX_EXPLORER_MODULE` omits it.
//!
//! Other builds have neither: every commit would trigger a rebuild, and the module takes three minutes of processor time.

use std::env;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

use flate2::Compression;
use flate2::write::GzEncoder;

/// Sources of the program.
const SOURCES: [&str; 4] = ["Cargo.toml", "Cargo.lock", "src", "crates"];

/// Target of the explorer's module.
const WEB: &str = "wasm32-unknown-unknown";
/// Environment variable with the path of a module to include instead of a new one.
const MODULE_VARIABLE: &str = "PHALANX_EXPLORER_MODULE";

fn main() {
    let here = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    // Without these lines cargo reruns the build script after a change of any file.
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-env-changed={MODULE_VARIABLE}");
    println!("cargo:rustc-check-cfg=cfg(has_explorer_module)");
    if env::var("PROFILE").is_ok_and(|profile| profile == "release") {
        for path in SOURCES {
            println!("cargo:rerun-if-changed={path}");
        }
        add_version(&here);
        add_module(&here);
    }
}

fn add_version(here: &Path) {
    if let Some(found) = commit(here) {
        let version = env::var("CARGO_PKG_VERSION").unwrap_or_default();
        println!("cargo:rustc-env=PHALANX_VERSION={version} ({})", found.text);
        for path in found.depends_on {
            println!("cargo:rerun-if-changed={path}");
        }
    }
}

/// Copies or builds the explorer's module. Without it the program is complete except for `phalanx explore`, so errors are
/// warnings.
fn add_module(here: &Path) {
    let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default());
    // Profiles that inherit from `release` have other names: the wheel contains no program.
    if out.ancestors().nth(3).and_then(Path::file_name).is_none_or(|profile| profile != "release") {
        return;
    }
    let module = out.join("explorer.wasm.gz");
    let packed = here.join("explorer.wasm.gz");
    let made = match env::var_os(MODULE_VARIABLE) {
        Some(name) if name.is_empty() => return,
        Some(name) => {
            println!("cargo:rerun-if-changed={}", name.display());
            fs::copy(&name, &module).map_err(|error| format!("cannot read {}: {error}", name.display()))
        }
        None if packed.is_file() => fs::copy(&packed, &module).map_err(|error| error.to_string()),
        None if has_web_target() => build_module(&here.join("crates/explorer"), &out.join("explorer"), &module),
        None => return,
    };
    match made {
        Ok(_) => println!("cargo:rustc-cfg=has_explorer_module"),
        Err(reason) => println!("cargo:warning=the program is built without the explorer's module: {reason}"),
    }
}

/// Whether the compiler has the standard library of [`WEB`].
fn has_web_target() -> bool {
    let compiler = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(compiler).args(["--print", "target-libdir", "--target", WEB]).output();
    output.is_ok_and(|output| Path::new(String::from_utf8_lossy(&output.stdout).trim()).is_dir())
}

/// Builds the module from its workspace, in a target directory of its own (that of this build is locked), and compresses it.
/// Returns its size in bytes.
fn build_module(workspace: &Path, target: &Path, module: &Path) -> Result<u64, String> {
    let mut build = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    build.args(["build", "--release", "--locked", "--quiet", "--target", WEB]).arg("--target-dir").arg(target);
    build.arg("--manifest-path").arg(workspace.join("Cargo.toml"));
    // Flags of this build are for another target.
    for name in ["CARGO_ENCODED_RUSTFLAGS", "RUSTFLAGS", "CARGO_BUILD_TARGET", "CARGO_TARGET_DIR"] {
        build.env_remove(name);
    }
    let output = build.output().map_err(|error| format!("cargo: {error}"))?;
    if !output.status.success() {
        let errors = String::from_utf8_lossy(&output.stderr);
        return Err(format!("cargo: {}: {}", output.status, errors.lines().last().unwrap_or_default()));
    }
    let built = target.join(WEB).join("release/phalanx_explorer.wasm");
    let pack = || -> io::Result<u64> {
        let mut encoder = GzEncoder::new(File::create(module)?, Compression::best());
        io::copy(&mut File::open(&built)?, &mut encoder)?;
        encoder.finish()?.metadata().map(|metadata| metadata.len())
    };
    pack().map_err(|error| format!("{}: {error}", built.display()))
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
