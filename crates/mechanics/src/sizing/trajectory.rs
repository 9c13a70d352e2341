//! The test trajectory of the sizing (thesis §3.3.2.1, Fig. 3.1).

/// s(x) = 35x⁴ − 84x⁵ + 70x⁶ − 20x⁷ on 0 … 1: velocity, acceleration and jerk vanish at both ends.
#[inline]
pub fn position(x: f64) -> f64 {
    let x2 = x * x;
    x2 * x2 * (35.0 + x * (-84.0 + x * (70.0 - 20.0 * x)))
}

/// ds/dx.
#[inline]
pub fn rate(x: f64) -> f64 {
    let product = x * (1.0 - x);
    140.0 * product * product * product
}

/// d²s/dx².
#[inline]
pub fn acceleration(x: f64) -> f64 {
    let product = x * (1.0 - x);
    420.0 * product * product * (1.0 - 2.0 * x)
}

/// Inverse of [`position`]: the x in 0 … 1 at which s(x) = `fraction`, clamped outside 0 … 1.
///
/// Newton iteration, safeguarded by bisection because s is flat at both ends.
pub(crate) fn inverse_position(fraction: f64) -> f64 {
    if fraction <= 0.0 {
        return 0.0;
    }
    if fraction >= 1.0 {
        return 1.0;
    }
    let (mut low, mut high, mut x) = (0.0, 1.0, 0.5);
    for _ in 0..100 {
        let residual = position(x) - fraction;
        if residual < 0.0 {
            low = x
        } else {
            high = x
        }
        let newton = x - residual / rate(x);
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= 2.0 * f64::EPSILON {
            return next;
        }
        x = next;
    }
    x
}

/// Trajectory of the motor link: from `from_rad` over `stroke_rad` in `length_s`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trajectory {
    pub from_rad: f64,
    pub stroke_rad: f64,
    pub length_s: f64,
}

/// Angle, rate and acceleration of the motor link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    pub angle_rad: f64,
    pub rate_rad_s: f64,
    pub acceleration_rad_s2: f64,
}

impl Trajectory {
    /// Motion of the motor link at x = t/T.
    #[inline]
    pub fn at(&self, x: f64) -> Motion {
        Motion {
            angle_rad: self.from_rad + self.stroke_rad * position(x),
            rate_rad_s: self.stroke_rad * rate(x) / self.length_s,
            acceleration_rad_s2: self.stroke_rad * acceleration(x) / (self.length_s * self.length_s),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_polynomial_starts_and_ends_at_rest_and_has_consistent_derivatives() {
        assert_eq!([position(0.0), position(0.5), position(1.0)], [0.0, 0.5, 1.0]);
        assert_eq!([rate(0.0), rate(1.0), acceleration(0.0), acceleration(1.0)], [0.0; 4]);
        let h = 1e-5;
        for x in [0.1, 0.35, 0.5, 0.77, 0.95] {
            assert!(((position(x + h) - position(x - h)) / (2.0 * h) - rate(x)).abs() < 1e-8);
            assert!(((rate(x + h) - rate(x - h)) / (2.0 * h) - acceleration(x)).abs() < 1e-7);
        }
    }

    #[test]
    fn inverse_position_inverts_position() {
        for fraction in [0.0, 1e-12, 1e-3, 0.3, 0.5, 0.9, 1.0 - 1e-9, 1.0] {
            assert!((position(inverse_position(fraction)) - fraction).abs() < 1e-13, "{fraction}");
        }
    }
}
