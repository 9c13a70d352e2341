//! Scene that is ready for loads.

use super::load::LoadSetup;
use crate::scene::Scene;

/// Reason for the start time of the loads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StartReason {
    /// The start time was requested.
    Requested,
    /// All holding contacts are closed, the brakes are engaged, and the object stays slower than
    /// [`REST_SPEED_M_S`](super::REST_SPEED_M_S).
    AtRest,
    /// The scene ends while the object still moves.
    StillMoving { speed_m_s: f64 },
    /// The first of the scene's moves has ended and the brakes are engaged.
    MoveCompleted,
    /// The scene's first own move starts.
    OwnMove,
}

/// Common start of all runs.
#[derive(Clone, Debug, PartialEq)]
pub struct PreparedScene {
    /// Scene without palm motion, with the drives fixed from the start of the loads.
    pub scene: Scene,
    pub setup: LoadSetup,
    pub start_reason: StartReason,
}
