//! Arbitrary bytes as a scene file: rejected with a message, or a scene that can be formatted losslessly and runs in
//! bounded time.

use phalanx::scene::{Engine, Integrator, LogRates, Scene, parse_any, show};
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
    let limited = Scene {
        integrator: limit_integrator_steps(&scene.integrator),
        engine: limit_engine_steps(&scene.engine),
        log: limit_rate(scene.log, scene.duration_s),
        ..scene
    };
    for model in [Model::Analytic, Model::Engine] {
        if let Err(error) = run(model, &limited, &mut ()) {
            assert!(!error.to_string().is_empty());
        }
    }
}

fn limit_integrator_steps(integrator: &Integrator) -> Integrator {
    Integrator { max_steps: MAX_STEPS.min(integrator.max_steps), ..*integrator }
}

fn limit_engine_steps(engine: &Engine) -> Engine {
    Engine { max_steps: MAX_STEPS.min(engine.max_steps), iterations: engine.iterations.min(50), ..*engine }
}

fn limit_rate(log: LogRates, duration_s: f64) -> LogRates {
    LogRates { numeric_hz: log.numeric_hz.min(MAX_SAMPLES / duration_s), ..log }
}
