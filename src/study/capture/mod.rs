//! Which positioning errors a gripper captures (thesis §4.2.1.3): its object, placed further and further off the middle of the palm.
//!
//! Motors, springs and starts are those of one gripper, made for the largest error; only where the object lies differs from run to
//! run. The object is *captured* where it is held when the run ends ([held](crate::criteria::Fate::Held)). Beside where it ends stands the thesis' open
//! question: would the grasp be form-closed if the object stayed where it lies, and is the one that the unbalanced forces make of it?
//!
//! | file | job |
//! |---|---|
//! | `place` | one place of the object: the grasp it would have, the run, what came of it |
//! | `loader` | the scene with its object there |
//! | `edge` | how far from the middle it is captured, by bisection |

mod edge;
mod loader;
mod place;

use std::sync::atomic::{AtomicU64, Ordering};

use crate::scene::{Scene, SceneError};
use crate::study::pool;
use crate::trace::Model;

pub use edge::Edge;
pub use loader::Source;
pub use place::{Found, Placed};

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    pub model: Model,
    /// Largest positioning error, either way.
    pub error_m: f64,
    /// Places over the whole range, both ends and the middle among them: an odd number from 3.
    pub places: usize,
    /// How finely edges are found.
    pub tolerance_m: f64,
}

/// What a gripper captures.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    pub scene: String,
    pub plan: Plan,
    pub palm_width_m: f64,
    /// From left to right.
    pub placed: Vec<Placed>,
    /// The range about the middle in which the object is captured; `None` if it is not captured in the middle.
    pub captured: Option<[Edge; 2]>,
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error("it was stopped after {done} of {total} places")]
    Stopped { done: u64, total: u64 },
}

/// The scene with its object at a place, for errors up to that of the plan.
pub type Load<'a> = &'a (dyn Fn(f64) -> Result<Scene, SceneError> + Sync);

/// Tries all places, on all cores, and finds the edges; `tell` hears how many places are done, and of how many.
///
/// # Errors
/// The scene is refused in the middle or at either end, or `go_on` said no.
pub fn capture(
    plan: Plan,
    load: Load<'_>,
    tell: &mut (dyn FnMut(u64, u64) + Send),
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Capture, CaptureError> {
    let middle = load(0.0)?;
    for end in [-plan.error_m, plan.error_m] {
        load(end)?;
    }
    let half = (plan.places / 2) as f64;
    let offsets: Vec<f64> = (0..plan.places).map(|index| plan.error_m * ((index as f64 - half) / half)).collect();
    let (total, done) = (offsets.len() as u64, AtomicU64::new(0));
    let found = pool::map(
        0,
        &offsets,
        |offset_m, notes| {
            let placed = place::place(plan.model, *offset_m, load, go_on);
            // Whoever asked may be gone.
            let _ = notes.send(done.fetch_add(1, Ordering::Relaxed) + 1);
            placed
        },
        |now| tell(now, total),
    );
    let stopped = || CaptureError::Stopped { done: done.load(Ordering::Relaxed), total };
    let placed: Vec<Placed> = found.into_iter().collect::<Option<_>>().ok_or_else(stopped)?;
    let captured = edge::edges(&plan, &placed, load, go_on).ok_or_else(stopped)?;
    Ok(Capture { scene: middle.name, plan, palm_width_m: middle.system.palm_width_m, placed, captured })
}
