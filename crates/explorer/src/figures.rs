//! Entry point for tests of the core: results of both models for two scenes, without any system interface.

use std::sync::OnceLock;

use phalanx_core::scene::parse_any;
use phalanx_core::trace::{Model, run};

const SCENES: [&str; 2] =
    [include_str!("../../../scenes/experiment-95.toml"), include_str!("../../../scenes/gripper/design-95.toml")];
const MODELS: [Model; 2] = [Model::Analytic, Model::Engine];

/// Returns angles and rates of each finger at the end, then position, angle and rates of each body, then the impulse of
/// each contact.
fn final_values(scene: &str, model: Model) -> Vec<f64> {
    let scene = parse_any(scene, "scene.toml").expect("a scene");
    let outcome = run(model, &scene, &mut ()).expect("the run ends");
    let angles = outcome.last.fingers().flat_map(|f| [f.q11_rad, f.q21_rad, f.q22_rad, f.qd11_rad_s, f.qd21_rad_s]);
    let bodies = outcome.last.bodies().flat_map(|body| {
        let ([x, y], [vx, vy]) = (body.centre_m, body.velocity_m_s);
        [x, y, body.angle_rad, vx, vy, body.spin_rad_s]
    });
    angles.chain(bodies).chain(outcome.contacts.iter().map(|contact| contact.impulse_n_s)).collect()
}

/// Returns the result `index` of a scene and a model; NaN if `index` is beyond the last result.
#[unsafe(export_name = "figure")]
pub extern "C" fn final_value(scene: usize, model: usize, index: usize) -> f64 {
    static RESULTS: OnceLock<[[Vec<f64>; 2]; 2]> = OnceLock::new();
    let results = RESULTS.get_or_init(|| SCENES.map(|scene| MODELS.map(|model| final_values(scene, model))));
    results[scene][model].get(index).copied().unwrap_or(f64::NAN)
}
