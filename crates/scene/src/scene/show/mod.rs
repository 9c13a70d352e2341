//! Formats a scene as a complete scene file, as simulated or as written. It parses back to the same scene bit for bit,
//! except for `source`.
//!
//! | file | contents |
//! |---|---|
//! | `system` | the sections of the system |
//! | `finger` | the sections of a finger |
//! | `law` | contact laws |
//! | `with_defaults` | a scene as written, with its defaults |
//! | `toml_writer` | the writer |

mod finger;
mod law;
mod system;
mod toml_writer;
mod with_defaults;

pub use toml_writer::TomlWriter;
pub use with_defaults::show_written;

use super::keywords::SceneKind;
use super::table::scene::SceneSettings;
use super::table::{SettingsSection, show as show_table};
use super::{Bounds, Scene};

/// Returns the scene as simulated, with all values.
pub fn show(scene: &Scene) -> String {
    write_scene(scene, TomlWriter::new(scene.kind()))
}

fn write_scene(scene: &Scene, mut out: TomlWriter) -> String {
    out.comment("Scene with every default filled in; masses and lengths as simulated.");
    let top = SceneSettings {
        name: scene.name.clone(),
        description: scene.description.clone(),
        duration_s: scene.duration_s,
        gravity_m_s2: scene.system.gravity_m_s2,
        palm: scene.system.palm.is_some(),
        palm_width_m: scene.system.palm_width_m,
        ..SceneSettings::defaults_for(scene.kind())
    };
    system::write_system(&mut out, &top, &scene.system);
    show_table(&mut out, "integrator", &scene.integrator);
    show_table(&mut out, "engine", &scene.engine);
    // A program may have shortened the run.
    let bounds = Bounds { until_s: scene.bounds.until_s.min(scene.duration_s), ..scene.bounds };
    show_table(&mut out, "validate", &bounds);
    if scene.kind() == SceneKind::Gripper {
        show_table(&mut out, "criteria", &scene.thresholds);
    }
    show_table(&mut out, "log", &scene.log);
    out.text
}
