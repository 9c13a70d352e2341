//! Form closure of a whole gripper in any posture, with a differential or without.

use super::{FormClosure, Kind, PerContact, Row, Stance, StaticsError, Unilateral, decide, unilateral};

/// What of the drive cannot be turned back. What is blocked both ways is held the more: a grasp that is closed here is closed then too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blocked {
    /// Each driven link by itself: both motors, or both outputs of a differential. n_u = 2 in (1.19).
    Outputs,
    /// The input of a differential alone, which turns by the mean of its outputs: one finger may give way as the other follows.
    /// n_u = 1.
    Input,
}

/// One constraint of a gripper; finger 0 is the right one, 1 the left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GripperRow {
    Hand(Row),
    /// Rate (θ̇_a of the right finger + that of the left)/2 of a differential's input that cannot be turned back, in rad/s.
    Input,
}

impl From<GripperRow> for Kind {
    fn from(row: GripperRow) -> Self {
        match row {
            GripperRow::Hand(row) => row.into(),
            GripperRow::Input => Kind::Motor,
        }
    }
}

/// U of (1.18) of a gripper in this posture with these contacts: those of phalanges and palm. A table is none of them, because the
/// gripper carries its object away from it; nor is a joint limit, as for one finger.
///
/// The object is a disc, all of whose normals pass through its centre: its rotation is in none of the rows, and no unknown (d = 2). With
/// it there would be no form closure of a disc at all.
///
/// # Errors
/// A posture in which a loop does not close, or the singular ones of [`at_rest`](super::at_rest).
pub fn gripper_unilateral(
    stance: &Stance<'_>,
    touching: &PerContact<bool>,
    blocked: Blocked,
) -> Result<Unilateral<GripperRow>, StaticsError> {
    let outputs = unilateral(&stance.hand(touching)?)?.named(GripperRow::Hand);
    if blocked == Blocked::Outputs {
        return Ok(outputs);
    }
    let mut u = Unilateral::new(outputs.unknowns.clone(), outputs.scale.clone());
    let mut input = vec![0.0; outputs.unknowns.len()];
    for (index, &row) in outputs.rows.iter().enumerate() {
        if Kind::from(row) == Kind::Motor {
            input.iter_mut().zip(outputs.row(index)).for_each(|(sum, entry)| *sum += 0.5 * entry);
        } else {
            u.append(row, outputs.row(index));
        }
    }
    u.append(GripperRow::Input, &input);
    Ok(u)
}

/// Whether the contacts of a posture hold the object fast as long as nothing that is blocked is turned back, with what proves it.
///
/// # Errors
/// Those of [`gripper_unilateral`]; a grasp so near to the boundary that nothing can be proven.
pub fn gripper_closure(
    stance: &Stance<'_>,
    touching: &PerContact<bool>,
    blocked: Blocked,
) -> Result<FormClosure<GripperRow>, StaticsError> {
    decide(&gripper_unilateral(stance, touching, blocked)?)
}
