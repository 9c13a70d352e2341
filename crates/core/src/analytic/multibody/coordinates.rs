//! Coordinates that a finger, a disc or a contact depends on.

/// Index of a coordinate, and the sign of its contribution. An index beyond the last represents a coordinate of a fixed
/// disc.
pub type SignedIndex = (usize, f64);

/// Indices of the coordinates of a finger.
#[inline(always)]
pub fn finger_indices(finger: usize) -> [SignedIndex; 2] {
    [(2 * finger, 1.0), (2 * finger + 1, 1.0)]
}

/// Indices of the coordinates of a disc.
#[inline(always)]
pub fn disc_indices(first: usize) -> [SignedIndex; 3] {
    [(first, 1.0), (first + 1, 1.0), (first + 2, 1.0)]
}

/// Indices of x and y of a disc, time, and the angle of the disc, in this order.
#[inline(always)]
pub fn disc_time_indices(first: usize, time: usize) -> [SignedIndex; 4] {
    [(first, 1.0), (first + 1, 1.0), (time, 1.0), (first + 2, 1.0)]
}

/// Indices of x and y of two discs, then of both angles.
#[inline(always)]
pub fn disc_pair_indices([a, b]: [usize; 2]) -> [SignedIndex; 6] {
    [(a, 1.0), (a + 1, 1.0), (b, 1.0), (b + 1, 1.0), (a + 2, 1.0), (b + 2, 1.0)]
}

/// Indices of the coordinates of a phalanx's contact, with the disc's coordinates in the finger's frame.
#[inline(always)]
pub fn phalanx_indices(finger: usize, first: usize, mirror: f64) -> [SignedIndex; 5] {
    let [a, b] = finger_indices(finger);
    [a, b, (first, mirror), (first + 1, 1.0), (first + 2, mirror)]
}

/// Adds derivatives with respect to the coordinates `indices` to a row of derivatives with respect to all coordinates.
#[inline(always)]
pub fn scatter<const N: usize>(row: &mut [f64; N], indices: &[SignedIndex], derivatives: &[f64]) {
    for ((index, sign), derivative) in indices.iter().zip(derivatives) {
        if *index < N {
            row[*index] += sign * derivative;
        }
    }
}
