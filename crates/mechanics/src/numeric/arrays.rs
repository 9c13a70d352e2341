//! Construction and mapping of arrays, in plain loops.
//!
//! `array::from_fn` and array `map` instantiate half a dozen functions for each closure and each array size; they were
//! a third of the code that the core had to compile.

/// Returns the array `[f(0), f(1), …]`.
#[inline(always)]
pub fn array_from<T: Copy + Default, const N: usize>(mut f: impl FnMut(usize) -> T) -> [T; N] {
    let mut array = [T::default(); N];
    for (i, entry) in array.iter_mut().enumerate() {
        *entry = f(i);
    }
    array
}

/// `[f(array[0]), f(array[1]), …]`.
#[inline(always)]
pub fn map_array<T: Copy, U: Copy + Default, const N: usize>(array: [T; N], f: impl Fn(T) -> U) -> [U; N] {
    let mut result = [U::default(); N];
    for (entry, element) in result.iter_mut().zip(array) {
        *entry = f(element);
    }
    result
}

/// [`map_array`] for an `f` that returns the same type, which need not implement [`Default`].
#[inline(always)]
pub fn map_same_type<T: Copy, const N: usize>(mut array: [T; N], f: impl Fn(T) -> T) -> [T; N] {
    for entry in &mut array {
        *entry = f(*entry);
    }
    array
}
