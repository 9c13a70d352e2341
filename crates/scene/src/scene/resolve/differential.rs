//! One motor for two fingers.

use super::super::check::Checker;
use super::super::raw::Raw;
use super::super::table::differential::Seesaw;
use super::super::{Differential, Side};
use super::drive;
use super::sizing::Sized;

/// The motor at the input, sized for both fingers, and the seesaw.
pub fn differential(c: &mut Checker<'_>, raw: &Raw, seesaw: Seesaw, sized: Sized) -> Option<Differential> {
    let whole = raw.whole();
    for side in Side::BOTH.map(Side::word) {
        let why = "with a [differential], whose input is the only motor: give it in [motor]";
        c.unused_at(&format!("{side}.motor"), whole.inner(side).span("motor"), why);
    }
    let mut motor = drive::motor(c, &whole.inner("motor"), sized)?;
    motor.inertia_kg_m2 += seesaw.input_inertia_kg_m2;
    Some(Differential { motor, seesaw_inertia_kg_m2: seesaw.seesaw_inertia_kg_m2 })
}
