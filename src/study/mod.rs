//! Studies: how results depend on settings and on designs.
//!
//! | module | content |
//! |---|---|
//! | `bisect` | bisection |
//! | `capture` | positioning errors that a gripper captures |
//! | `posture` | text form of a gripper's posture |
//! | `hold` | largest acceleration under which a gripper holds its object |
//! | `parts` | sweeps distributed over several machines: parts of a study and their merge |
//! | `pool` | thread pool of the studies |
//! | `quantity` | short names and common units of columns and keys |
//! | `results` | incremental storage of sweep results |
//! | `select` | selection and ranking of the designs of a sweep |
//! | `size` | sizing of spring and motor for the finger of a scene |
//! | `sweep` | parameter sweeps over fields of a scene |

mod bisect;
pub mod capture;
pub mod hold;
pub mod parts;
mod pool;
pub mod posture;
pub mod quantity;
pub mod results;
pub mod select;
pub mod size;
pub mod sweep;

use crate::scene::Scene;
use crate::scene::keywords::SceneKind;
use bisect::bisect;

/// Returns the scene if it is of a gripper. Messages call it `name` and suggest `example`.
///
/// # Errors
/// Returns an error if the scene is of another kind.
pub fn require_gripper(scene: Scene, name: &str, example: &str) -> Result<Scene, String> {
    match scene.kind() {
        SceneKind::Gripper => Ok(scene),
        _ => Err(format!(
            "{name} is not a gripper; this study requires a scene of kind = \"gripper\", such as {example}"
        )),
    }
}
