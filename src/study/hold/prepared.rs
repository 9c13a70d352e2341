//! The scene up to where loads begin.

use super::load::Stage;
use crate::scene::Scene;

/// Why loads begin when they do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Since {
    /// It was asked for.
    Given,
    /// All contacts that hold do so, brakes have gripped, and the object is slower than [`REST_M_S`](super::REST_M_S) from then on.
    Rest,
    /// The scene ends, and the object still moves at so many m/s.
    Moving { speed_m_s: f64 },
    /// The first of the scene's moves is over, and brakes have gripped.
    Moved,
    /// The scene's own moves begin.
    OwnMove,
}

/// What all runs begin with.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// Without motion, and with drives that stay as they are when loads begin.
    pub scene: Scene,
    pub stage: Stage,
    pub since: Since,
}
