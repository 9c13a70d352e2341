//! Grasp-state volumes (thesis §3.4): designs that hold the object, over l21, φ22 and r_l, for one base and one
//! friction coefficient.
//!
//! Every point is a design, sized by a [`Rule`] and closed on the object, in equilibrium. The grasp is stable if no
//! contact force is tensile (force positiveness). In the stable region, one more quantity can be shown: palm force
//! positiveness, form closure, forces, sizing or mass. Sizing and form closure do not depend on friction, so each
//! design is sized once for all coefficients. A design that does not exist keeps its point, with the reason.
//!
//! | file | job |
//! |---|---|
//! | `point` | one design: built, sized, closed and in equilibrium; its quantities |
//! | `counts` | points by grasp state, also for an intersection over the bases; tables and JSON |
//! | `display` | slices |

mod counts;
mod display;
mod point;

pub use counts::{Cell, Counts, Intersection, LargestPalmForce, MissingFingers, Timing, VolumeCounts, VolumeReport};
pub use counts::{by_friction, cells, count_volume, intersections};
pub use display::slices;
pub(crate) use point::close_linkage;
pub use point::{COLUMNS, ClosedFinger, FLAGS, GraspState, NoFinger, Point, Quantity, SizedFinger};
pub use point::{close_finger, design_at, solve_grasp};

use serde::Serialize;

use crate::scene::Template;
use crate::sizing::Rule;
use phalanx_parallel::{ComputeError, Monitor, map, require};

/// Maximum total number of points. Each takes about 150 bytes in memory, and four times as much in a table.
pub const MAX_POINTS: usize = 2_000_000;

/// Number of designs that a thread evaluates at a time: a few milliseconds of work.
const CHUNK_SIZE: usize = 64;

/// Bases of the volumes of the thesis.
pub const BASES_M: [f64; 4] = [0.012, 0.0155, 0.019, 0.0225];

/// Evenly spaced values, including both ends.
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

    /// Returns the value at an index. If there is only one value, it is the midpoint.
    pub fn value(&self, index: usize) -> f64 {
        let fraction = if self.points < 2 { 0.5 } else { index as f64 / (self.points - 1) as f64 };
        // This form gives both ends exactly, even if their magnitudes differ.
        (1.0 - fraction) * self.from + fraction * self.to
    }

    /// Returns the indices of at most `max_count` evenly spaced values, including the first and the last.
    pub(crate) fn spaced_indices(&self, max_count: usize) -> Vec<usize> {
        match self.points.min(max_count) {
            0 => Vec::new(),
            1 => vec![(self.points - 1) / 2],
            count => (0..count).map(|k| (k * (self.points - 1) + (count - 1) / 2) / (count - 1)).collect(),
        }
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
    /// Returns the axes of the thesis (§3.4) with these numbers of points. The limits of φ22 and r_l are those of its
    /// designs (§4.2).
    pub fn thesis([l21, phi22, arm]: [usize; 3]) -> Self {
        Self {
            l21_fraction: Axis::new(0.0, 1.0, l21),
            phi22_rad: Axis::new(90f64.to_radians(), 120f64.to_radians(), phi22),
            arm_ratio: Axis::new(1.0 / 3.0, 2.0 / 3.0, arm),
        }
    }

    /// Returns the axes of l21, φ22 and r_l.
    pub fn all(&self) -> [&Axis; 3] {
        [&self.l21_fraction, &self.phi22_rad, &self.arm_ratio]
    }

    /// Returns the number of points along l21, φ22 and r_l.
    pub fn resolution(&self) -> [usize; 3] {
        self.all().map(|axis| axis.points)
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

    /// Returns the l21 fraction, φ22 and r_l of the point at an index.
    pub fn at(&self, index: usize) -> [f64; 3] {
        let (rest, arm) = (index / self.arm_ratio.points, index % self.arm_ratio.points);
        let (l21, phi22) = (rest / self.phi22_rad.points, rest % self.phi22_rad.points);
        [self.l21_fraction.value(l21), self.phi22_rad.value(phi22), self.arm_ratio.value(arm)]
    }
}

/// Parameters of a volume study.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeRequest {
    /// Common data of all designs.
    pub template: Template,
    pub bases_m: Vec<f64>,
    pub mu_static: Vec<f64>,
    pub axes: Axes,
    pub rule: Rule,
}

impl VolumeRequest {
    /// Returns the request for the volumes of the thesis: four bases, three friction coefficients, 20³ points each.
    pub fn thesis() -> Self {
        Self {
            template: Template::thesis(),
            bases_m: BASES_M.to_vec(),
            mu_static: vec![0.0, 0.4, 0.8],
            axes: Axes::thesis([20; 3]),
            rule: Rule::Rigid,
        }
    }

