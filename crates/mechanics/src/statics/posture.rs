//! Kinematics of the five-bar at rest: link directions and passive rates.

use super::StaticsError;
use crate::fivebar::kinematics::{Directions, PassiveRates, SINGULAR_SINE, passive_rates};
use crate::gripper::{FinalPosture, Finger, Posture};
use crate::numeric::elementary::{cos, sin};
use crate::numeric::plane::cross;

/// |∂q22/∂q11| below which the motor cannot move the tip.
const DEAD_POINT_SLOPE: f64 = 1e-9;

/// Kinematic quantities of one posture.
#[derive(Clone, Copy, Debug)]
pub struct StaticKinematics {
    pub pose: Directions<f64>,
    pub rates: PassiveRates<f64>,
    /// ∂q22/∂(q11, q21). Their sum is 0: l11 and l21 rotate about the same joint, so equal rates of both rotate the
    /// finger as one body.
    pub tip_slope: [f64; 2],
}

/// Link directions and passive rates of the final posture.
///
/// # Errors
/// Returns [`StaticsError::InLine`] if l12 and l22 are in line, [`StaticsError::DeadPoint`] if l11 and l12 are in line.
pub fn static_kinematics(finger: &Finger, end: &FinalPosture) -> Result<StaticKinematics, StaticsError> {
    static_kinematics_at(finger, &end.posture)
}

/// [`static_kinematics`] for any posture.
pub(crate) fn static_kinematics_at(finger: &Finger, q: &Posture) -> Result<StaticKinematics, StaticsError> {
    let e = |angle: f64| [cos(angle), sin(angle)];
    let pose =
        Directions { e1: e(q.q11_rad), e2: e(q.q21_rad), e3: e(q.q11_rad + q.q12_rad), e4: e(q.q21_rad + q.q22_rad) };
    let sine = cross(pose.e3, pose.e4);
    if sine.is_nan() || sine.abs() < SINGULAR_SINE {
        return Err(StaticsError::InLine { sine });
    }
    let rates = passive_rates(&finger.lengths, &pose);
    let tip_slope = [rates.a4[0], rates.a4[1] - 1.0];
    if tip_slope[0].is_nan() || tip_slope[0].abs() < DEAD_POINT_SLOPE {
        return Err(StaticsError::DeadPoint { slope: tip_slope[0] });
    }
    Ok(StaticKinematics { pose, rates, tip_slope })
}
