//! Limit on the number of samples, since whole runs are stored in memory to be compared.

use crate::limits::MAX_VALIDATED_SAMPLES;
use crate::scene::Scene;

/// Checks that a validation of the scene fits into memory.
///
/// # Errors
/// Returns an error if the number of samples exceeds [`MAX_VALIDATED_SAMPLES`].
pub fn check_sample_count(scene: &Scene) -> Result<(), String> {
    let numeric_hz = scene.log.numeric_hz;
    let samples = numeric_hz * scene.duration_s;
    if samples <= MAX_VALIDATED_SAMPLES {
        return Ok(());
    }
    Err(format!(
        "the scene requests {samples:.0} samples of a run ({:e} Hz over {} s), but a validation stores several runs in memory \
         and accepts at most {MAX_VALIDATED_SAMPLES:e}; lower numeric_rate in [log] to {:e} Hz, or shorten the run",
        numeric_hz,
        scene.duration_s,
        (MAX_VALIDATED_SAMPLES / scene.duration_s).floor()
    ))
}
