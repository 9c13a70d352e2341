//! What fits into memory: runs are held whole to be compared.

use crate::limits::MOST_VALIDATED_SAMPLES;
use crate::scene::Scene;

/// Refuses a scene with more samples than a validation takes.
///
/// # Errors
/// How many it has, and what to do.
pub fn refuse_too_fine(scene: &Scene) -> Result<(), String> {
    let numeric_hz = scene.log.numeric_hz;
    let samples = numeric_hz * scene.duration_s;
    if samples <= MOST_VALIDATED_SAMPLES {
        return Ok(());
    }
    Err(format!(
        "the scene asks for {samples:.0} samples of a run ({:e} Hz over {} s), and a validation, which holds several runs in \
         memory, takes {MOST_VALIDATED_SAMPLES:e}; lower numeric_rate in [log] to {:e} Hz, or shorten the run",
        numeric_hz,
        scene.duration_s,
        (MOST_VALIDATED_SAMPLES / scene.duration_s).floor()
    ))
}
