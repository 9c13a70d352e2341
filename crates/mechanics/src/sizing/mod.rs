//! Sizing of spring and motor for a test trajectory (thesis §3.3.2, spec of 2-design §2.2).
//!
//! The motor link moves from the start to the final posture in T = 10 ms along a polynomial of the 7th order. Until the
//! proximal contact the spring must keep the finger straight, so that it swings as one rigid body; then l21 rests and
//! the tip continues. The inverse dynamics r(t) = M q̈ + c give
//!
//! * k_s(t) = r2/|∂q_s/∂q21| in the rigid phase (3.1), and **k_s** = max k_s(t);
//! * the net motor torque τ(t) = r1 + r2 in the rigid phase, and **τ11** = RMS τ(t) by a [`Rule`].
//!
//! | file | job |
//! |---|---|
//! | `trajectory` | the polynomial and its inverse |
//! | `closing` | start, contact and end of a finger's test trajectory |
//! | `rigid_phase` | the finger as one rigid body: inverse dynamics in closed form |
//! | `bending_phase` | l21 at rest on the object, the tip continuing |
//! | `integral` | means and maxima over samples |
//! | `profile` | all quantities along the trajectory, for tables and figures |

mod bending_phase;
mod closing;
mod error;
mod integral;
mod profile;
mod rigid_phase;
mod task;
pub mod trajectory;

pub use closing::{Closing, closing};
pub use error::SizingError;
pub use profile::{Profile, ProfilePoint, profile};
pub use task::{CLOSING_S, OPENING_RAD, Task};

use crate::gripper::{Finger, Placement};
use crate::numeric::elementary::powi;
use integral::{Simpson, find_maximum};
use rigid_phase::RigidPhase;

/// Number of intervals of each phase. Mean squares use Simpson's rule; the maximum is refined by a parabola. A test
/// shows that doubling the number changes the torques of the thesis designs by a relative 5e-8 at most (1e-5 for
/// [`Rule::Whole`], because some designs pass near a fold of the tip).
pub const INTERVALS: usize = 400;

/// Averaging rule of the motor torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// RMS of the net torque r1 + r2 over the rigid phase.
    Rigid,
    /// RMS over all of T, with the constant spring acting at q22 and l21 at rest after its contact: r1 + (∂q22/∂q11)
    /// k_s.
    Whole,
}

impl Rule {
    /// Name in scenes and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Rule::Rigid => "rigid",
            Rule::Whole => "whole",
        }
    }
}

/// Sized motor and spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizing {
    /// τ11.
    pub motor_n_m: f64,
    /// k_s, the torque of a constant spring at q22.
    pub spring_n_m: f64,
}

/// Sizes motor and spring (at q22) of a finger in the reference assembly mode.
///
/// # Errors
/// Returns an error if the finger cannot grasp the object, or does so without bending its tip after the proximal
/// contact.
pub fn size(finger: &Finger, task: &Task, rule: Rule) -> Result<Sizing, SizingError> {
    size_with(finger, task, rule, Placement::Phalanges, INTERVALS)
}

/// [`size`] with any placement of the spring and any number of intervals (even, at least 2).
pub fn size_with(
    finger: &Finger,
    task: &Task,
    rule: Rule,
    placement: Placement,
    intervals: usize,
) -> Result<Sizing, SizingError> {
    let closing = closing(finger, task)?;
    let rigid = RigidPhase::new(finger, &closing, task.gravity_m_s2);
    let rigid_nodes = Simpson::on_interval(0.0, closing.contact_x, intervals);

    let lever = rigid.spring_lever(placement).abs();
    let required_n_m = find_maximum(&rigid_nodes, |x| rigid.torques(&closing.trajectory.at(x))[1]).max(0.0);
    let spring_n_m = required_n_m / lever;
    let mean_square = match rule {
        Rule::Rigid => rigid_nodes.mean(|x| powi(rigid.net_torque(&closing.trajectory.at(x)), 2)),
        Rule::Whole => {
            // The placement of the spring has no influence: spring and limit together keep q22 fixed.
            let k_s = required_n_m / rigid.spring_lever(Placement::Phalanges).abs();
            let rigid_mean = rigid_nodes.mean(|x| powi(rigid.motor_with_spring(&closing.trajectory.at(x), k_s), 2));
            let bending_nodes = Simpson::on_interval(closing.contact_x, 1.0, intervals);
            let bending = bending_phase::BendingPhase::new(finger, &closing, task.gravity_m_s2);
            let bending_mean = bending_nodes.mean(|x| powi(bending.motor(&closing.trajectory.at(x), k_s), 2));
            rigid_mean * closing.contact_x + bending_mean * (1.0 - closing.contact_x)
        }
    };
    let sizing = Sizing { motor_n_m: mean_square.sqrt(), spring_n_m };
    match sizing.motor_n_m.is_finite() && sizing.spring_n_m.is_finite() {
        true => Ok(sizing),
        false => Err(SizingError::Singular { q21_rad: closing.q21_contact_rad }),
    }
}
