//! The sizing task of a finger, its test trajectory (start, contact and end), and errors in the sizing.

use super::trajectory::{Trajectory, inverse_position};
use crate::gripper::{Assembly, FinalPosture, Finger, GraspError, Posture, final_posture, start_posture};
use crate::shape::PlacedShape;

/// T, duration of the closing motion (thesis §3.3.2).
pub const CLOSING_S: f64 = 0.010;

/// q_0, angle between the start and the proximal contact (thesis Table 3.2): 25°.
pub const OPENING_RAD: f64 = 25.0 * std::f64::consts::PI / 180.0;

/// The task for which a finger is sized.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    /// The object to be grasped.
    pub object: PlacedShape,
    /// Angle between the start, straight and at rest, and the proximal contact.
    pub opening_rad: f64,
    pub gravity_m_s2: [f64; 2],
    /// Duration T of the test trajectory.
    pub closing_s: f64,
}

impl Task {
    /// Returns the task of the thesis: 25° in 10 ms, gravity directed out of the palm.
    pub const fn thesis(object: PlacedShape) -> Self {
        Task { object, opening_rad: OPENING_RAD, gravity_m_s2: [0.0, 9.81], closing_s: CLOSING_S }
    }
}

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

/// Error for a finger that cannot be sized.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SizingError {
    #[error(transparent)]
    Grasp(#[from] GraspError),
    #[error("{name} is {value}, but must be a finite number above 0: give another value")]
    NotPositive { name: &'static str, value: f64 },
    #[error(
        "the finger starts {:.4} deg before the proximal contact, but must start more than 0 deg before it: open it further \
         (raise the offset, or lower q21)",
        .opening_rad.to_degrees()
    )]
    Opening { opening_rad: f64 },
    #[error(
        "the test trajectory moves l11 by {:.4} deg in total, but the finger swings {:.4} deg before it reaches the object: \
         its distal phalanx would have to bend backwards, so make l21 longer, or phi22 or arm_ratio larger",
        .stroke_rad.to_degrees(), .rigid_stroke_rad.to_degrees()
    )]
    NoBendingStroke { stroke_rad: f64, rigid_stroke_rad: f64 },
    #[error(
        "sizing requires the straight configuration, which the assembly \"other\" does not have: use \"reference\""
    )]
    OtherAssembly,
    #[error(
        "l12 and l22 are in line on the test trajectory (l21 at {:.4} deg), where no torque moves the distal phalanx: change phi22, \
         arm_ratio or l21",
        .q21_rad.to_degrees()
    )]
    Singular { q21_rad: f64 },
}
