//! Quantities of the points of a volume, shown as colours.

use super::point::GraspState;

/// A quantity of a finger in equilibrium on the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Palm force positiveness (3.2).
    Pfp,
    /// Normal force of the proximal phalanx.
    F21,
    /// Normal force of the distal phalanx.
    F22,
    /// Spring torque k_s.
    Spring,
    /// Motor torque τ11.
    Motor,
    /// Mass of a finger.
    Mass,
    FormClosed,
}

/// Worst value of a quantity over several bases.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorstCase {
    Smallest,
    Largest,
}

impl Quantity {
    pub const ALL: [Quantity; 7] = [
        Quantity::Pfp,
        Quantity::F21,
        Quantity::F22,
        Quantity::Spring,
        Quantity::Motor,
        Quantity::Mass,
        Quantity::FormClosed,
    ];

    /// Returns the key on the command line and in file names.
    pub fn key(self) -> &'static str {
        match self {
            Quantity::Pfp => "pfp",
            Quantity::F21 => "f21",
            Quantity::F22 => "f22",
            Quantity::Spring => "spring",
            Quantity::Motor => "motor",
            Quantity::Mass => "mass",
            Quantity::FormClosed => "form-closed",
        }
    }

    /// Returns the column name in tables, with the unit.
    pub fn column(self) -> &'static str {
        match self {
            Quantity::Pfp => "static_pfp_n",
            Quantity::F21 => "static_f21_n",
            Quantity::F22 => "static_f22_n",
            Quantity::Spring => "spring_n_m",
            Quantity::Motor => "motor_n_m",
            Quantity::Mass => "mass_kg",
            Quantity::FormClosed => "form_closed",
        }
    }

    /// Returns the label in plots.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Pfp => "palm force PFP",
            Quantity::F21 => "proximal force F21",
            Quantity::F22 => "distal force F22",
            Quantity::Spring => "spring torque k_s",
            Quantity::Motor => "motor torque τ11",
            Quantity::Mass => "mass of a finger",
            Quantity::FormClosed => "form closure",
        }
    }

    /// Returns the value in SI units; form closure is 1 or 0.
    pub fn value(self, state: &GraspState) -> f64 {
        match self {
            Quantity::Pfp => state.forces.pfp_n,
            Quantity::F21 => state.forces.f21_n,
            Quantity::F22 => state.forces.f22_n,
            Quantity::Spring => state.sized.sizing.spring_n_m,
            Quantity::Motor => state.sized.sizing.motor_n_m,
            Quantity::Mass => state.sized.mass_kg,
            Quantity::FormClosed => f64::from(u8::from(state.sized.form_closed)),
        }
    }

    /// Returns which value of several bases counts for the intersection: the smallest force, the largest torque or
    /// mass.
    pub fn worst(self) -> WorstCase {
        match self {
            Quantity::Spring | Quantity::Motor | Quantity::Mass => WorstCase::Largest,
            _ => WorstCase::Smallest,
        }
    }

    /// Returns the worst value of several fingers in SI units.
    pub fn worst_value<'a>(self, states: impl IntoIterator<Item = &'a GraspState>) -> Option<f64> {
        let values = states.into_iter().map(|state| self.value(state));
        values.reduce(match self.worst() {
            WorstCase::Smallest => f64::min,
            WorstCase::Largest => f64::max,
        })
    }
}