    /// Checks the request. Designs that do not exist are allowed; values that no design can have are not.
    fn check(&self) -> Result<(), ComputeError> {
        for (name, list, minimum, allowed) in [
            ("base", &self.bases_m, f64::MIN_POSITIVE, "above 0"),
            ("friction coefficient", &self.mu_static, 0.0, "at least 0"),
        ] {
            require(!list.is_empty(), || format!("no {name} is given; give at least one"))?;
            for (index, value) in list.iter().enumerate() {
                require(value.is_finite() && *value >= minimum, || {
                    format!("invalid {name} {value}: it must be a finite number {allowed}")
                })?;
                require(!list[..index].contains(value), || {
                    let position = index + 1;
                    format!("the {name} {value} is given twice (again at position {position}); give each value once")
                })?;
            }
        }
        for (name, &Axis { from, to, points }) in ["l21", "phi22", "arm_ratio"].into_iter().zip(self.axes.all()) {
            require(from.is_finite() && to.is_finite() && from <= to, || {
                format!("the axis {name} goes from {from} to {to}; give finite limits, the lower one first")
            })?;
            require(points > 0, || format!("the axis {name} has no points; give at least 1"))?;
        }
        let factors = [self.bases_m.len(), self.mu_static.len()].into_iter().chain(self.axes.resolution());
        let points = factors.fold(1, usize::saturating_mul);
        require(points <= MAX_POINTS, || {
            format!(
                "the volumes have {points} points in total, more than the maximum of {MAX_POINTS}; lower the resolution, or give \
                 fewer bases or friction coefficients"
            )
        })
    }
}

/// The volume of one base and one friction coefficient.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    pub base_m: f64,
    pub mu_static: f64,
    pub axes: Axes,
    /// Points in the order of [`Axes::index`]: r_l varies fastest, then φ22, then l21.
    pub points: Vec<Point>,
}

/// Computes the volumes for every base and friction coefficient on `threads` threads (0: one per core); the base varies
/// slowest. The result does not depend on the number of threads.
///
/// # Errors
/// Returns an error if the request is invalid, or if the monitor stops the computation.
pub fn volumes(request: &VolumeRequest, threads: usize, monitor: &Monitor) -> Result<Vec<Volume>, ComputeError> {
    request.check()?;
    let VolumeRequest { template, bases_m, mu_static, axes, rule } = request;
    let designs: Vec<(f64, usize)> =
        bases_m.iter().flat_map(|&base_m| (0..axes.len()).map(move |index| (base_m, index))).collect();
    monitor.start(designs.len(), "designs");
    let evaluate = |&(base_m, index): &(f64, usize)| {
        monitor.check()?;
        let closed = close_finger(template, &design_at(template, base_m, axes.at(index)), *rule);
        let solve = |&mu: &f64| closed.as_ref().map_err(Clone::clone).and_then(|closed| solve_grasp(closed, mu));
        let points: Vec<Point> = mu_static.iter().map(solve).collect();
        monitor.advance(1, "designs");
        Ok(points)
    };
    let chunks: Vec<_> = designs.chunks(CHUNK_SIZE).collect();
    let found = map(threads, &chunks, |chunk| chunk.iter().map(evaluate).collect::<Result<Vec<_>, _>>())?;
    let mut volumes: Vec<Volume> = bases_m
        .iter()
        .flat_map(|&base_m| mu_static.iter().map(move |&mu_static| (base_m, mu_static)))
        .map(|(base_m, mu_static)| Volume { base_m, mu_static, axes: *axes, points: Vec::with_capacity(axes.len()) })
        .collect();
    for (design, points) in found.into_iter().flatten().enumerate() {
        let first = design / axes.len() * mu_static.len();
        volumes[first..].iter_mut().zip(points).for_each(|(volume, point)| volume.points.push(point));
    }
    Ok(volumes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_exact_and_a_single_point_is_the_midpoint() {
        let axis = Axis::new(1.0 / 3.0, 2.0 / 3.0, 20);
        assert_eq!((axis.value(0), axis.value(19)), (1.0 / 3.0, 2.0 / 3.0));
        assert_eq!(Axis::new(0.0, 1.0, 1).value(0), 0.5);
        for (points, max_count, indices) in
            [(20, 5, &[0, 5, 10, 14, 19][..]), (3, 5, &[0, 1, 2]), (7, 1, &[3]), (1, 5, &[0])]
        {
            assert_eq!(Axis::new(0.0, 1.0, points).spaced_indices(max_count), indices);
        }
    }

    #[test]
    fn last_axis_varies_fastest() {
        let axes = Axes::thesis([3, 4, 5]);
        for index in 0..axes.len() {
            let [l21, phi22, arm] = [index / 20, index / 5 % 4, index % 5];
            assert_eq!(axes.index([l21, phi22, arm]), index);
            let expected = [axes.l21_fraction.value(l21), axes.phi22_rad.value(phi22), axes.arm_ratio.value(arm)];
            assert_eq!(axes.at(index), expected);
        }
    }
}
