//! Quasi-static limit of a load: the acceleration that contact forces can balance at rest.

use super::load::LoadCase;
use super::prepared::PreparedScene;
use crate::criteria::{DriveMode, sampled_hand_at_rest};
use crate::numeric::elementary::sin_cos;
use crate::scene::{Axis, Scene};
use crate::statics::{AccelerationLimit, balanced_acceleration};
use crate::trace::Sample;

/// Largest acceleration that contact forces can balance with the hand at rest, in both directions along a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StaticLimit {
    /// Even a palm at rest is not balanced.
    Infeasible,
    UpTo {
        acceleration_m_s2: f64,
    },
    /// Any acceleration is balanced.
    Unlimited,
}

/// Returns the quasi-static limit of a load for the active contacts of a sample; `None` for loads that rotate the palm
/// or change their direction, and where statics has no solution. Engaged brakes hold up to their torque; if a motor has
/// no engaged brake, all motors apply only their actuation torque.
pub(super) fn static_limit(prepared: &PreparedScene, sample: &Sample, case: &LoadCase) -> Option<StaticLimit> {
    let (sin, cos) = match case {
        LoadCase::Pulse { direction_rad, .. } => sin_cos(*direction_rad),
        LoadCase::Vibration { axis: Axis::X, .. } => (0.0, 1.0),
        LoadCase::Vibration { axis: Axis::Y, .. } => (1.0, 0.0),
        LoadCase::Vibration { axis: Axis::Angle, .. } | LoadCase::Move => return None,
    };
    let driven =
        if is_blocked(&prepared.scene, prepared.setup.start_s) { DriveMode::Blocked } else { DriveMode::AtTorque };
    let hand = sampled_hand_at_rest(&prepared.scene, sample, driven)?;
    // A load accelerates in one direction and brakes in the other.
    let limits = [[cos, sin], [-cos, -sin]]
        .map(|direction| balanced_acceleration(&hand, direction).map(|balance| balance.largest));
    let [Ok(forward), Ok(backward)] = limits else { return None };
    Some(match (forward, backward) {
        (AccelerationLimit::Infeasible, _) | (_, AccelerationLimit::Infeasible) => StaticLimit::Infeasible,
        (AccelerationLimit::Unlimited, AccelerationLimit::Unlimited) => StaticLimit::Unlimited,
        (forward, backward) => StaticLimit::UpTo {
            acceleration_m_s2: [forward, backward]
                .iter()
                .filter_map(AccelerationLimit::acceleration_m_s2)
                .fold(f64::INFINITY, f64::min),
        },
    })
}

/// Returns whether every motor has a brake that is engaged at `time_s`.
fn is_blocked(scene: &Scene, time_s: f64) -> bool {
    scene.cycle().blocked_s.iter().all(|blocked_s| blocked_s.is_some_and(|blocked_s| blocked_s <= time_s))
}
