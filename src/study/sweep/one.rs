//! One run: its scene's text, made by what its kind asks for.

use super::Study;
use super::one_finger::of_finger;
use super::one_gripper::of_gripper;
use super::row::{Cells, Row};
use crate::scene::words::SceneKind;
use crate::table::Value;

/// Makes one run of a study; `None` if it was told to stop.
pub(super) fn one(study: &Study, run: u64, go_on: &(dyn Fn() -> bool + Sync)) -> Option<Row> {
    let points = study.points(run);
    let text = study.fill(&points);
    let first = [Value::Integer(run as i64), Value::Integer(study.design(run) as i64)];
    let cells = Cells::new(study.kind, first.into_iter().chain(points.into_iter().map(|point| point.value)).collect());
    match study.kind {
        SceneKind::Gripper => of_gripper(study, run, &text, cells, go_on),
        _ => of_finger(study, run, &text, cells, go_on),
    }
}
