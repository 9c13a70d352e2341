//! Sizing of spring and motor to a test trajectory (thesis §3.3.2, spec of 2-design §2.2).
//!
//! The motor link goes from the start to the final posture in T = 10 ms on a polynomial of the 7th order. Until the proximal
//! phalanx meets the object the finger shall swing as one rigid body, which the spring must see to; then l21 rests and the tip
//! goes on. Inverse dynamics r(t) = M q̈ + c gives
//!
//! * k_s(t) = r2/|∂q_s/∂q21| in the rigid phase (3.1), and **k_s** = max k_s(t);
//! * the net motor torque τ(t) = r1 + r2 in the rigid phase, and **τ11** = RMS τ(t) by a [`Rule`].
//!
//! | file | job |
//! |---|---|
//! | `trajectory` | the polynomial, and where it is when |
//! | `closing` | start, contact and end of a finger's test trajectory |
//! | `rigid` | the finger as one rigid body: inverse dynamics in closed form |
//! | `bent` | l21 at rest on the object, the tip going on |
//! | `integral` | means and maxima over samples |
//! | `profile` | everything along the trajectory, for tables and figures |

mod bent;
mod closing;
mod error;
mod integral;
mod profile;
mod rigid;
mod task;
pub mod trajectory;

pub use closing::{Closing, closing};
pub use error::SizingError;
pub use profile::{Profile, ProfilePoint, profile};
pub use task::{CLOSING_S, OPENING_RAD, Task};

use crate::gripper::{Finger, Placement};
use crate::numeric::elementary::powi;
use integral::{Simpson, largest};
use rigid::Rigid;

/// Intervals of each phase: mean squares by Simpson's rule, the maximum refined by a parabola. Doubling them changes no torque
/// of the thesis's designs by more than 5e-8 (by [`Rule::Whole`] 1e-5: some pass near a fold of the tip) of itself (a test).
pub const INTERVALS: usize = 400;

/// Over what the motor torque is averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// RMS of the net torque r1 + r2 over the rigid phase.
    Rigid,
    /// RMS over all of T, with the constant spring acting at q22 and l21 at rest after its contact: r1 + (∂q22/∂q11) k_s.
    Whole,
}

impl Rule {
    /// As scenes and reports write it.
    pub const fn name(self) -> &'static str {
        match self {
            Rule::Rigid => "rigid",
            Rule::Whole => "whole",
        }
    }
}

/// Motor and spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizing {
    /// τ11.
    pub motor_n_m: f64,
    /// k_s, the torque of a constant spring at q22.
    pub spring_n_m: f64,
}

/// Sizes motor and spring (at q22) of a finger. The finger's assembly must be the reference one.
///
/// # Errors
/// Where the finger cannot grasp the object, or not by bending its tip after the proximal contact.
pub fn size(finger: &Finger, task: &Task, rule: Rule) -> Result<Sizing, SizingError> {
    size_with(finger, task, rule, Placement::Phalanges, INTERVALS)
}

/// [`size`] with the spring at any of its places, and any number of intervals (even, at least 2).
pub fn size_with(
    finger: &Finger,
    task: &Task,
    rule: Rule,
    placement: Placement,
    intervals: usize,
) -> Result<Sizing, SizingError> {
    let closing = closing(finger, task)?;
    let rigid = Rigid::new(finger, &closing, task.gravity_m_s2);
    let swing = Simpson::over(0.0, closing.contact_x, intervals);

    let lever = rigid.spring_lever(placement).abs();
    let needed = largest(&swing, |x| rigid.torques(&closing.trajectory.at(x))[1]).max(0.0);
    let spring_n_m = needed / lever;
    let mean_square = match rule {
        Rule::Rigid => swing.mean(|x| powi(rigid.net_torque(&closing.trajectory.at(x)), 2)),
        Rule::Whole => {
            // Wherever the spring sits, the limit's share with it makes up for the place: q22 is what must not move.
            let k_s = needed / rigid.spring_lever(Placement::Phalanges).abs();
            let before = swing.mean(|x| powi(rigid.motor_with_spring(&closing.trajectory.at(x), k_s), 2));
            let rest = Simpson::over(closing.contact_x, 1.0, intervals);
            let bent = bent::Bent::new(finger, &closing, task.gravity_m_s2);
            let after = rest.mean(|x| powi(bent.motor(&closing.trajectory.at(x), k_s), 2));
            before * closing.contact_x + after * (1.0 - closing.contact_x)
        }
    };
    let sizing = Sizing { motor_n_m: mean_square.sqrt(), spring_n_m };
    match sizing.motor_n_m.is_finite() && sizing.spring_n_m.is_finite() {
        true => Ok(sizing),
        false => Err(SizingError::Singular { q21_rad: closing.q21_contact_rad }),
    }
}
