//! Form closure of a whole gripper in any posture, with or without a differential.

use super::{
    FormClosure, GraspConfiguration, PerContact, Row, RowKind, StaticsError, Unilateral, decide_form_closure,
    unilateral,
};

/// Parts of the drive that cannot be back-driven. Blocking them in both directions only adds constraints: a grasp that
/// is closed with these constraints remains closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blocked {
    /// Each driven link separately: both motors, or both outputs of a differential. n_u = 2 in (1.19).
    Outputs,
    /// Only the input of a differential, whose rotation is the mean of its outputs: one finger may yield while the
    /// other follows. n_u = 1.
    Input,
}

/// One constraint of a gripper; finger 0 is the right one, 1 the left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GripperRow {
    Hand(Row),
    /// Rate (θ̇_a,right + θ̇_a,left)/2 of the input of a differential that cannot be back-driven, in rad/s.
    Input,
}

impl From<GripperRow> for RowKind {
    fn from(row: GripperRow) -> Self {
        match row {
            GripperRow::Hand(row) => row.into(),
            GripperRow::Input => RowKind::Motor,
        }
    }
}

/// U of (1.18) of a gripper in this posture with these contacts of phalanges and palm. A table is not included, because
/// the gripper moves its object away from it; a joint limit is not included either, as for one finger.
///
/// The object is a disc, all of whose normals pass through its centre: its rotation does not appear in any row and is
/// not an unknown (d = 2). With rotation as an unknown, a disc would never be form-closed.
///
/// # Errors
/// Returns an error if a loop does not close, and for the singular postures of
/// [`static_kinematics`](super::static_kinematics).
pub fn gripper_unilateral(
    configuration: &GraspConfiguration<'_>,
    active_contacts: &PerContact<bool>,
    blocked: Blocked,
) -> Result<Unilateral<GripperRow>, StaticsError> {
    let outputs = unilateral(&configuration.hand(active_contacts)?)?.with_row_names(GripperRow::Hand);
    if blocked == Blocked::Outputs {
        return Ok(outputs);
    }
    let mut u = Unilateral::new(outputs.unknowns.clone(), outputs.scale.clone());
    let mut input = vec![0.0; outputs.unknowns.len()];
    for (index, &row) in outputs.rows.iter().enumerate() {
        if RowKind::from(row) == RowKind::Motor {
            input.iter_mut().zip(outputs.row(index)).for_each(|(sum, entry)| *sum += 0.5 * entry);
        } else {
            u.append(row, outputs.row(index));
        }
    }
    u.append(GripperRow::Input, &input);
    Ok(u)
}

/// Decides form closure of a posture, provided that blocked drives are not back-driven, with a certificate.
///
/// # Errors
/// See [`gripper_unilateral`]; also returns an error if the grasp is so close to the boundary that no certificate
/// exists.
pub fn gripper_closure(
    configuration: &GraspConfiguration<'_>,
    active_contacts: &PerContact<bool>,
    blocked: Blocked,
) -> Result<FormClosure<GripperRow>, StaticsError> {
    decide_form_closure(&gripper_unilateral(configuration, active_contacts, blocked)?)
}
