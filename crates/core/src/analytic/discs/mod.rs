//! The analytic model of discs: Newton's equations of a few discs, and a half plane, under the contact laws.
//!
//! Coordinates are (x, y, angle) of every disc that moves, driven ones too. Independent of the engine model, which it checks.
//!
//! | file | job |
//! |---|---|
//! | `pair` | gap, normal and rates of two surfaces |
//! | `model` | accelerations, their exact Jacobian, energies |
//! | `modes` | branches of the laws, and where they change |

mod model;
mod modes;
mod pair;

pub use model::{DiscEnergies, Discs, PAIRS, PairReading, QUADRATURES};

use super::model::branch;
use super::modes::first_step;
use super::{SiteState, mode};
use crate::scene::System;

/// Branches of all pairs, in the order of [`System::pairs`]; the rest stays free.
pub type DiscMode = mode::Mode<PAIRS>;

/// Guards of all pairs: of their normal laws, then of their slips, then of their dampers.
pub const GUARDS: usize = 3 * PAIRS;

/// Discs that may move: sizes are constants of the model.
pub const MOVING: usize = 3;

/// A scene too large for the closed-form model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{moving} discs move and {pairs} pairs of surfaces may meet; the analytic model takes up to {MOVING} moving discs and \
     {most} pairs: fix or remove some"
)]
pub struct TooMany {
    pub moving: usize,
    pub pairs: usize,
    pub most: usize,
}

/// Pairs that may hold where so many discs move: as many memories are there.
pub const HOLDING: [usize; MOVING + 1] = [0, 4, 6, 9];

/// Number of discs that move, where the model takes as many.
pub fn moving_discs(system: &System) -> Result<usize, TooMany> {
    let moving = system.discs.iter().filter(|disc| disc.motion.moves()).count();
    let pairs = system.pairs().len();
    let most = if system.holds() { HOLDING[moving.min(MOVING)] } else { PAIRS };
    if moving > MOVING || pairs > most { Err(TooMany { moving, pairs, most }) } else { Ok(moving) }
}
