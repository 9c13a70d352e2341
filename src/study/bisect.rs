//! Bisection.

/// Narrows a bracket of a value that passes and one that fails: tests the value that `next` returns for the bracket,
/// until it returns `None`. Returns the bracket, or `None` if a test was interrupted.
pub fn bisect(
    mut bracket: [f64; 2],
    next: impl Fn(f64, f64) -> Option<f64>,
    mut passes: impl FnMut(f64) -> Option<bool>,
) -> Option<[f64; 2]> {
    while let Some(value) = next(bracket[0], bracket[1]) {
        bracket[usize::from(!passes(value)?)] = value;
    }
    Some(bracket)
}
