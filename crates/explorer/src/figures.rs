//! What the tests ask of the core: scenes in, figures of both models out, nothing of the system in between.

use std::sync::OnceLock;

use phalanx_core::scene::parse_any;
use phalanx_core::trace::{Model, run};

const SCENES: [&str; 2] =
    [include_str!("../../../scenes/experiment-95.toml"), include_str!("../../../scenes/gripper/design-95.toml")];
const MODELS: [Model; 2] = [Model::Analytic, Model::Engine];

/// Angles and rates of each finger at the end, then place, angle and rates of each body, then the impulse of each contact.
fn figures(scene: &str, model: Model) -> Vec<f64> {
    let scene = parse_any(scene, "scene.toml").expect("a scene");
    let outcome = run(model, &scene, &mut ()).expect("the run ends");
    let fingers = &outcome.last.fingers;
    let angles = fingers.iter().flat_map(|f| [f.q11_rad, f.q21_rad, f.q22_rad, f.qd11_rad_s, f.qd21_rad_s]);
    let bodies = outcome.last.bodies.iter().flat_map(|body| {
        let ([x, y], [vx, vy]) = (body.centre_m, body.velocity_m_s);
        [x, y, body.angle_rad, vx, vy, body.spin_rad_s]
    });
    angles.chain(bodies).chain(outcome.contacts.iter().map(|contact| contact.impulse_n_s)).collect()
}

/// One of the figures of a scene by a model; NaN beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn figure(scene: usize, model: usize, index: usize) -> f64 {
    static FOUND: OnceLock<[[Vec<f64>; 2]; 2]> = OnceLock::new();
    let found = FOUND.get_or_init(|| SCENES.map(|scene| MODELS.map(|model| figures(scene, model))));
    found[scene][model].get(index).copied().unwrap_or(f64::NAN)
}
