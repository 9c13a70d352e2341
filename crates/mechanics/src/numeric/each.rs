//! Arrays from their indices, in plain loops.
//!
//! `array::from_fn` and `map` of an array are half a dozen functions for each closure, and of what is generic in sizes every size has
//! closures of its own: they were a third of what the core had to compile.

/// `[of(0), of(1), …]`.
#[inline(always)]
pub fn each<T: Copy + Default, const N: usize>(mut of: impl FnMut(usize) -> T) -> [T; N] {
    let mut all = [T::default(); N];
    for (i, part) in all.iter_mut().enumerate() {
        *part = of(i);
    }
    all
}

/// `[of(all[0]), of(all[1]), …]`.
#[inline(always)]
pub fn from_each<T: Copy, U: Copy + Default, const N: usize>(all: [T; N], of: impl Fn(T) -> U) -> [U; N] {
    let mut found = [U::default(); N];
    for (part, of_part) in found.iter_mut().zip(all) {
        *part = of(of_part);
    }
    found
}

/// `all` with every part changed.
#[inline(always)]
pub fn changed<T: Copy, const N: usize>(mut all: [T; N], of: impl Fn(T) -> T) -> [T; N] {
    for part in &mut all {
        *part = of(*part);
    }
    all
}
