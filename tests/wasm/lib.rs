//! What a page asks of the core: scenes in, figures out, nothing of the system in between.

use phalanx_core::scene;
use phalanx_core::trace::{Model, run};

fn q11_rad(model: Model) -> f64 {
    let scene = scene::parse(include_str!("../../scenes/experiment-95.toml"), "experiment-95.toml").expect("a scene");
    run(model, &scene, &mut ()).expect("the run ends").last.finger().q11_rad
}

#[unsafe(no_mangle)]
pub extern "C" fn analytic_q11_rad() -> f64 {
    q11_rad(Model::Analytic)
}

#[unsafe(no_mangle)]
pub extern "C" fn engine_q11_rad() -> f64 {
    q11_rad(Model::Engine)
}
