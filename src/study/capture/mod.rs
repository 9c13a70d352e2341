//! Positioning errors that a gripper captures (thesis §4.2.1.3): its object is placed at increasing offsets from the
//! middle of the palm.
//!
//! Motors, springs and initial postures are those of one gripper, designed for the largest error; only the position of
//! the object varies. The object is *captured* if it is held at the end of the run
//! ([held](crate::criteria::Fate::Held)). The results also answer an open question of the thesis: whether the grasp
//! would be form-closed if the object did not move, and whether the final grasp is.
//!
//! | file | content |
//! |---|---|
//! | `place` | one position of the object: form closure there, run, outcome |
//! | `loader` | scene with its object at an offset |
//! | `edge` | limits of the captured range, by bisection |

mod edge;
mod loader;
mod placement;

use std::sync::atomic::{AtomicU64, Ordering};

use crate::scene::{Scene, SceneError};
use crate::study::pool;
use crate::trace::Model;

pub use edge::Edge;
pub use loader::SceneSource;
pub use placement::{Placement, RunOutcome};

/// Settings of a capture study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    pub model: Model,
    /// Largest positioning error in either direction, m.
    pub error_m: f64,
    /// Number of positions over the range including both ends and the middle: odd, at least 3.
    pub position_count: usize,
    /// Tolerance of the edges, m.
    pub tolerance_m: f64,
}

/// Result of a capture study.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    pub scene: String,
    pub plan: Plan,
    pub palm_width_m: f64,
    /// Placements from left to right.
    pub placements: Vec<Placement>,
    /// The range about the middle in which the object is captured; `None` if it is not captured in the middle.
    pub captured_range: Option<[Edge; 2]>,
}

/// Error during a capture study.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error("interrupted after {done} of {total} positions")]
    Stopped { done: u64, total: u64 },
}

/// Loads the scene with its object at an offset, designed for the largest error of the plan.
pub type SceneLoader<'a> = &'a (dyn Fn(f64) -> Result<Scene, SceneError> + Sync);

/// Simulates all positions on all cores and locates the edges. `on_progress` is called with the number of finished
/// positions and the total.
///
/// # Errors
/// Returns an error if the scene is invalid in the middle or at either end, or `keep_running` returned false.
pub fn capture(
    plan: Plan,
    load: SceneLoader<'_>,
    on_progress: &mut (dyn FnMut(u64, u64) + Send),
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Result<Capture, CaptureError> {
    let middle = load(0.0)?;
    for end in [-plan.error_m, plan.error_m] {
        load(end)?;
    }
    let half = (plan.position_count / 2) as f64;
    let offsets: Vec<f64> =
        (0..plan.position_count).map(|index| plan.error_m * ((index as f64 - half) / half)).collect();
    let (total, done) = (offsets.len() as u64, AtomicU64::new(0));
    let results = pool::map(
        0,
        &offsets,
        |offset_m, messages| {
            let placement = placement::simulate_placement(plan.model, *offset_m, load, keep_running);
            // The receiver may have been dropped.
            let _ = messages.send(done.fetch_add(1, Ordering::Relaxed) + 1);
            placement
        },
        |finished| on_progress(finished, total),
    );
    let interrupted = || CaptureError::Stopped { done: done.load(Ordering::Relaxed), total };
    let placements: Vec<Placement> = results.into_iter().collect::<Option<_>>().ok_or_else(interrupted)?;
    let captured_range = edge::find_edges(&plan, &placements, load, keep_running).ok_or_else(interrupted)?;
    Ok(Capture { scene: middle.name, plan, palm_width_m: middle.system.palm_width_m, placements, captured_range })
}
