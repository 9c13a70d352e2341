//! Which coordinates a part depends on.

/// A coordinate and the sign with which a part has it; one that is not there (of a fixed disc) is beyond the last.
pub type Where = (usize, f64);

/// Coordinates of a finger.
#[inline(always)]
pub fn of_finger(finger: usize) -> [Where; 2] {
    [(2 * finger, 1.0), (2 * finger + 1, 1.0)]
}

/// Coordinates of a disc.
#[inline(always)]
pub fn of_disc(first: usize) -> [Where; 3] {
    [(first, 1.0), (first + 1, 1.0), (first + 2, 1.0)]
}

/// Those of a disc, with time before its angle.
#[inline(always)]
pub fn of_disc_in_time(first: usize, time: usize) -> [Where; 4] {
    [(first, 1.0), (first + 1, 1.0), (time, 1.0), (first + 2, 1.0)]
}

/// Those of two discs, both angles last.
#[inline(always)]
pub fn of_discs([a, b]: [usize; 2]) -> [Where; 6] {
    [(a, 1.0), (a + 1, 1.0), (b, 1.0), (b + 1, 1.0), (a + 2, 1.0), (b + 2, 1.0)]
}

/// Coordinates of a phalanx's contact: a disc's as the finger's frame has them.
#[inline(always)]
pub fn of_phalanx(finger: usize, first: usize, mirror: f64) -> [Where; 5] {
    let [a, b] = of_finger(finger);
    [a, b, (first, mirror), (first + 1, 1.0), (first + 2, mirror)]
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
