//! The differential, by which one motor drives two fingers.

use super::super::check::Checker;
use super::super::scene_input::SceneInput;
use super::super::table::differential::DifferentialSettings;
use super::super::{Differential, Side};
use super::drive;
use super::sizing::SizingResult;

/// Reads the motor at the input, sized for both fingers, and the seesaw.
pub fn differential(
    checker: &mut Checker<'_>,
    input: &SceneInput,
    differential_settings: DifferentialSettings,
    sized: SizingResult,
) -> Option<Differential> {
    let root_input = input.top_level();
    for side in Side::BOTH.map(Side::name) {
        let reason = "with a [differential], which is driven by the motor in [motor]";
        checker.report_unused_at(&format!("{side}.motor"), root_input.subsection(side).span("motor"), reason);
    }
    let mut motor = drive::motor(checker, &root_input.subsection("motor"), sized)?;
    motor.inertia_kg_m2 += differential_settings.input_inertia_kg_m2;
    Some(Differential { motor, seesaw_inertia_kg_m2: differential_settings.seesaw_inertia_kg_m2 })
}
