//! Studies for sweeps, and their rows.

use std::collections::HashSet;
use std::fs;
use std::path::Path;

use phalanx::study::sweep::{Row, Study, parse, run_while, table};
use phalanx::table::Table;

use super::cli::write;

/// Parses a study in the directory of the shipped ones.
pub fn parse_study(text: &str) -> Study {
    parse(text, "scenes/studies/study.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Performs the runs of a study that are not in `done`.
pub fn run_rows(study: &Study, threads: usize, done: &HashSet<u64>) -> Vec<Row> {
    let mut rows = Vec::new();
    let stats = run_while(study, threads, 1..=study.runs(), done, &|| true, |row| {
        rows.push(row);
        true
    });
    assert!(stats.complete && stats.runs == rows.len() as u64 && stats.runs + done.len() as u64 == study.runs());
    rows
}

/// Performs all runs of a study.
pub fn run_study(study: &Study) -> Table {
    table(study, &run_rows(study, 0, &HashSet::new()))
}

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
