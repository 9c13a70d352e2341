//! Numbers with derivatives, for which one formula gives the value and its exact Jacobian; dense linear systems, plane
//! algebra and elementary functions.

pub mod dense;
pub mod elementary;
pub mod plane;

use elementary::sin_cos;
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// A real number, possibly with derivatives attached.
pub trait Real:
    Copy
    + Default
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + AddAssign
    + SubAssign
{
    /// Returns a constant, whose derivatives are zero.
    fn constant(value: f64) -> Self;

    fn value(self) -> f64;

    /// Returns a function of this number, given by its value and its derivative here (chain rule).
    fn chain(self, value: f64, derivative: f64) -> Self;

    /// Returns a function of two numbers, given by its value and its two partial derivatives here.
    fn chain2(self, other: Self, value: f64, d_self: f64, d_other: f64) -> Self;

    #[inline(always)]
    fn zero() -> Self {
        Self::constant(0.0)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value().sqrt();
        self.chain(root, 0.5 / root)
    }

    #[inline(always)]
    fn recip(self) -> Self {
        let inverse = 1.0 / self.value();
        self.chain(inverse, -inverse * inverse)
    }

    #[inline(always)]
    fn squared(self) -> Self {
        self * self
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = sin_cos(self.value());
        (self.chain(sin, cos), self.chain(cos, -sin))
    }
}

impl Real for f64 {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self
    }

    #[inline(always)]
    fn chain(self, value: f64, _derivative: f64) -> Self {
        value
    }

    #[inline(always)]
    fn chain2(self, _other: Self, value: f64, _d_self: f64, _d_other: f64) -> Self {
        value
    }
}

/// A value and its derivatives with respect to `N` variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize> {
    pub value: f64,
    pub grad: [f64; N],
}

impl<const N: usize> Default for Dual<N> {
    #[inline(always)]
    fn default() -> Self {
        Self::constant(0.0)
    }
}

impl<const N: usize> Dual<N> {
    /// Returns the `index`-th independent variable.
    #[inline(always)]
    pub fn variable(value: f64, index: usize) -> Self {
        let mut grad = [0.0; N];
        grad[index] = 1.0;
        Self { value, grad }
    }

    /// Returns the same number with derivatives with respect to M variables; its own variables come first.
    #[inline(always)]
    pub fn widen<const M: usize>(self) -> Dual<M> {
        let mut grad = [0.0; M];
        grad[..N].copy_from_slice(&self.grad);
        Dual { value: self.value, grad }
    }

    #[inline(always)]
    fn combine(self, other: Self, value: f64, a: f64, b: f64) -> Self {
        Self { value, grad: array_from(|i| a * self.grad[i] + b * other.grad[i]) }
    }

    #[inline(always)]
    fn map(self, value: f64, f: impl Fn(f64) -> f64) -> Self {
        Self { value, grad: map_same_type(self.grad, f) }
    }
}

impl<const N: usize> Real for Dual<N> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self { value, grad: [0.0; N] }
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }

    #[inline(always)]
    fn chain(self, value: f64, derivative: f64) -> Self {
        self.map(value, |g| derivative * g)
    }

    #[inline(always)]
    fn chain2(self, other: Self, value: f64, d_self: f64, d_other: f64) -> Self {
        self.combine(other, value, d_self, d_other)
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, grad: array_from(|i| self.grad[i] + other.grad[i]) }
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { value: self.value - other.value, grad: array_from(|i| self.grad[i] - other.grad[i]) }
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.combine(other, self.value * other.value, other.value, self.value)
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(-self.value, |g| -g)
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, grad: self.grad }
    }
}

impl<const N: usize> Sub<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        Self { value: self.value - other, grad: self.grad }
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.map(self.value * other, |g| g * other)
    }
}

impl<const N: usize> AddAssign for Dual<N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const N: usize> SubAssign for Dual<N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// Returns the array `[f(0), f(1), …]`.
///
/// `array::from_fn` and array `map` instantiate half a dozen functions for each closure and each array size: a third of
/// the code that the core had to compile. This function and the next two therefore use plain loops.
#[inline(always)]
pub fn array_from<T: Copy + Default, const N: usize>(mut f: impl FnMut(usize) -> T) -> [T; N] {
    let mut array = [T::default(); N];
    for (i, entry) in array.iter_mut().enumerate() {
        *entry = f(i);
    }
    array
}

/// Returns `[f(array[0]), f(array[1]), …]`.
#[inline(always)]
pub fn map_array<T: Copy, U: Copy + Default, const N: usize>(array: [T; N], f: impl Fn(T) -> U) -> [U; N] {
    let mut result = [U::default(); N];
    for (entry, element) in result.iter_mut().zip(array) {
        *entry = f(element);
    }
    result
}

/// Like [`map_array`], for an `f` that returns the type of its argument; this type need not implement [`Default`].
#[inline(always)]
pub fn map_same_type<T: Copy, const N: usize>(mut array: [T; N], f: impl Fn(T) -> T) -> [T; N] {
    for entry in &mut array {
        *entry = f(*entry);
    }
    array
}

/// Decimals that a message adds at most to tell two numbers apart: those of a double below 1.
pub(crate) const MORE_DECIMALS: usize = 17;

/// Returns the number of decimals, at least `least`, that a text needs to tell different numbers apart.
pub fn decimals(numbers: &[f64], least: usize) -> usize {
    let is_told = |decimals: &usize| {
        let texts: Vec<String> = numbers.iter().map(|number| format!("{number:.decimals$}")).collect();
        let pairs = (1..numbers.len()).flat_map(|k| (0..k).map(move |other| (k, other)));
        pairs.into_iter().all(|(a, b)| numbers[a] == numbers[b] || texts[a] != texts[b])
    };
    (least..least + MORE_DECIMALS).find(is_told).unwrap_or(least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_tell_numbers_apart() {
        assert_eq!(decimals(&[22.5, 20.0], 4), 4);
        assert_eq!(decimals(&[22.5, 22.5], 4), 4);
        assert_eq!(decimals(&[22.5, 22.500_000_001], 4), 9);
        assert_eq!(decimals(&[1.0, 2.0, 1.0f64.next_up()], 3), 16);
    }

    /// f(x, y) = √(x² y) / (x + 3) − sin(x y) against its closed-form gradient.
    #[test]
    fn gradient_matches_closed_form() {
        let (x, y) = (0.7, 1.3);
        let dx = Dual::<2>::variable(x, 0);
        let dy = Dual::<2>::variable(y, 1);
        let f = (dx * dx * dy).sqrt() * (dx + 3.0).recip() - (dx * dy).sin_cos().0;
        let root = (x * x * y).sqrt();
        let expected_x = x * y / root / (x + 3.0) - root / (x + 3.0).powi(2) - y * (x * y).cos();
        let expected_y = 0.5 * x * x / root / (x + 3.0) - x * (x * y).cos();
        assert!((f.value - (root / (x + 3.0) - (x * y).sin())).abs() < 1e-15);
        assert!((f.grad[0] - expected_x).abs() < 1e-15);
        assert!((f.grad[1] - expected_y).abs() < 1e-15);
    }
}
