//! Clearance from the table. A load that presses the object against the table would test the table and not the hand.

use super::error::HoldError;
use super::load::{Load, LoadCase};
use super::plan::{Loads, Plan};
use super::prepared::PreparedScene;
use crate::numeric::elementary::sin_cos;
use crate::shape::support;

/// Minimum clearance, m: an allowance for the object sinking in the hand.
const MIN_CLEARANCE_M: f64 = 0.5e-3;
/// Number of time steps at which the clearance of a load is checked.
const SAMPLES: usize = 1000;
/// Relative tolerance of the largest load that keeps the object clear of the table.
const RELATIVE_TOLERANCE: f64 = 1e-3;

/// Returns the largest load of each case: the plan's, or the largest that keeps the object clear of the table. The
/// scene's own move is not limited, because it may start and end on the table.
///
/// # Errors
/// Returns an error if the smallest load of the plan already presses the object against the table.
pub(super) fn largest_clear_loads(
    prepared: &PreparedScene,
    plan: &Plan,
    cases: &[LoadCase],
) -> Result<Vec<f64>, HoldError> {
    let largest = |case: &LoadCase| {
        let clear = |peak_m_s2: f64| is_clear(prepared, &case.load(&prepared.setup, peak_m_s2));
        if plan.loads == Loads::Move || clear(plan.to_m_s2) {
            return Ok(plan.to_m_s2);
        }
        let (mut low, mut high) = (plan.from_m_s2 * (1.0 + RELATIVE_TOLERANCE), plan.to_m_s2);
        if !clear(low) {
            return Err(HoldError::PressedAgainstTable { peak_m_s2: plan.from_m_s2 });
        }
        while high - low > RELATIVE_TOLERANCE * low {
            let mean = (low * high).sqrt();
            *(if clear(mean) { &mut low } else { &mut high }) = mean;
        }
        Ok(low)
    };
    cases.iter().map(largest).collect()
}

/// Returns whether the object, fixed in the hand, stays clear of the table from the start of the load.
fn is_clear(prepared: &PreparedScene, load: &Load) -> bool {
    let Some(table) = &prepared.scene.system.table else { return true };
    let object = prepared.scene.system.grasped();
    let (object, start_s) = (object.placed(), prepared.setup.start_s);
    (0..=SAMPLES).all(|index| {
        let time_s = start_s + (load.end_s - start_s) * index as f64 / SAMPLES as f64;
        let [_, height, turn] = load.motion.pose(time_s).position;
        let (sin, cos) = sin_cos(turn);
        let [x, y] = object.centre_m;
        height + sin * x + cos * y + support(&object, [sin, cos]).distance < table.level_m - MIN_CLEARANCE_M
    })
}
