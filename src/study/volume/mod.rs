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
//! | `axes` | the three axes and the order of the points |
//! | `point` | one design: built, sized, closed and in equilibrium |
//! | `run` | computation of all points on several threads |
//! | `quantity` | quantities of a point |
//! | `cells` | display state of each point, also for an intersection |
//! | `counts` | counts, maxima and intersections over the bases |

mod axes;
mod cells;
mod counts;
mod point;
mod quantity;
mod run;

pub use crate::study::pool::all_cores;
pub use axes::{Axes, Axis};
pub use cells::{Cell, cells, intersection_cells};
pub use counts::{Best, Intersection, VolumeCounts, count_volume, intersection, intersections, percent};
pub use point::{ClosedFinger, GraspState, NoFinger, Point, SizedFinger, close_finger, design_at, solve_grasp};
pub use quantity::{Quantity, WorstCase};
pub use run::{MAX_POINTS, volumes, volumes_with};

use crate::scene::Template;
use crate::sizing::Rule;

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
    /// Returns the volumes of the thesis: four bases, three friction coefficients, 20³ points each.
    pub fn thesis() -> Self {
        Self {
            template: Template::thesis(),
            bases_m: vec![0.012, 0.0155, 0.019, 0.0225],
            mu_static: vec![0.0, 0.4, 0.8],
            axes: Axes::thesis([20; 3]),
            rule: Rule::Rigid,
        }
    }

    /// Checks the request. Designs that do not exist are allowed; values that no design can have are not.
    fn check(&self) -> Result<(), VolumeError> {
        let lists = [("base", &self.bases_m, f64::MIN_POSITIVE), ("friction coefficient", &self.mu_static, 0.0)];
        for (name, list, minimum) in lists {
            if list.is_empty() {
                return Err(VolumeError::Empty { name });
            }
            if let Some(&value) = list.iter().find(|value| !(value.is_finite() && **value >= minimum)) {
                let allowed = if minimum > 0.0 { "above 0" } else { "at least 0" };
                return Err(VolumeError::InvalidValue { name, value, allowed });
            }
            if let Some((index, &value)) = list.iter().enumerate().find(|(i, value)| list[..*i].contains(value)) {
                return Err(VolumeError::Duplicate { name, value, position: index + 1 });
            }
        }
        for (name, axis) in
            [("l21", &self.axes.l21_fraction), ("phi22", &self.axes.phi22_rad), ("arm_ratio", &self.axes.arm_ratio)]
        {
            if !(axis.from.is_finite() && axis.to.is_finite() && axis.from <= axis.to) {
                return Err(VolumeError::InvalidLimits { name, from: axis.from, to: axis.to });
            }
            if axis.points == 0 {
                return Err(VolumeError::EmptyAxis { name });
            }
        }
        let volumes = self.bases_m.len().checked_mul(self.mu_static.len());
        let points = self.axes.resolution().into_iter().try_fold(1usize, usize::checked_mul);
        match volumes.zip(points).and_then(|(volumes, points)| volumes.checked_mul(points)) {
            Some(points) if points <= MAX_POINTS => Ok(()),
            points => Err(VolumeError::TooMany { points: points.unwrap_or(usize::MAX) }),
        }
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

impl Volume {
    /// Returns the number of points along l21, φ22 and r_l.
    pub fn resolution(&self) -> [usize; 3] {
        self.axes.resolution()
    }

    /// Returns the point at indices along l21, φ22 and r_l.
    pub fn point(&self, indices: [usize; 3]) -> &Point {
        &self.points[self.axes.index(indices)]
    }
}

/// Error during a volume study.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VolumeError {
    #[error("no {name} is given; give at least one")]
    Empty { name: &'static str },
    #[error("invalid {name} {value}: it must be a finite number {allowed}")]
    InvalidValue { name: &'static str, value: f64, allowed: &'static str },
    #[error("the {name} {value} is given twice (again at position {position}); give each value once")]
    Duplicate { name: &'static str, value: f64, position: usize },
    #[error("the axis {name} goes from {from} to {to}; give finite limits, the lower one first")]
    InvalidLimits { name: &'static str, from: f64, to: f64 },
    #[error("the axis {name} has no points; give at least 1")]
    EmptyAxis { name: &'static str },
    #[error(
        "the volumes have {points} points in total, more than the maximum of {MAX_POINTS}; lower the resolution, or give fewer bases or \
         friction coefficients"
    )]
    TooMany { points: usize },
    #[error("interrupted after {done} of {total} designs")]
    Stopped { done: usize, total: usize },
}
