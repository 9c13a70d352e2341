//! `[differential]` between two fingers.

use super::lines;
use crate::scene::check::NOT_NEGATIVE;
use crate::scene::kinds::{Flag, Inertia};

/// One input for both fingers, or two motors.
#[derive(Clone, Copy, Debug)]
pub struct Seesaw {
    pub present: bool,
    pub input_inertia_kg_m2: f64,
    pub seesaw_inertia_kg_m2: f64,
}

impl Seesaw {
    fn part(&mut self) -> Option<&mut Self> {
        self.present.then_some(self)
    }
}

lines! {
    /// A differential (seesaw): [motor] is its input then, and each finger gets half of that torque. The section alone puts one there.
    Seesaw = Self { present: true, input_inertia_kg_m2: 0.0, seesaw_inertia_kg_m2: 0.0 }, d;
    /// Whether it is there.
    "present": Flag = Some(&mut d.present);
    /// Inertia that turns with the input, by the mean of both driven links; that of [motor] comes on top.
    "input_inertia": Inertia = d.part().map(|d| &mut d.input_inertia_kg_m2), allowed(NOT_NEGATIVE), said("0 kg*m^2"),
        beside("present", "with present = false");
    /// Inertia of the seesaw, which turns by half the difference of both driven links.
    "seesaw_inertia": Inertia = d.part().map(|d| &mut d.seesaw_inertia_kg_m2), allowed(NOT_NEGATIVE), said("0 kg*m^2"),
        beside("present", "with present = false");
}
