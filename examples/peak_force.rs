//! Records a run as arrays: each column of `replay --csv` is available as a slice by its name.
//!
//! `cargo run --release --example peak_force`

use std::error::Error;

use phalanx::prelude::*;

/// Simulates and records a closing with the engine.
pub fn closing() -> Result<(Outcome, Recording), Box<dyn Error>> {
    let scene = scene::load("scenes/experiment-95.toml")?;
    Ok(record(Model::Engine, &scene)?)
}

/// Returns time and value of the maximum of a column. NaN, such as a force without an object, is ignored.
pub fn peak(recording: &Recording, name: &str) -> Option<(f64, f64)> {
    let samples = recording.time().iter().copied().zip(recording.column(name)?.iter().copied());
    samples.filter(|(_, value)| !value.is_nan()).max_by(|a, b| a.1.total_cmp(&b.1))
}

fn main() -> Result<(), Box<dyn Error>> {
    let (_, recording) = closing()?;
    println!("{} samples of {} columns", recording.time().len(), recording.channels().len());
    for name in ["proximal_normal_n", "distal_normal_n"] {
        if let Some((time_s, force_n)) = peak(&recording, name) {
            println!("{name} is largest at {:.4} ms: {force_n:.1} N", time_s * 1e3);
        }
    }
    for event in recording.events().iter().take(4) {
        let contact = &recording.contacts()[event.contact].name;
        println!("{:.4} ms: {:?} of {contact}", event.time_s * 1e3, event.kind);
    }
    Ok(())
}
