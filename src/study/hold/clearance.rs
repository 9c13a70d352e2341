//! A table that a load would press the object against: it would hold it there, and no limit of the hand would be found.

use super::error::HoldError;
use super::load::{Case, Load};
use super::plan::{Loads, Plan};
use super::prepared::Prepared;
use crate::numeric::elementary::sin_cos;
use crate::shape::support;

/// Clearance that is no contact, m: as much as the object may sink in the hand.
const CLEAR_M: f64 = 0.5e-3;
/// At so many places of a load its clearance is looked at.
const PLACES: usize = 1000;
/// How finely the largest load is found that keeps clear, as part of itself.
const FINELY: f64 = 1e-3;

/// The largest load of each case: that of the plan, or the largest that keeps the object clear of the table. The scene's own move may
/// begin and end there.
///
/// # Errors
/// The smallest load of the plan does not keep clear.
pub(super) fn highest(prepared: &Prepared, plan: &Plan, cases: &[Case]) -> Result<Vec<f64>, HoldError> {
    let one = |case: &Case| {
        let clear = |peak_m_s2: f64| is_clear(prepared, &case.load(&prepared.stage, peak_m_s2));
        if plan.loads == Loads::Move || clear(plan.to_m_s2) {
            return Ok(plan.to_m_s2);
        }
        let (mut low, mut high) = (plan.from_m_s2 * (1.0 + FINELY), plan.to_m_s2);
        if !clear(low) {
            return Err(HoldError::Table { peak_m_s2: plan.from_m_s2 });
        }
        while high - low > FINELY * low {
            let middle = (low * high).sqrt();
            *(if clear(middle) { &mut low } else { &mut high }) = middle;
        }
        Ok(low)
    };
    cases.iter().map(one).collect()
}

/// Whether the object, where it lies in the hand, stays above the table from when loads begin.
fn is_clear(prepared: &Prepared, load: &Load) -> bool {
    let Some(table) = &prepared.scene.system.table else { return true };
    let object = prepared.scene.system.grasped();
    let (object, begins_s) = (object.placed(), prepared.stage.begins_s);
    (0..=PLACES).all(|index| {
        let time_s = begins_s + (load.over_s - begins_s) * index as f64 / PLACES as f64;
        let [_, height, turn] = load.motion.pose(time_s).place;
        let (sin, cos) = sin_cos(turn);
        let [x, y] = object.centre_m;
        height + sin * x + cos * y + support(&object, [sin, cos]).distance < table.level_m - CLEAR_M
    })
}
