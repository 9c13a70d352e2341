//! Runs a scene that is changed in memory, writes a log and reads it back. Foxglove can open the log, and
//! `phalanx replay LOG --verify` simulates it again. The log contains the changed scene.
//!
//! `cargo run --release --example logged -- run.mcap`

use std::error::Error;
use std::path::{Path, PathBuf};

use phalanx::log::{self, LogSummary};
use phalanx::scene::{self, Profile};
use phalanx::trace::{Model, Recording, Schema};

/// Simulates a closing with another motor and writes its log.
pub fn write(path: &Path) -> Result<(), Box<dyn Error>> {
    let mut scene = scene::load("scenes/experiment-95.toml")?;
    scene.name = "stronger motor".to_string();
    scene.finger_mut().motor.actuation = Profile::Ramp { value: 0.8, rise_s: 2e-3 };
    let run = log::run_to(&scene, Model::Analytic, path)?;
    if let Some(criteria) = run.criteria {
        println!("{}: {}", scene.name, criteria.class.name());
    }
    Ok(())
}

/// Returns the summary of a log, and its samples as arrays.
pub fn read(path: &Path) -> Result<(LogSummary, Recording), Box<dyn Error>> {
    let mut recording = Recording::new(&Schema::for_fingers(1));
    let summary = log::read_file(path, &mut recording)?;
    Ok((summary, recording))
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("run.mcap"), PathBuf::from);
    write(&path)?;
    let (summary, recording) = read(&path)?;
    let run_end = summary.run_end.ok_or("the log does not contain the end of its run")?;
    let status = run_end.stopped.as_deref().unwrap_or("completed");
    println!("{}: {} samples, {} events, {status}", path.display(), recording.time().len(), recording.events().len());
    Ok(())
}
