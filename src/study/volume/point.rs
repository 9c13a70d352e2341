//! One point of a volume: a design, sized, closed on the object and in equilibrium.

use crate::gripper::{
    Design, DesignError, FinalPosture, Finger, GraspError, Lengths, MassError, Placement, ProximalLength, Spring,
    SpringKind, bodies_with, final_posture, lengths, total_mass,
};
use crate::scene::Template;
use crate::sizing::{Rule, Sizing, SizingError, size};
use crate::statics::{Equilibrium, StaticsError, drive_loads, equilibrium, form_closure};

/// Why there is no finger at a point.
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

/// What a finger is, whatever the friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sized {
    pub lengths: Lengths,
    /// Of all four bodies.
    pub mass_kg: f64,
    pub sizing: Sizing,
    /// Whether the grasp is form-closed (1.15)–(1.19).
    pub form_closed: bool,
}

/// A finger that holds the object, with a coefficient of friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    pub sized: Sized,
    pub forces: Equilibrium,
}

impl State {
    /// Force positiveness: neither phalanx would have to pull.
    pub fn is_stable(&self) -> bool {
        self.forces.is_force_positive()
    }

    /// Stable, and the object is pressed on the palm: PFP ≥ 0.
    pub fn is_palm_positive(&self) -> bool {
        self.is_stable() && self.forces.is_palm_force_positive()
    }

    /// Stable and form-closed.
    pub fn is_form_closed(&self) -> bool {
        self.is_stable() && self.sized.form_closed
    }
}

/// A point of a volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Place of l21 within the range its base allows, 0 … 1.
    pub l21_fraction: f64,
    pub phi22_rad: f64,
    /// r_l = l22/l11.
    pub arm_ratio: f64,
    /// The finger in equilibrium, or why there is none.
    pub state: Result<State, NoFinger>,
}

/// The design at a point of the volume of one base.
pub fn design(template: &Template, base_m: f64, [l21_fraction, phi22_rad, arm_ratio]: [f64; 3]) -> Design {
    Design { base_m, l21: ProximalLength::Fraction(l21_fraction), phi22_rad, arm_ratio, ..template.design }
}

/// A finger on the object, before friction comes in: what all coefficients have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closed {
    pub finger: Finger,
    pub end: FinalPosture,
    pub sized: Sized,
    /// τ_a + τ_s at the final posture.
    loads_n_m: [f64; 2],
}

/// Builds, sizes and closes the finger of a design. Nothing is allocated on the way but by the certificate of form closure.
///
/// # Errors
/// Why the design has no finger, or none that can be sized.
pub fn close(template: &Template, design: &Design, rule: Rule) -> Result<Closed, NoFinger> {
    let lengths = lengths(design)?;
    let bodies = bodies_with(&lengths, template.density_kg_m3, template.depth_m, &template.overrides)?;
    let finger = Finger { lengths, bodies, assembly: template.assembly };
    let task = template.task(design);
    let sizing = size(&finger, &task, rule)?;
    let end = final_posture(&lengths, finger.assembly, task.object)?;
    let kind = SpringKind::Constant { torque_n_m: sizing.spring_n_m };
    let spring = Spring { kind, placement: Placement::Phalanges };
    let loads_n_m = drive_loads(&finger, &end, sizing.motor_n_m, Some(&spring))?;
    let form_closed = form_closure(&finger, &end)?.closed;
    let sized = Sized { lengths, mass_kg: total_mass(&bodies), sizing, form_closed };
    Ok(Closed { finger, end, sized, loads_n_m })
}

/// The forces of a closed finger with a coefficient of friction.
pub fn hold(closed: &Closed, mu_static: f64) -> Result<State, NoFinger> {
    let forces = equilibrium(&closed.finger, &closed.end, closed.loads_n_m, mu_static)?;
    Ok(State { sized: closed.sized, forces })
}
