//! The three axes of a volume, and the order of its points.

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

    /// The value at an index; a single point lies in the middle.
    pub fn value(&self, index: usize) -> f64 {
        let part = match self.points {
            0 | 1 => 0.5,
            points => index as f64 / (points - 1) as f64,
        };
        // Either end exactly, also where the other one is of another size.
        (1.0 - part) * self.from + part * self.to
    }

    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.points).map(|index| self.value(index))
    }

    /// The indices of at most so many values, evenly spread, the first and the last among them.
    pub fn spread(&self, most: usize) -> Vec<usize> {
        let count = self.points.min(most);
        if count < 2 {
            return if count == 0 { Vec::new() } else { vec![(self.points - 1) / 2] };
        }
        (0..count).map(|k| (k * (self.points - 1) + (count - 1) / 2) / (count - 1)).collect()
    }
}

/// The axes of a volume.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Axes {
    /// Place of l21 within the range its base allows.
    pub l21_fraction: Axis,
    pub phi22_rad: Axis,
    /// r_l = l22/l11.
    pub arm_ratio: Axis,
}

impl Axes {
    /// Those of the thesis (§3.4) with so many points each; the limits of φ22 and r_l are those of its designs (§4.2).
    pub fn thesis([l21, phi22, arm]: [usize; 3]) -> Self {
        Self {
            l21_fraction: Axis::new(0.0, 1.0, l21),
            phi22_rad: Axis::new(90f64.to_radians(), 120f64.to_radians(), phi22),
            arm_ratio: Axis::new(1.0 / 3.0, 2.0 / 3.0, arm),
        }
    }

    /// Points along l21, φ22 and r_l.
    pub fn resolution(&self) -> [usize; 3] {
        [self.l21_fraction.points, self.phi22_rad.points, self.arm_ratio.points]
    }

    /// Points in all.
    pub fn len(&self) -> usize {
        self.resolution().iter().product()
    }

    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Place in the list of points: r_l fastest, then φ22, then l21.
    pub fn index(&self, [l21, phi22, arm]: [usize; 3]) -> usize {
        (l21 * self.phi22_rad.points + phi22) * self.arm_ratio.points + arm
    }

    /// l21 fraction, φ22 and r_l of the point at a place in the list.
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
    fn ends_are_exact_and_a_single_point_is_the_middle() {
        let axis = Axis::new(1.0 / 3.0, 2.0 / 3.0, 20);
        assert_eq!((axis.value(0), axis.value(19)), (1.0 / 3.0, 2.0 / 3.0));
        assert_eq!(Axis::new(0.0, 1.0, 1).value(0), 0.5);
        assert_eq!(Axis::new(2.0, 5.0, 2).values().collect::<Vec<_>>(), [2.0, 5.0]);
    }

    #[test]
    fn slices_are_spread_over_the_axis() {
        let axis = |points| Axis::new(0.0, 1.0, points);
        assert_eq!(axis(20).spread(5), [0, 5, 10, 14, 19]);
        assert_eq!(axis(3).spread(5), [0, 1, 2]);
        assert_eq!(axis(7).spread(1), [3]);
        assert_eq!(axis(1).spread(5), [0]);
    }

    #[test]
    fn points_are_listed_with_the_last_axis_fastest() {
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
