//! Arbitrary bytes as a scene file: rejected with a message, or a scene that can be formatted losslessly and runs in
//! bounded time.

use phalanx::scene::{Scene, parse_any, show};
use phalanx::trace::{Model, run};

/// Maximum steps of a run.
const MAX_STEPS: u64 = 100;
/// Maximum samples on the time grid of a run.
const MAX_SAMPLES: f64 = 1e3;

pub fn scene(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let scene = match parse_any(text, "fuzz.toml") {
        Ok(scene) => scene,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return;
        }
    };
    let formatted = show(&scene);
    let reparsed =
        parse_any(&formatted, "fuzz.toml").unwrap_or_else(|error| panic!("the formatted scene is rejected: {error}"));
    assert_eq!(show(&reparsed), formatted);
    assert_eq!(Scene { source: scene.source.clone(), ..reparsed }, scene);
    let Scene { mut integrator, mut engine, mut log, .. } = scene;
    integrator.max_steps = MAX_STEPS.min(integrator.max_steps);
    (engine.max_steps, engine.iterations) = (MAX_STEPS.min(engine.max_steps), engine.iterations.min(50));
    log.numeric_hz = log.numeric_hz.min(MAX_SAMPLES / scene.duration_s);
    let limited = Scene { integrator, engine, log, ..scene };
    for model in [Model::Analytic, Model::Engine] {
        if let Err(error) = run(model, &limited, &mut ()) {
            assert!(!error.to_string().is_empty());
        }
    }
}
