//! The analytic model of a gripper: two five-bars, and an object that both grasp.
//!
//! Coordinates are (q11, q21) of the right finger, (q11, q21) of the left one, which is its mirror image's, and (x, y, θ) of an object
//! that moves, in the frame of the palm; where the palm moves, time itself comes next, of rate 1. Where
//! friction holds, the rates behind it are the bristles' memories σ: of coordinates that nothing depends on. Independent of the engine
//! model, which it checks.
//!
//! | file | job |
//! |---|---|
//! | `model` | what does not change in time: fingers, drives, object, planes |
//! | `coordinates` | which coordinates a part depends on |
//! | `laws` | what answers at one place |
//! | `touch` | gaps and the rows that give their rates, of a phalanx or a plane against the object, and the forces there |
//! | `contacts` | any contact in one state, in all coordinates |
//! | `inertia` | the mass matrix by its blocks, and what solves it |
//! | `frame` | a palm that moves: what is felt there, and the table as it is seen from there |
//! | `forces` | accelerations |
//! | `slopes` | their exact Jacobian, put together from that of every finger and contact |
//! | `modes` | branches of the laws, and where they change |
//! | `reading` | one contact, and the energies, in one state |

mod contacts;
mod coordinates;
mod forces;
mod frame;
mod inertia;
mod laws;
mod model;
mod modes;
mod reading;
mod slopes;
mod touch;

pub use model::{GripperModel, start};

use crate::analytic::mode;
use crate::analytic::model::branch;
use crate::analytic::modes::first_step;
use crate::scene::Place;

/// Places where something can touch: all of [`Place::ALL`], of which a scene may lack some.
pub const PLACES: usize = Place::ALL.len();

/// Quadratures carried along: normal impulses of the places, work of all contact forces and brakes, work of the motors and of whatever
/// moves the palm.
pub const QUADRATURES: usize = PLACES + 2;

/// The last two of them.
const LOST: usize = PLACES;
const WORK: usize = PLACES + 1;

/// Guards of all places: of their normal laws, then of their slips, then of their dampers.
pub const GUARDS: usize = 3 * PLACES;

/// Branches of all places, in the order of [`Place::ALL`].
pub type GripperMode = mode::Mode<PLACES>;

/// Coordinates of both fingers; those of an object that moves come after them.
pub const FINGERS: usize = 4;

/// Where time is among the coordinates of a gripper whose palm moves.
const TIME: usize = FINGERS + 3;

/// Where the memories of bristles begin: those of four phalanges, palm and table, then of two brakes.
const MEMORY: usize = TIME + 1;
const BRAKES: usize = MEMORY + 6;

/// Coordinates where friction holds.
pub const HELD: usize = BRAKES + 2;
