//! A single run, dispatched by the kind of its scene.

use super::Study;
use super::finger_run::run_finger;
use super::gripper_run::run_gripper;
use super::row::{Cells, Row};
use crate::scene::keywords::SceneKind;
use crate::table::Value;

/// Performs one run of a study; `None` if it was interrupted.
pub(super) fn run_one(study: &Study, run: u64, keep_running: &(dyn Fn() -> bool + Sync)) -> Option<Row> {
    let values = study.field_values(run);
    let text = study.fill(&values);
    let numbers = [Value::Integer(run as i64), Value::Integer(study.design(run) as i64)];
    let cells =
        Cells::new(study.kind, numbers.into_iter().chain(values.into_iter().map(|value| value.value)).collect());
    match study.kind {
        SceneKind::Gripper => run_gripper(study, run, &text, cells, keep_running),
        _ => run_finger(study, run, &text, cells, keep_running),
    }
}
