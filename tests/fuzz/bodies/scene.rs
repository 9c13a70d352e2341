//! Any bytes as a scene file: refused with a message, or a scene that shows itself as it is and runs in bounded time.

use phalanx::scene::{Engine, Integrator, LogRates, Scene, parse, show};
use phalanx::trace::{Model, run};

/// Steps that a run may take here.
const STEPS: u64 = 100;
/// Samples on the grid of a run.
const SAMPLES: f64 = 1e3;

pub fn scene(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let scene = match parse(text, "fuzz.toml") {
        Ok(scene) => scene,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return;
        }
    };
    let shown = show(&scene);
    let again = parse(&shown, "fuzz.toml").unwrap_or_else(|error| panic!("what is shown is refused: {error}"));
    assert_eq!(show(&again), shown);
    assert_eq!(Scene { source: scene.source.clone(), ..again }, scene);

    let short = Scene {
        integrator: Integrator { max_steps: STEPS.min(scene.integrator.max_steps), ..scene.integrator },
        engine: Engine {
            max_steps: STEPS.min(scene.engine.max_steps),
            iterations: scene.engine.iterations.min(50),
            ..scene.engine
        },
        log: LogRates { numeric_hz: scene.log.numeric_hz.min(SAMPLES / scene.duration_s) },
        ..scene
    };
    for model in [Model::Analytic, Model::Engine] {
        if let Err(error) = run(model, &short, &mut ()) {
            assert!(!error.to_string().is_empty());
        }
    }
}
