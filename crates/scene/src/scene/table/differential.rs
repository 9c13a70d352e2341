//! `[differential]`: the drive of two fingers by one motor.

use super::settings;
use crate::scene::check::NOT_NEGATIVE;
use crate::scene::value_kinds::{Flag, Inertia};

/// Settings of the differential, which may be absent.
#[derive(Clone, Copy, Debug)]
pub struct DifferentialSettings {
    pub present: bool,
    pub input_inertia_kg_m2: f64,
    pub seesaw_inertia_kg_m2: f64,
}

impl DifferentialSettings {
    fn if_present(&mut self) -> Option<&mut Self> {
        self.present.then_some(self)
    }
}

settings! {
    /// A differential (seesaw) with [motor] at its input; each finger gets half of the torque. An empty section
    /// suffices to add it.
    DifferentialSettings = Self { present: true, input_inertia_kg_m2: 0.0, seesaw_inertia_kg_m2: 0.0 }, d;
    /// Whether there is a differential.
    "present": Flag = Some(&mut d.present);
    /// Inertia of the parts that rotate with the input, by the mean angle of both driven links; added to the inertia of
    /// [motor].
    "input_inertia": Inertia = d.if_present().map(|d| &mut d.input_inertia_kg_m2), allowed(NOT_NEGATIVE), default_text("0 kg*m^2"),
        depends_on("present", "with present = false");
    /// Inertia of the seesaw, which rotates by half the difference of the angles of both driven links.
    "seesaw_inertia": Inertia = d.if_present().map(|d| &mut d.seesaw_inertia_kg_m2), allowed(NOT_NEGATIVE), default_text("0 kg*m^2"),
        depends_on("present", "with present = false");
}
