//! One point of a volume: a design, sized, closed on the object and in equilibrium, and its quantities.

use crate::gripper::{
    Design, DesignError, FinalPosture, Finger, GraspError, Lengths, MassError, Placement, ProximalLength, Spring,
    SpringKind, bodies_with_overrides, final_posture, lengths, total_mass,
};
use crate::scene::Template;
use crate::sizing::{Rule, Sizing, SizingError, Task, size};
use crate::statics::{Equilibrium, StaticsError, drive_loads, equilibrium, form_closure};

/// Reason why no finger exists at a point.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoFinger {
    #[error(transparent)]
    Design(#[from] DesignError),
    #[error(transparent)]
    Mass(#[from] MassError),
    #[error(transparent)]
    Grasp(#[from] GraspError),
    #[error(transparent)]
    Sizing(#[from] SizingError),
    #[error(transparent)]
    Statics(#[from] StaticsError),
}

/// Data of a sized finger that are the same for all friction coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizedFinger {
    pub lengths: Lengths,
    /// Mass of all four bodies, kg.
    pub mass_kg: f64,
    pub sizing: Sizing,
    /// Whether the grasp is form-closed, equations (1.15)–(1.19).
    pub form_closed: bool,
}

/// A finger in equilibrium on the object, for one friction coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraspState {
    pub sized: SizedFinger,
    pub forces: Equilibrium,
}

impl GraspState {
    /// Returns whether the grasp is force-positive: no contact force is tensile.
    pub fn is_stable(&self) -> bool {
        self.forces.is_force_positive()
    }

    /// Returns whether the grasp is stable and presses the object onto the palm: PFP ≥ 0.
    pub(crate) fn is_palm_positive(&self) -> bool {
        self.is_stable() && self.forces.is_palm_force_positive()
    }

    /// Returns whether the grasp is stable and form-closed.
    pub fn is_form_closed(&self) -> bool {
        self.is_stable() && self.sized.form_closed
    }
}

/// A point of a volume: the finger in equilibrium, or the reason why none exists.
pub type Point = Result<GraspState, NoFinger>;

/// Returns the design at a point of the volume of one base.
pub fn design_at(template: &Template, base_m: f64, [l21_fraction, phi22_rad, arm_ratio]: [f64; 3]) -> Design {
    Design { base_m, l21: ProximalLength::Fraction(l21_fraction), phi22_rad, arm_ratio, ..template.design }
}

/// A finger closed on the object; the same for all friction coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosedFinger {
    pub finger: Finger,
    pub end: FinalPosture,
    pub sized: SizedFinger,
    /// τ_a + τ_s at the final posture.
    loads_n_m: [f64; 2],
}

/// Builds and sizes the finger of a design, and closes it on the object. Only the form-closure certificate allocates
/// memory.
///
/// # Errors
/// Returns an error if the design has no finger, or if the finger cannot be sized.
pub fn close_finger(template: &Template, design: &Design, rule: Rule) -> Result<ClosedFinger, NoFinger> {
    let lengths = lengths(design)?;
    let bodies = bodies_with_overrides(&lengths, template.density_kg_m3, template.depth_m, &template.overrides)?;
    close_linkage(Finger { lengths, bodies, assembly: template.assembly }, &template.task(design), rule)
}

/// Sizes a finger for a closing motion and closes it on the object.
///
/// # Errors
/// Returns an error if the finger cannot be sized or cannot grasp the object.
pub(crate) fn close_linkage(finger: Finger, task: &Task, rule: Rule) -> Result<ClosedFinger, NoFinger> {
    let Finger { lengths, bodies, assembly } = finger;
    let sizing = size(&finger, task, rule)?;
    let end = final_posture(&lengths, assembly, task.object)?;
    let kind = SpringKind::Constant { torque_n_m: sizing.spring_n_m };
    let spring = Spring { kind, placement: Placement::Phalanges };
    let loads_n_m = drive_loads(&finger, &end, sizing.motor_n_m, Some(&spring))?;
    let form_closed = form_closure(&finger, &end)?.closed;
    let sized = SizedFinger { lengths, mass_kg: total_mass(&bodies), sizing, form_closed };
    Ok(ClosedFinger { finger, end, sized, loads_n_m })
}

/// Returns the equilibrium of a closed finger for one friction coefficient.
pub fn solve_grasp(closed: &ClosedFinger, mu_static: f64) -> Point {
    let forces = equilibrium(&closed.finger, &closed.end, closed.loads_n_m, mu_static)?;
    Ok(GraspState { sized: closed.sized, forces })
}

/// A column of the table of points: its name with the unit, and a function that returns its value in SI units, or a
/// property.
pub type Column<T> = (&'static str, fn(&GraspState) -> T);

/// Quantities of a point.
pub const COLUMNS: [Column<f64>; 11] = [
    ("l11_m", |state| state.sized.lengths.l11_m),
    ("l12_m", |state| state.sized.lengths.l12_m),
    ("l21_m", |state| state.sized.lengths.l21_m),
    ("l22_m", |state| state.sized.lengths.l22_m),
    ("t22_m", |state| state.sized.lengths.t22_m),
    ("mass_kg", |state| state.sized.mass_kg),
    ("motor_n_m", |state| state.sized.sizing.motor_n_m),
    ("spring_n_m", |state| state.sized.sizing.spring_n_m),
    ("static_f21_n", |state| state.forces.f21_n),
    ("static_f22_n", |state| state.forces.f22_n),
    ("static_pfp_n", |state| state.forces.pfp_n),
];

/// Properties of a point.
pub const FLAGS: [Column<bool>; 3] = [
    ("force_positive", GraspState::is_stable),
    ("palm_force_positive", |state| state.forces.is_palm_force_positive()),
    ("form_closed", |state| state.sized.form_closed),
];

/// A quantity of a finger in equilibrium on the object that is shown as a colour.
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

    /// Returns three names: the key on the command line and in file names, the column in tables, and the label in
    /// plots.
    pub fn names(self) -> [&'static str; 3] {
        match self {
            Quantity::Pfp => ["pfp", "static_pfp_n", "palm force PFP"],
            Quantity::F21 => ["f21", "static_f21_n", "proximal force F21"],
            Quantity::F22 => ["f22", "static_f22_n", "distal force F22"],
            Quantity::Spring => ["spring", "spring_n_m", "spring torque k_s"],
            Quantity::Motor => ["motor", "motor_n_m", "motor torque τ11"],
            Quantity::Mass => ["mass", "mass_kg", "mass of a finger"],
            Quantity::FormClosed => ["form-closed", "form_closed", "form closure"],
        }
    }

    /// Returns the value in SI units; form closure is 1 or 0.
    pub fn value(self, state: &GraspState) -> f64 {
        let [_, column, _] = self.names();
        match COLUMNS.iter().find(|(name, _)| *name == column) {
            Some((_, value)) => value(state),
            None => f64::from(u8::from(state.sized.form_closed)),
        }
    }

    /// Whether the largest value of several bases counts for the intersection, as for torques and masses, and not the
    /// smallest one.
    pub(crate) fn is_largest_worst(self) -> bool {
        matches!(self, Quantity::Spring | Quantity::Motor | Quantity::Mass)
    }
}
