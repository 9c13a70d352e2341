//! What a point of a volume can be coloured by: the fifth dimension.

use super::point::State;

/// A quantity of a finger that holds the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Palm force positiveness (3.2).
    Pfp,
    /// Normal force of the proximal phalanx.
    F21,
    /// Normal force of the distal phalanx.
    F22,
    /// k_s.
    Spring,
    /// τ11.
    Motor,
    /// Mass of a finger.
    Mass,
    FormClosed,
}

/// What becomes of a quantity where several bases stand for one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Worst {
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

    /// On the command line and in names of files.
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

    /// Its column in tables, with the unit of the value.
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

    /// In pictures.
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

    /// Its value in SI; form closure is 1 or 0.
    pub fn value(self, state: &State) -> f64 {
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

    /// Which of several bases counts for the intersection: the weakest force, the largest torque and mass.
    pub fn worst(self) -> Worst {
        match self {
            Quantity::Spring | Quantity::Motor | Quantity::Mass => Worst::Largest,
            _ => Worst::Smallest,
        }
    }

    /// Its value in SI where all of these fingers stand for one: that of the worst of them.
    pub fn worst_of<'a>(self, states: impl IntoIterator<Item = &'a State>) -> Option<f64> {
        let values = states.into_iter().map(|state| self.value(state));
        values.reduce(match self.worst() {
            Worst::Smallest => f64::min,
            Worst::Largest => f64::max,
        })
    }
}
