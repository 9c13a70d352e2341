//! Tests of the analytic model: mechanism, laws, integrator, events.
//!
//! All of them are one program, because linking takes most of the build time of a test program.

#[path = "../support/mod.rs"]
mod support;

mod actuator_work;
mod cables;
mod contact_definition;
mod contact_geometry;
mod drives;
mod finger;
mod first_touch;
mod gradient;
mod grasp_tracker;
mod gripper;
mod gripper_criteria;
mod hands_in_code;
mod invariants;
mod jacobian;
mod joint_forces;
mod laws_bodies;
mod laws_bristle;
mod laws_forces;
mod laws_scenes;
mod lift_off;
mod mechanism;
mod mechanism_stiction;
mod moving_base;
mod newton_euler;
mod prescribed;
mod shipped_gradients;
mod simulation;
mod singularity;
mod sizes;
