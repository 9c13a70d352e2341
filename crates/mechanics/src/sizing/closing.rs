//! The test trajectory of one finger: start, contact and end.

use super::trajectory::{Trajectory, inverse_position};
use super::{SizingError, Task};
use crate::gripper::{Assembly, FinalPosture, Finger, Posture, final_posture, start_posture};

/// The test trajectory of one finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closing {
    /// Start posture: straight, at rest.
    pub start: Posture,
    /// Final posture: both phalanges on the object.
    pub end: FinalPosture,
    /// Contact angle q_c21, at which l21 remains.
    pub q21_contact_rad: f64,
    /// Trajectory of q11.
    pub trajectory: Trajectory,
    /// x = t/T of the proximal contact: the end of the rigid phase.
    pub contact_x: f64,
}

impl Closing {
    /// End of the rigid phase.
    pub fn contact_s(&self) -> f64 {
        self.contact_x * self.trajectory.length_s
    }
}

/// Finds the test trajectory of a finger.
///
/// # Errors
/// Returns an error if the finger cannot grasp the object, or does so without bending its tip after the proximal
/// contact.
pub fn closing(finger: &Finger, task: &Task) -> Result<Closing, SizingError> {
    if !(task.closing_s.is_finite() && task.closing_s > 0.0) {
        return Err(SizingError::NotPositive { name: "closing_s", value: task.closing_s });
    }
    if !(task.opening_rad.is_finite() && task.opening_rad > 0.0) {
        return Err(SizingError::Opening { opening_rad: task.opening_rad });
    }
    if finger.assembly != Assembly::Reference {
        return Err(SizingError::OtherAssembly);
    }
    let start = start_posture(&finger.lengths, task.object, task.opening_rad)?;
    let end = final_posture(&finger.lengths, finger.assembly, task.object)?;
    let rigid_stroke_rad = end.posture.q21_rad - start.q21_rad;
    let stroke_rad = end.posture.q11_rad - start.q11_rad;
    if stroke_rad <= rigid_stroke_rad || stroke_rad.is_nan() {
        return Err(SizingError::NoBendingStroke { stroke_rad, rigid_stroke_rad });
    }
    Ok(Closing {
        start,
        end,
        q21_contact_rad: end.posture.q21_rad,
        trajectory: Trajectory { from_rad: start.q11_rad, stroke_rad, length_s: task.closing_s },
        contact_x: inverse_position(rigid_stroke_rad / stroke_rad),
    })
}
