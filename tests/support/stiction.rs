//! Shipped scenes of one finger with stiction.

use phalanx::law::Bristle;
use phalanx::scene::{self, Scene};

/// Adds stiction to the contacts of a finger: default bristles, with the damping of the normal law and a relaxation
/// time of 1 ms.
pub fn with_stiction(mut scene: Scene) -> Scene {
    for law in scene.finger_mut().contact.both_mut() {
        let damping_n_s_per_m = law.normal.damping_max_n_s_per_m;
        let friction = law.friction.as_mut().expect("friction");
        friction.bristle = Some(Bristle { damping_n_s_per_m, relaxation_s: 1e-3 });
    }
    scene
}

/// Loads a shipped scene and adds stiction to its contacts.
pub fn load_with_stiction(name: &str) -> Scene {
    with_stiction(scene::load(format!("scenes/{name}.toml")).unwrap_or_else(|error| panic!("{error}")))
}
