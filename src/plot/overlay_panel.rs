//! Panels of two runs: what each shows.

use super::theme::{BLUE, Colour, GREEN, ORANGE, PURPLE};
use crate::trace::Sample;

/// One quantity of a panel.
pub(super) struct Quantity {
    pub name: String,
    pub colour: Colour,
    pub value: Box<dyn Fn(&Sample) -> f64>,
}

/// One panel.
pub(super) struct Panel {
    pub label: &'static str,
    pub log: bool,
    pub quantities: Vec<Quantity>,
}

pub(super) fn quantity(name: &str, colour: Colour, value: impl Fn(&Sample) -> f64 + 'static) -> Quantity {
    Quantity { name: name.to_string(), colour, value: Box::new(value) }
}

/// Energies of a scene with fingers.
pub(super) fn energies() -> Panel {
    Panel {
        label: "energy, mJ",
        log: false,
        quantities: vec![
            quantity("kinetic", BLUE, |s| s.energy.kinetic_j * 1e3),
            quantity("motor work", ORANGE, |s| s.energy.motor_work_j * 1e3),
            quantity("dissipated", GREEN, |s| s.energy.dissipated_j * 1e3),
            quantity("balance", PURPLE, |s| s.energy.balance_j * 1e3),
        ],
    }
}
