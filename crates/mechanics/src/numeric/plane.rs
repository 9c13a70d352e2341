//! Plane vectors over any [`Real`].

use std::f64::consts::{FRAC_PI_2, TAU};

use super::Real;
use super::elementary::atan2;

/// A vector (x, y).
pub type Vector<T> = [T; 2];

#[inline(always)]
pub fn dot<T: Real>(a: Vector<T>, b: Vector<T>) -> T {
    a[0] * b[0] + a[1] * b[1]
}

/// a × b = |a||b| sin of the angle from a to b.
#[inline(always)]
pub fn cross<T: Real>(a: Vector<T>, b: Vector<T>) -> T {
    a[0] * b[1] - a[1] * b[0]
}

/// Returns the vector rotated counter-clockwise by 90°.
#[inline(always)]
pub fn perp<T: Real>(a: Vector<T>) -> Vector<T> {
    [-a[1], a[0]]
}

#[inline(always)]
pub fn add<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline(always)]
pub fn sub<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] - b[0], a[1] - b[1]]
}

#[inline(always)]
pub fn scale<T: Real>(a: Vector<T>, s: T) -> Vector<T> {
    [a[0] * s, a[1] * s]
}

#[inline(always)]
pub fn scale_by<T: Real>(a: Vector<T>, s: f64) -> Vector<T> {
    [a[0] * s, a[1] * s]
}

/// Returns the vector rotated by an angle given as (cos, sin).
#[inline(always)]
pub fn rotate<T: Real>(a: Vector<T>, rotation: [f64; 2]) -> Vector<T> {
    let [c, s] = rotation;
    [a[0] * c - a[1] * s, a[0] * s + a[1] * c]
}

/// Angle from unit vector a to unit vector b, in (−π, π].
///
/// Near zero the series of arcsin replaces atan2: at the 1e-8 rad of a joint limit it is exact and much cheaper.
#[inline(always)]
pub fn angle_between<T: Real>(a: Vector<T>, b: Vector<T>) -> T {
    let sin = cross(a, b);
    let cos = dot(a, b);
    let (s, c) = (sin.value(), cos.value());
    let angle = if s.abs() < 2e-3 && c > 0.0 { s * (1.0 + s * s * (1.0 / 6.0 + s * s * 0.075)) } else { atan2(s, c) };
    sin.chain2(cos, angle, c, -s)
}

/// Angle from one unit vector to another, in (−π/2, 3π/2]. A tip that bends beyond its stop cannot reach the branch cut
/// at −90°.
#[inline(always)]
pub fn opening_angle<T: Real>(from: Vector<T>, to: Vector<T>) -> T {
    let angle = angle_between(from, to);
    if angle.value() <= -FRAC_PI_2 { angle + TAU } else { angle }
}

/// `angle` plus the multiple of a full turn that brings it closest to `other`, rad.
#[inline(always)]
pub fn nearest_equivalent_angle(angle: f64, other: f64) -> f64 {
    angle + TAU * ((other - angle) / TAU).round()
}

/// Returns the angle wrapped to −π … π.
pub fn wrap_angle(angle_rad: f64) -> f64 {
    angle_rad - TAU * (angle_rad / TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angle_between_agrees_with_atan2_on_both_sides_of_the_switch() {
        for angle in [-3.0, -0.5, -2.1e-3, -1.9e-3, -1e-9, 0.0, 3e-8, 1.999e-3, 2.001e-3, 1.2, 3.1f64] {
            let a: [f64; 2] = [0.3f64.cos(), 0.3f64.sin()];
            let b = [(0.3 + angle).cos(), (0.3 + angle).sin()];
            assert!((angle_between(a, b) - angle).abs() < 4e-16 * (1.0 + angle.abs()), "{angle}");
        }
    }

    #[test]
    fn opening_angle_is_continuous_through_half_a_turn() {
        let b = |angle: f64| [angle.cos(), angle.sin()];
        for angle in [-1.5, 0.0, 3.1, 3.2, 4.6f64] {
            assert!((opening_angle([1.0, 0.0], b(angle)) - angle).abs() < 1e-14, "{angle}");
        }
    }
}
