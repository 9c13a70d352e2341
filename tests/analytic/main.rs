//! Tests of the analytic model: mechanism, laws, integrator, events.
//!
//! One program for the room: linking is most of what a test program costs.

#[path = "../support/mod.rs"]
mod support;

mod anchor;
mod carried;
mod contact_definition;
mod contact_geometry;
mod dynamics_independent;
mod energy;
mod finger_held;
mod gripper;
mod gripper_criteria;
mod held;
mod invariants;
mod jacobian;
mod landing;
mod laws_bodies;
mod laws_bristle;
mod laws_driven;
mod laws_impact;
mod laws_jacobian;
mod laws_scenes;
mod lists;
mod singularity;
mod time_reversal;
mod torque_steps;
