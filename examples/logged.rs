//! Run and log by one call, then read the log: it opens in Foxglove too, and `phalanx replay LOG --verify` simulates it again.
//! The scene was changed in memory, and the log says so.
//!
//! `cargo run --release --example logged -- run.mcap`

use phalanx::scene::words::SceneKind;
use std::error::Error;
use std::path::{Path, PathBuf};

use phalanx::log::{self, Reading};
use phalanx::scene::{self, Actuation};
use phalanx::trace::{Layout, Model, Recording};

/// A closing with a motor of our own, logged.
pub fn write(path: &Path) -> Result<(), Box<dyn Error>> {
    let mut scene = scene::load("scenes/experiment-95.toml")?;
    scene.name = "stronger motor".to_string();
    scene.finger_mut().motor.actuation = Actuation::Ramp { torque_n_m: 0.8, rise_s: 2e-3 };
    let run = log::run_to(&scene, Model::Analytic, path)?;
    if let Some(criteria) = run.criteria {
        println!("{}: {}", scene.name, criteria.class.name());
    }
    Ok(())
}

/// What the log says of its run, and its samples as arrays.
pub fn read(path: &Path) -> Result<(Reading, Recording), Box<dyn Error>> {
    let mut recording = Recording::new(&Layout::of_kind(SceneKind::Finger));
    let reading = log::read_file(path, &mut recording)?;
    Ok((reading, recording))
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("run.mcap"), PathBuf::from);
    write(&path)?;
    let (reading, recording) = read(&path)?;
    let ended = reading.ended.ok_or("the log does not say how its run ended")?;
    let how = ended.stopped.as_deref().unwrap_or("completed");
    println!("{}: {} samples, {} events, {how}", path.display(), recording.time().len(), recording.events().len());
    Ok(())
}
