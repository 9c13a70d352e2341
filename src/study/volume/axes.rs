//! The three axes of a volume and the order of its points.

use serde::Serialize;

/// Evenly spaced values, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Axis {
    pub from: f64,
    pub to: f64,
    pub points: usize,
}

impl Axis {
    pub const fn new(from: f64, to: f64, points: usize) -> Self {
        Self { from, to, points }
    }

    /// Returns the value at an index; a single point is the midpoint.
    pub fn value(&self, index: usize) -> f64 {
        let fraction = match self.points {
            0 | 1 => 0.5,
            points => index as f64 / (points - 1) as f64,
        };
        // This form gives both ends exactly, even if their magnitudes differ.
        (1.0 - fraction) * self.from + fraction * self.to
    }

    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.points).map(|index| self.value(index))
    }

    /// Returns the indices of at most `max_count` evenly spaced values, including the first and the last.
    pub fn spaced_indices(&self, max_count: usize) -> Vec<usize> {
        let count = self.points.min(max_count);
        if count < 2 {
            return if count == 0 { Vec::new() } else { vec![(self.points - 1) / 2] };
        }
        (0..count).map(|k| (k * (self.points - 1) + (count - 1) / 2) / (count - 1)).collect()
    }
}

/// The axes of a volume.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Axes {
    /// Position of l21 within the range that the base allows, from 0 to 1.
    pub l21_fraction: Axis,
    pub phi22_rad: Axis,
    /// r_l = l22/l11.
    pub arm_ratio: Axis,
}

impl Axes {
    /// Returns the axes of the thesis (§3.4) with the given numbers of points; the limits of φ22 and r_l are from its
    /// designs (§4.2).
    pub fn thesis([l21, phi22, arm]: [usize; 3]) -> Self {
        Self {
            l21_fraction: Axis::new(0.0, 1.0, l21),
            phi22_rad: Axis::new(90f64.to_radians(), 120f64.to_radians(), phi22),
            arm_ratio: Axis::new(1.0 / 3.0, 2.0 / 3.0, arm),
        }
    }

    /// Returns the number of points along l21, φ22 and r_l.
    pub fn resolution(&self) -> [usize; 3] {
        [self.l21_fraction.points, self.phi22_rad.points, self.arm_ratio.points]
    }

    /// Returns the total number of points.
    pub fn len(&self) -> usize {
        self.resolution().iter().product()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the index in the list of points: r_l varies fastest, then φ22, then l21.
    pub fn index(&self, [l21, phi22, arm]: [usize; 3]) -> usize {
        (l21 * self.phi22_rad.points + phi22) * self.arm_ratio.points + arm
    }

    /// Returns the l21 fraction, φ22 and r_l of the point at an index of the list.
    pub fn at(&self, index: usize) -> [f64; 3] {
        let (rest, arm) = (index / self.arm_ratio.points, index % self.arm_ratio.points);
        let (l21, phi22) = (rest / self.phi22_rad.points, rest % self.phi22_rad.points);
        [self.l21_fraction.value(l21), self.phi22_rad.value(phi22), self.arm_ratio.value(arm)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_exact_and_a_single_point_is_the_midpoint() {
        let axis = Axis::new(1.0 / 3.0, 2.0 / 3.0, 20);
        assert_eq!((axis.value(0), axis.value(19)), (1.0 / 3.0, 2.0 / 3.0));
        assert_eq!(Axis::new(0.0, 1.0, 1).value(0), 0.5);
        assert_eq!(Axis::new(2.0, 5.0, 2).values().collect::<Vec<_>>(), [2.0, 5.0]);
    }

    #[test]
    fn spaced_indices_cover_the_axis() {
        let axis = |points| Axis::new(0.0, 1.0, points);
        assert_eq!(axis(20).spaced_indices(5), [0, 5, 10, 14, 19]);
        assert_eq!(axis(3).spaced_indices(5), [0, 1, 2]);
        assert_eq!(axis(7).spaced_indices(1), [3]);
        assert_eq!(axis(1).spaced_indices(5), [0]);
    }

    #[test]
    fn last_axis_varies_fastest() {
        let axes = Axes::thesis([3, 4, 5]);
        assert_eq!(axes.len(), 60);
        let mut next = 0;
        for l21 in 0..3 {
            for phi22 in 0..4 {
                for arm in 0..5 {
                    assert_eq!(axes.index([l21, phi22, arm]), next);
                    let expected =
                        [axes.l21_fraction.value(l21), axes.phi22_rad.value(phi22), axes.arm_ratio.value(arm)];
                    assert_eq!(axes.at(next), expected);
                    next += 1;
                }
            }
        }
    }
}
