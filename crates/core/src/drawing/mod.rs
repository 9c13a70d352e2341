//! What a scene looks like: the shapes of its bodies, each in its own frame, and where these frames are at an instant.
//!
//! The pictures in a log and the page with the moving finger are both drawn from this, so they show the same bodies.
//!
//! | file | job |
//! |---|---|
//! | `finger` | links, phalanges, object and palm |
//! | `discs` | discs and the half plane |
//! | `gripper` | two fingers, their object, palm and table |

mod discs;
mod finger;
mod gripper;
mod parts;

use discs::{disc_motions, disc_poses, discs};
pub use finger::finger_poses_at;
use finger::{finger, finger_motions, finger_poses};
use gripper::{gripper, gripper_motions, gripper_poses};

pub use parts::{Body, Drawing, Part, Pose, Shape};

use crate::trace::{Sample, Simulated};

impl Drawing {
    /// Of a scene of any kind.
    pub fn of<'a>(scene: impl Into<Simulated<'a>>) -> Self {
        match scene.into() {
            Simulated::Finger(scene) => finger(scene),
            Simulated::Discs(scene) => discs(scene),
            Simulated::Gripper(scene) => gripper(scene),
        }
    }

    /// Length of the arrow of a force, with its sign.
    pub fn arrow_m(&self, force_n: f64) -> f64 {
        (force_n * self.arrow_m_per_n).clamp(-self.longest_arrow_m, self.longest_arrow_m)
    }

    /// The longer side of the view.
    pub fn view_m(&self) -> f64 {
        let [low, high] = self.extent_m;
        (high[0] - low[0]).max(high[1] - low[1])
    }
}

/// Where the bodies of a scene's [`Drawing`] are, in their order.
pub fn poses<'a>(scene: impl Into<Simulated<'a>>, sample: &Sample) -> Vec<Pose> {
    match scene.into() {
        Simulated::Finger(scene) => finger_poses(scene, sample.finger()),
        Simulated::Discs(scene) => disc_poses(scene, &sample.bodies),
        Simulated::Gripper(scene) => gripper_poses(scene, sample),
    }
}

/// How fast these change: velocities and angular velocities in place of positions and angles.
pub fn motions<'a>(scene: impl Into<Simulated<'a>>, sample: &Sample) -> Vec<Pose> {
    match scene.into() {
        Simulated::Finger(scene) => finger_motions(scene, sample.finger()),
        Simulated::Discs(scene) => disc_motions(scene, &sample.bodies),
        Simulated::Gripper(scene) => gripper_motions(scene, sample),
    }
}
