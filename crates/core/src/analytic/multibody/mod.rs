//! The analytic model of any list of fingers and discs: the equations of motion of each, masses in blocks, and contacts that add Jᵀf.
//!
//! Coordinates are (q11, q21) of every finger, of a left one those of its mirror image, then (x, y, θ) of every disc that moves, driven
//! ones too, in the frame of the palm; where the palm moves, time itself comes next, of rate 1. Where
//! friction holds, the rates behind it are the bristles' memories σ: of coordinates that nothing depends on. Behind them there may be room
//! that nothing uses. Independent of the engine model, which it checks.
//!
//! | file | job |
//! |---|---|
//! | `size` | how many coordinates and contacts a system has |
//! | `parts` | fingers, discs and contacts, and what of them does not change in time |
//! | `drive` | motors and brakes |
//! | `model` | all of that of a system, and where everything is among the coordinates |
//! | `coordinates` | which coordinates a part depends on |
//! | `laws` | what answers in one contact |
//! | `touch` | gaps and the rows that give their rates, and the forces there |
//! | `contacts` | any contact in one state, in all coordinates |
//! | `inertia` | the mass matrix by its blocks, and what solves it |
//! | `frame` | a palm that moves: what is felt there, and the table as it is seen from there |
//! | `forces` | accelerations |
//! | `pressing` | what links and contacts do, with slopes, whatever size the whole has |
//! | `slopes` | their exact Jacobian, put together from that of every finger and contact |
//! | `modes` | branches of the laws, and where they change |
//! | `reading` | one contact, and the energies, in one state |

mod contacts;
mod coordinates;
mod drive;
mod forces;
mod frame;
mod inertia;
mod laws;
mod model;
mod modes;
mod parts;
mod pressing;
mod reading;
mod size;
mod slopes;
mod touch;

pub use model::Multibody;
pub use size::{ROOM, Size, TooMany, of_discs};

use crate::analytic::mode;
use crate::analytic::model::branch;
use crate::analytic::modes::first_step;

/// Fingers that there may be: a right one and a left one.
const FINGERS: usize = 2;

/// Quadratures carried along with so many contacts: their normal impulses, the work of all contact forces and brakes, and that of whatever
/// moves motors, palm and driven discs.
pub const fn quadratures(contacts: usize) -> usize {
    contacts + 2
}

/// Guards of so many contacts: of their normal laws, then of their slips, then of their dampers.
pub const fn guards(contacts: usize) -> usize {
    3 * contacts
}
