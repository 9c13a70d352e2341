//! Which coordinates of the gripper a part of it depends on.

use super::{BRAKES, FINGERS, MEMORY, TIME};
use crate::gripper::Site;
use crate::scene::{Place, Side};

/// A coordinate of the gripper and the sign with which a part has it; one that is not there (of a fixed object) is beyond the last.
pub type Where = (usize, f64);

/// Coordinates of a finger.
#[inline(always)]
pub fn of_finger(side: Side) -> [Where; 2] {
    let first = 2 * side as usize;
    [(first, 1.0), (first + 1, 1.0)]
}

/// Coordinates of the object as a finger's frame has them.
#[inline(always)]
pub fn of_object(mirror: f64) -> [Where; 3] {
    [(FINGERS, mirror), (FINGERS + 1, 1.0), (FINGERS + 2, mirror)]
}

/// Those of the object, with time before its angle.
#[inline(always)]
pub fn of_object_in_time() -> [Where; 4] {
    [(FINGERS, 1.0), (FINGERS + 1, 1.0), (TIME, 1.0), (FINGERS + 2, 1.0)]
}

/// Coordinates of a phalanx's contact.
#[inline(always)]
pub fn of_phalanx(side: Side) -> [Where; 5] {
    let ([a, b], [x, y, angle]) = (of_finger(side), of_object(side.mirror()));
    [a, b, x, y, angle]
}

/// Adds slopes of a part to those of all.
#[inline(always)]
pub fn scatter<const N: usize>(row: &mut [f64; N], at: &[Where], slopes: &[f64]) {
    for ((index, sign), slope) in at.iter().zip(slopes) {
        if *index < N {
            row[*index] += sign * slope;
        }
    }
}

/// Where the memory of a place's bristle is; joint limits have none.
#[inline(always)]
pub fn memory_of(place: Place) -> Option<usize> {
    match place {
        Place::Finger(_, Site::Limit) => None,
        Place::Finger(side, site) => Some(MEMORY + 2 * side as usize + usize::from(site == Site::Distal)),
        Place::Palm => Some(MEMORY + 4),
        Place::Table => Some(MEMORY + 5),
    }
}

/// That of a drive's brake: a differential's input comes behind two drives that have none then, and shares the second place.
#[inline(always)]
pub fn memory_of_brake(drive: usize) -> usize {
    BRAKES + drive.min(1)
}
