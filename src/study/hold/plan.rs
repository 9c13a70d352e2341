//! What is asked.

use crate::scene::Axis;
use crate::trace::Model;

/// How long a run goes on when its load is over, s: what has lost its contacts is gone by then, and what rattles is not.
pub const AFTER_S: f64 = 30e-3;
/// Slower than this, m/s, an object is at rest in the hand: in a pulse of 40 ms it would creep by 40 µm.
pub const REST_M_S: f64 = 1e-3;

/// What moves the palm.
#[derive(Clone, Debug, PartialEq)]
pub enum Loads {
    /// In so many directions all around, each a pulse of this length.
    Pulses { directions: usize, length_s: f64 },
    /// Along each of the axes at each of the frequencies.
    Vibrations { axes: Vec<Axis>, frequencies_hz: Vec<f64> },
    /// The scene's own moves and path in another time, with its vibrations, or the standard cycle of a scene without any.
    Move,
}

/// What is asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub model: Model,
    pub loads: Loads,
    /// When they begin; `None`: when the object is at rest, or the scene's own motion says.
    pub begins_s: Option<f64>,
    /// How far the object may slip in the hand.
    pub slip_m: f64,
    /// Peak accelerations of the scan: from, to, and how many in between and at both ends, from 2.
    pub from_m_s2: f64,
    pub to_m_s2: f64,
    pub scan: usize,
    /// How finely limits are found, as part of themselves.
    pub tolerance: f64,
    /// 0: one for each core. The answer does not depend on it.
    pub threads: usize,
}

/// Whether to go on, asked once a step.
pub type GoOn<'a> = &'a (dyn Fn() -> bool + Sync);
