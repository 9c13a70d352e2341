//! Studies to sweep.

use std::fs;
use std::path::Path;

use super::cli::write;

/// Short swings without an object, some of them refused, some out of steps: a thousand of them in well under a second.
pub fn cheap(directory: &Path, count: u64) -> String {
    cheap_as(directory, "cheap.toml", count)
}

/// The same under another name.
pub fn cheap_as(directory: &Path, name: &str, count: u64) -> String {
    let scene = fs::canonicalize("scenes/free-swing.toml").expect("ships");
    let text = format!(
        "scene = \"{}\"\n[set]\nduration = \"2 ms\"\nintegrator.max_steps = 29\n[[axes]]\nfield = \"design.l21_fraction\"\nfrom = \
         0.0\nto = 1.1\n[[axes]]\nfield = \"motor.torque\"\nfrom = \"10 N*mm\"\nto = \"900 N*mm\"\n[sample]\ncount = {count}\n",
        scene.display()
    );
    write(directory, name, &text)
}
