//! Tests of the design work: sizing, statics, sweeps, selection, reproduction.
//!
//! The tests form one program, because linking dominates the build time of test programs.

#[path = "../support/mod.rs"]
mod support;

mod assembly;
mod cable_statics;
mod closure;
mod form_closure;
mod grasp_firmness;
mod grasp_roles;
mod gripper_balance;
mod gripper_design;
mod gripper_posture;
mod hold;
mod hold_mechanism;
mod mechanism_balance;
mod mechanism_grasp;
mod offsets;
mod optimisation;
mod reproduce;
mod select;
mod shapes;
mod sizing;
mod statics_command;
mod statics_forces;
mod statics_simulated;
mod sweep_resume;
mod sweep_runs;
mod sweep_scenes;
mod sweep_shards;
mod sweep_study;
mod table;
