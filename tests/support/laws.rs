//! Scenes built in code, most of them of discs, and runs of them in both models.

pub use super::runs::CollectSink;
use super::runs::run_model;
use phalanx::law::{ContactLaw, FrictionKind, FrictionLaw, NormalLaw};
use phalanx::mechanism::Mechanism;
use phalanx::scene::keywords::SceneKind;
use phalanx::scene::{
    Bounds, Disc, DiscMotion, Discs, Engine, Hand, Integrator, LogSettings, Preset, Scene, Stepping, Thresholds,
};
use phalanx::trace::{Model, Outcome};

pub const BOTH_MODELS: [Model; 2] = [Model::Analytic, Model::Engine];

/// Spring k = 1e8 N/m^2.2 and damper of the thesis (Table 3.2).
pub const THESIS_NORMAL: NormalLaw = NormalLaw::step(1e8, 2.2, 1e6, 1e-5);

/// Friction law of the thesis (Table 3.2, μ_d = 0.7 μ_s).
pub const THESIS_FRICTION: FrictionLaw = FrictionLaw {
    mu_static: 0.8,
    mu_dynamic: 0.56,
    v_static_m_s: 0.1,
    v_dynamic_m_s: 0.2,
    kind: FrictionKind::Regularised,
};

pub fn spring(stiffness_n_per_m_e: f64, exponent: f64) -> NormalLaw {
    NormalLaw::step(stiffness_n_per_m_e, exponent, 0.0, 1e-5)
}

pub fn disc(name: &str, radius_m: f64, centre_m: [f64; 2], motion: DiscMotion) -> Disc {
    Disc { name: name.to_string(), radius_m, centre_m, motion }
}

/// A free disc at a velocity, without spin; without an inertia it does not rotate.
pub fn free(mass_kg: f64, inertia_kg_m2: Option<f64>, velocity_m_s: [f64; 2]) -> DiscMotion {
    DiscMotion::Free { mass_kg, inertia_kg_m2, velocity_m_s, spin_rad_s: 0.0 }
}

/// A free disc of 1 kg without rotation.
pub fn free_translation(velocity_m_s: [f64; 2]) -> DiscMotion {
    free(1.0, None, velocity_m_s)
}

pub fn driven(velocity_m_s: [f64; 2], acceleration_m_s2: [f64; 2]) -> DiscMotion {
    DiscMotion::Driven { velocity_m_s, acceleration_m_s2, spin_rad_s: 0.0 }
}

/// A scene of fingers built in code, with reference integrator settings, the default engine and default bounds.
pub fn scene_of(hand: Hand, duration_s: f64) -> Scene {
    let kind = if hand.fingers.len() == 1 { SceneKind::Finger } else { SceneKind::Gripper };
    Scene { kind, hand, mechanism: None, ..mechanism_scene(Mechanism::default(), duration_s) }
}

/// The same for a mechanism.
pub fn mechanism_scene(mechanism: Mechanism, duration_s: f64) -> Scene {
    Scene {
        name: "in-code".to_string(),
        kind: SceneKind::Mechanism,
        description: String::new(),
        source: String::new(),
        bounds: Bounds::defaults_for_run(SceneKind::Mechanism, duration_s),
        grasp: None,
        hand: EMPTY,
        mechanism: Some(mechanism),
        duration_s,
        integrator: Integrator::preset(Preset::Reference),
        engine: Engine::DEFAULT,
        thresholds: Thresholds::NONE,
        log: LogSettings { numeric_hz: 1e4, picture_hz: 5e3, joint_forces: false },
    }
}

/// A system without bodies.
pub const EMPTY: Hand = Hand::EMPTY;

/// A scene of discs without gravity and half plane.
pub fn scene(discs: Vec<Disc>, normal: NormalLaw, friction: Option<FrictionLaw>, duration_s: f64) -> Scene {
    disc_scene(discs, ContactLaw { normal, friction }, None, duration_s)
}

/// A scene of discs above a half plane at y = 0.
pub fn scene_on_plane(discs: Vec<Disc>, normal: NormalLaw, friction: Option<FrictionLaw>, duration_s: f64) -> Scene {
    disc_scene(discs, ContactLaw { normal, friction }, Some(0.0), duration_s)
}

fn disc_scene(discs: Vec<Disc>, law: ContactLaw, half_plane_m: Option<f64>, duration_s: f64) -> Scene {
    let discs = Discs { discs, half_plane_m, law, gravity_m_s2: [0.0; 2] };
    let mut scene = mechanism_scene(discs.mechanism(), duration_s);
    scene.kind = SceneKind::Bodies;
    scene.bounds = Bounds { position_m: 1e-6, contact_time_s: 1e-6, impulse: 1e-3, ..scene.bounds };
    scene
}

/// The mechanism of a scene without fingers.
pub fn mechanism(scene: &mut Scene) -> &mut Mechanism {
    scene.mechanism.as_mut().expect("a mechanism")
}

/// Returns the law of all contacts of a scene of discs.
pub fn contact_law(scene: &Scene) -> ContactLaw {
    scene.mechanism.as_ref().expect("a mechanism").contacts[0].law
}

/// Applies `change` to the law of all contacts of a scene of discs.
pub fn change_contact_law(scene: &mut Scene, change: impl Fn(&mut ContactLaw)) {
    mechanism(scene).contacts.iter_mut().for_each(|pair| change(&mut pair.law));
}

/// The scene with a log rate at which the engine reports samples at its steps only; between steps it interpolates
/// forces.
pub fn sampled_at_steps(model: Model, mut scene: Scene) -> Scene {
    if model == Model::Engine {
        scene.log.numeric_hz = 1.0 / scene.duration_s;
    }
    scene
}

/// The scene with fixed engine steps of `step_s`.
pub fn with_fixed_step(scene: &Scene, step_s: f64) -> Scene {
    let mut scene = scene.clone();
    scene.engine.stepping = Stepping::Fixed { step_s };
    scene
}

/// Runs a scene, which must reach its end.
#[track_caller]
pub fn run_to_end(model: Model, scene: &Scene) -> (Outcome, CollectSink) {
    let (outcome, log) = run_model(model, scene);
    let times: Vec<f64> = log.samples.iter().map(|sample| sample.time_s).collect();
    assert!(times.is_sorted(), "{}: samples out of order", model.name());
    assert_eq!(times.first(), Some(&0.0));
    assert_eq!(times.last(), Some(&scene.duration_s));
    (outcome, log)
}

/// A free disc of 1 kg that hits a fixed one head on after 1 ms.
pub fn impact_scene(normal: NormalLaw, speed: f64, duration_s: f64) -> Scene {
    let discs = vec![
        disc("anvil", 0.1, [0.1, 0.0], DiscMotion::Fixed),
        disc("hammer", 0.05, [-0.05 - 1e-3 * speed, 0.0], free_translation([speed, 0.0])),
    ];
    scene(discs, normal, None, duration_s)
}

/// |found/expected − 1|.
pub fn relative_error(actual: f64, expected: f64) -> f64 {
    (actual / expected - 1.0).abs()
}
