//! The analytic model of any list of fingers and discs: the equations of motion of each, a block mass matrix, and
//! contacts that add Jᵀf.
//!
//! Coordinates are (q11, q21) of every finger, with a left finger seen in its mirror image, then (x, y, θ) of every
//! moving disc, including driven ones, in the frame of the palm. If the palm moves, time follows as a coordinate of
//! rate 1. If friction has bristles, the next rates are the bristle states σ; nothing depends on the coordinates at
//! these indices. The remaining indices are unused. The model is independent of the engine model, which it checks.
//!
//! | file | contents |
//! |---|---|
//! | `size` | number of coordinates and contacts of a system |
//! | `components` | constant data of fingers, discs and contacts |
//! | `drive` | motors and brakes |
//! | `model` | constant data of a system, and the layout of its coordinates |
//! | `coordinates` | coordinates that a finger, a disc or a contact depends on |
//! | `laws` | laws of one contact |
//! | `contact_kinematics` | gaps, the rows that give their rates, and contact forces |
//! | `contacts` | kinematics of any contact in one state, in all coordinates |
//! | `inertia` | the block mass matrix and its inverse |
//! | `frame` | a moving palm: inertial forces and the table in its frame |
//! | `forces` | accelerations |
//! | `active_contacts` | loads of links and contacts with derivatives, independent of the system's size |
//! | `derivatives` | exact Jacobian of the accelerations, assembled from fingers and contacts |
//! | `events` | branches of the laws, and where they change |
//! | `evaluation` | one contact, and the energies, in one state |

mod active_contacts;
mod components;
mod contact_kinematics;
mod contacts;
mod coordinates;
mod derivatives;
mod drive;
mod evaluation;
mod events;
mod forces;
mod frame;
mod inertia;
mod laws;
mod model;
mod size;

pub use model::Multibody;
pub use size::{MAX_SIZES, Size, TooLarge, count_moving_discs};

use crate::analytic::finger_events::first_impact_step;
use crate::analytic::mode;
use crate::analytic::model::normal_force_on_branch;

/// Largest number of fingers: a right and a left one.
const FINGERS: usize = 2;

/// Number of quadratures of a system: the normal impulse of each contact, the work of all contact forces and brakes,
/// and the work of motors, palm and driven discs.
pub const fn quadratures(contacts: usize) -> usize {
    contacts + 2
}

/// Number of event functions of a system. The normal laws of all contacts come first, then friction laws, then dampers.
pub const fn event_function_count(contacts: usize) -> usize {
    3 * contacts
}
