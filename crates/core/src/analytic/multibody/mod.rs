//! The analytic model of two fingers with their object: the equations of motion of each, a block mass matrix, and
//! contacts that add Jᵀf.
//!
//! Coordinates are (q11, q21) of every finger, with a left finger seen in its mirror image, then (x, y, θ) of a moving
//! object, in the frame of the palm. If the palm moves, time follows as a coordinate of rate 1. If friction has bristles,
//! the next rates are the bristle states σ; nothing depends on the coordinates at these indices. The remaining indices
//! are unused. The model is independent of the engine model, which it checks.

pub(in crate::analytic) mod components;
pub(in crate::analytic) mod contact_kinematics;
mod evaluation;
mod events;
mod forces;
mod frame;
mod model;

use crate::analytic::contact::{ContactMode, Mode, first_impact_step, normal_force_on_branch};
use crate::integrator::Fixed;
use crate::scene::HandContact;

pub(crate) use evaluation::kinematics_of;
pub use model::Multibody;

/// A right and a left finger.
const FINGERS: usize = 2;

/// Largest number of positions of two fingers: four angles, the pose of the object, and time.
const GRASP_POSITIONS: usize = 2 * FINGERS + 4;

/// Largest number of bristles of two fingers, in contacts and brakes.
pub const MAX_GRASP_BRISTLES: usize = 8;

/// Number of coordinates of two fingers whose contacts or brakes have bristles.
pub const MAX_GRASP_COORDINATES: usize = GRASP_POSITIONS + MAX_GRASP_BRISTLES;

/// Number of contacts of two fingers, in the order of [`HandContact::ALL`].
pub const CONTACTS: usize = HandContact::ALL.len();

/// Number of quadratures: the normal impulse of each contact, the work of all contact forces and brakes, and the work of
/// motors and palm.
pub const QUADRATURES: usize = CONTACTS + 2;

/// Number of event functions. The normal laws of all contacts come first, then friction laws, then dampers.
pub const EVENT_FUNCTIONS: usize = 3 * CONTACTS;

/// Branches of the laws of all contacts.
pub type GraspMode = Mode<[ContactMode; CONTACTS]>;

/// Sizes of the model with N coordinates.
pub type GraspLayout<const N: usize> = Fixed<N, QUADRATURES>;
