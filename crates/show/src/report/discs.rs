//! The discs of a run, or the object of a gripper, under the keys of the JSON document.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::scene::{DiscMotion, Scene};
use crate::trace::BodyState;

/// A disc at the end of the run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DiscReport {
    /// `free`, `driven` or `fixed`.
    pub motion: &'static str,
    pub x_m: f64,
    pub y_m: f64,
    pub angle_rad: f64,
    pub vx_m_s: f64,
    pub vy_m_s: f64,
    pub spin_rad_s: f64,
}

/// Discs that have these names, in order, or the object of a gripper; how they move is `unknown` without a scene that has them.
pub fn discs(names: &[String], scene: Option<&Scene>, states: &[BodyState]) -> BTreeMap<String, DiscReport> {
    let motion = |name: &str| match scene?.system.discs.iter().find(|disc| disc.name == name)?.motion {
        DiscMotion::Fixed => Some("fixed"),
        DiscMotion::Driven { .. } => Some("driven"),
        DiscMotion::Free { .. } => Some("free"),
    };
    let report = |motion, state: &BodyState| DiscReport {
        motion,
        x_m: state.centre_m[0],
        y_m: state.centre_m[1],
        angle_rad: state.angle_rad,
        vx_m_s: state.velocity_m_s[0],
        vy_m_s: state.velocity_m_s[1],
        spin_rad_s: state.spin_rad_s,
    };
    let discs = names.iter().zip(states);
    discs.map(|(name, state)| (name.clone(), report(motion(name).unwrap_or("unknown"), state))).collect()
}
