//! Shipped scenes of one finger, and what they are with friction that holds.

use phalanx::law::Bristle;
use phalanx::scene::{self, Scene};

/// A scene whose friction holds, by bristles of the default: the damping of the normal law, let go in a millisecond.
pub fn hold(mut scene: Scene) -> Scene {
    for law in scene.finger_mut().contact.both_mut() {
        let damping_n_s_per_m = law.normal.damping_max_n_s_per_m;
        let friction = law.friction.as_mut().expect("friction");
        friction.bristle = Some(Bristle { damping_n_s_per_m, relaxation_s: 1e-3 });
    }
    scene
}

/// A shipped scene whose friction is made to hold.
pub fn holding(name: &str) -> Scene {
    hold(scene::load(format!("scenes/{name}.toml")).unwrap_or_else(|error| panic!("{error}")))
}
