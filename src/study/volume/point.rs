//! One point of a volume: a design, sized, closed on the object and in equilibrium.

use crate::gripper::{
    Design, DesignError, FinalPosture, Finger, GraspError, Lengths, MassError, Placement, ProximalLength, Spring,
    SpringKind, bodies_with_overrides, final_posture, lengths, total_mass,
};
use crate::scene::Template;
use crate::sizing::{Rule, Sizing, SizingError, size};
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

/// Data of a sized finger that do not depend on friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizedFinger {
    pub lengths: Lengths,
    /// Mass of all four bodies.
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
    pub fn is_palm_positive(&self) -> bool {
        self.is_stable() && self.forces.is_palm_force_positive()
    }

    /// Returns whether the grasp is stable and form-closed.
    pub fn is_form_closed(&self) -> bool {
        self.is_stable() && self.sized.form_closed
    }
}

/// A point of a volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Position of l21 within the range that the base allows, from 0 to 1.
    pub l21_fraction: f64,
    pub phi22_rad: f64,
    /// r_l = l22/l11.
    pub arm_ratio: f64,
    /// The finger in equilibrium, or the reason why none exists.
    pub state: Result<GraspState, NoFinger>,
}

/// Returns the design at a point of the volume of one base.
pub fn design_at(template: &Template, base_m: f64, [l21_fraction, phi22_rad, arm_ratio]: [f64; 3]) -> Design {
    Design { base_m, l21: ProximalLength::Fraction(l21_fraction), phi22_rad, arm_ratio, ..template.design }
}

/// A finger closed on the object; common to all friction coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosedFinger {
    pub finger: Finger,
    pub end: FinalPosture,
    pub sized: SizedFinger,
    /// τ_a + τ_s at the final posture.
    loads_n_m: [f64; 2],
}

/// Builds, sizes and closes the finger of a design. Only the form-closure certificate allocates memory.
///
/// # Errors
/// Returns an error if the design has no finger, or the finger cannot be sized.
pub fn close_finger(template: &Template, design: &Design, rule: Rule) -> Result<ClosedFinger, NoFinger> {
    let lengths = lengths(design)?;
    let bodies = bodies_with_overrides(&lengths, template.density_kg_m3, template.depth_m, &template.overrides)?;
    let finger = Finger { lengths, bodies, assembly: template.assembly };
    let task = template.task(design);
    let sizing = size(&finger, &task, rule)?;
    let end = final_posture(&lengths, finger.assembly, task.object)?;
    let kind = SpringKind::Constant { torque_n_m: sizing.spring_n_m };
    let spring = Spring { kind, placement: Placement::Phalanges };
    let loads_n_m = drive_loads(&finger, &end, sizing.motor_n_m, Some(&spring))?;
    let form_closed = form_closure(&finger, &end)?.closed;
    let sized = SizedFinger { lengths, mass_kg: total_mass(&bodies), sizing, form_closed };
    Ok(ClosedFinger { finger, end, sized, loads_n_m })
}

/// Returns the equilibrium of a closed finger for one friction coefficient.
pub fn solve_grasp(closed: &ClosedFinger, mu_static: f64) -> Result<GraspState, NoFinger> {
    let forces = equilibrium(&closed.finger, &closed.end, closed.loads_n_m, mu_static)?;
    Ok(GraspState { sized: closed.sized, forces })
}
