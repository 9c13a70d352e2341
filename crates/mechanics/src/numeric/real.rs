//! The operations available to kernels, for plain and dual numbers.

use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

use super::elementary::sin_cos;

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

    /// Returns (sin, cos).
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
