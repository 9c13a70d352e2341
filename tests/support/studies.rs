//! Study files for sweeps.

use std::fs;
use std::path::Path;

use super::cli::write;

/// Writes a study of short swings without an object; some are rejected and some exceed their step budget. A thousand
/// runs take well under a second.
pub fn write_short_study(directory: &Path, count: u64) -> String {
    write_short_study_as(directory, "cheap.toml", count)
}

/// Writes the study of [`write_short_study`] to a file of the given name.
pub fn write_short_study_as(directory: &Path, name: &str, count: u64) -> String {
    let scene = fs::canonicalize("scenes/free-swing.toml").expect("the shipped scene");
    let text = format!(
        "scene = \"{}\"\n[set]\nduration = \"2 ms\"\nintegrator.max_steps = 29\n[[axes]]\nfield = \"design.l21_fraction\"\nfrom = \
         0.0\nto = 1.1\n[[axes]]\nfield = \"motor.torque\"\nfrom = \"10 N*mm\"\nto = \"900 N*mm\"\n[sample]\ncount = {count}\n",
        scene.display()
    );
    write(directory, name, &text)
}
