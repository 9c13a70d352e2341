//! Tests of the analytic model: mechanism, laws, integrator, events.
//!
//! All of them are one program, because linking takes most of the build time of a test program.

#[path = "../support/mod.rs"]
mod support;

mod contact_definition;
mod contact_geometry;
mod energy;
mod event_location;
mod experiment_95;
mod finger_stiction;
mod gripper;
mod gripper_criteria;
mod gripper_stiction;
mod invariants;
mod jacobian;
mod joint_forces;
mod laws_bodies;
mod laws_bristle;
mod laws_driven;
mod laws_impact;
mod laws_jacobian;
mod laws_scenes;
mod mixed_systems;
mod moving_palm;
mod newton_euler;
mod singularity;
mod time_reversal;
mod torque_steps;
