//! Any bytes as a scene file: refused with a message, or a scene that shows itself as it is and runs in bounded time.

use phalanx::scene::{Engine, Integrator, LogRates, Scene, parse_any, show};
use phalanx::trace::{Model, run};

/// Steps that a run may take here.
const STEPS: u64 = 100;
/// Samples on the grid of a run.
const SAMPLES: f64 = 1e3;

pub fn scene(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let scene = match parse_any(text, "fuzz.toml") {
        Ok(scene) => scene,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return;
        }
    };
    let shown = show(&scene);
    let again = parse_any(&shown, "fuzz.toml").unwrap_or_else(|error| panic!("what is shown is refused: {error}"));
    assert_eq!(show(&again), shown);
    assert_eq!(Scene { source: scene.source.clone(), ..again }, scene);
    let short = Scene {
        integrator: short_integrator(&scene.integrator),
        engine: short_engine(&scene.engine),
        log: coarse(scene.log, scene.duration_s),
        ..scene
    };
    for model in [Model::Analytic, Model::Engine] {
        if let Err(error) = run(model, &short, &mut ()) {
            assert!(!error.to_string().is_empty());
        }
    }
}

fn short_integrator(integrator: &Integrator) -> Integrator {
    Integrator { max_steps: STEPS.min(integrator.max_steps), ..*integrator }
}

fn short_engine(engine: &Engine) -> Engine {
    Engine { max_steps: STEPS.min(engine.max_steps), iterations: engine.iterations.min(50), ..*engine }
}

fn coarse(log: LogRates, duration_s: f64) -> LogRates {
    LogRates { numeric_hz: log.numeric_hz.min(SAMPLES / duration_s), ..log }
}
