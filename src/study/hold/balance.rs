//! What contact forces can balance at rest, beside what is held in motion.

use super::load::Case;
use super::prepared::Prepared;
use crate::criteria::{Driven, held_at_rest};
use crate::numeric::elementary::sin_cos;
use crate::scene::{Axis, Scene};
use crate::statics::{Balanced, balanced_acceleration};
use crate::trace::Sample;

/// The largest acceleration that some contact forces balance with the hand at rest, as much the one way as back again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AtRest {
    /// Not even a palm at rest is balanced.
    Nothing,
    UpTo {
        acceleration_m_s2: f64,
    },
    /// However large.
    Any,
}

/// The quasi-static limit of a load, by what presses in a sample; `None` of loads that turn the palm or change their direction, and
/// where statics has no answer. Brakes that have gripped hold as much as they do; where a motor has none, all give their torque alone.
pub(super) fn at_rest(prepared: &Prepared, sample: &Sample, case: &Case) -> Option<AtRest> {
    let (sin, cos) = match case {
        Case::Pulse { direction_rad, .. } => sin_cos(*direction_rad),
        Case::Vibration { axis: Axis::X, .. } => (0.0, 1.0),
        Case::Vibration { axis: Axis::Y, .. } => (1.0, 0.0),
        Case::Vibration { axis: Axis::Angle, .. } | Case::Move => return None,
    };
    let driven = if is_blocked(&prepared.scene, prepared.stage.begins_s) { Driven::Blocked } else { Driven::AtTorque };
    let hand = held_at_rest(&prepared.scene, sample, driven)?;
    // Whatever is accelerated one way is braked the other way.
    let ways = [[cos, sin], [-cos, -sin]].map(|way| balanced_acceleration(&hand, way).map(|found| found.largest));
    let [Ok(there), Ok(back)] = ways else { return None };
    Some(match (there, back) {
        (Balanced::Nothing, _) | (_, Balanced::Nothing) => AtRest::Nothing,
        (Balanced::Any, Balanced::Any) => AtRest::Any,
        (there, back) => AtRest::UpTo {
            acceleration_m_s2: [there, back]
                .iter()
                .filter_map(Balanced::acceleration_m_s2)
                .fold(f64::INFINITY, f64::min),
        },
    })
}

/// Whether all that drives the fingers has a brake that has gripped by then and stays so.
fn is_blocked(scene: &Scene, time_s: f64) -> bool {
    scene.cycle().blocked_s.iter().all(|blocked_s| blocked_s.is_some_and(|blocked_s| blocked_s <= time_s))
}
