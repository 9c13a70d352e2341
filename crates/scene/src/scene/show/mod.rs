//! A scene as a complete scene file, which parses back to the same scene, bit for bit (its `source` excepted): as it is
//! simulated, or as it was written.
//!
//! | file | job |
//! |---|---|
//! | `system` | its system, part by part |
//! | `finger` | a finger |
//! | `law` | the law of a contact |
//! | `written` | a scene as it was written, with its defaults |
//! | `out` | the text as it grows |

mod finger;
mod law;
mod out;
mod system;
mod written;

pub use out::Out;
pub use written::show_written;

use super::table::top::Top;
use super::table::{Table, show as show_table};
use super::words::SceneKind;
use super::{Bounds, Scene};

/// The scene with everything filled in as it is simulated.
pub fn show(scene: &Scene) -> String {
    shown(scene, Out::new(scene.kind()))
}

fn shown(scene: &Scene, mut out: Out) -> String {
    let to = &mut out;
    to.comment("Scene with every default filled in; masses and lengths as simulated.");
    let top = Top {
        name: scene.name.clone(),
        description: scene.description.clone(),
        duration_s: scene.duration_s,
        gravity_m_s2: scene.system.gravity_m_s2,
        palm: scene.system.palm.is_some(),
        palm_width_m: scene.system.palm_width_m,
        ..Top::usual_in(scene.kind())
    };
    system::system(to, &top, &scene.system);
    show_table(to, "integrator", &scene.integrator);
    show_table(to, "engine", &scene.engine);
    // A program may have shortened the run.
    let bounds = Bounds { until_s: scene.bounds.until_s.min(scene.duration_s), ..scene.bounds };
    show_table(to, "validate", &bounds);
    if scene.kind() == SceneKind::Gripper {
        show_table(to, "criteria", &scene.thresholds);
    }
    show_table(to, "log", &scene.log);
    out.text
}
