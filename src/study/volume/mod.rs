//! Grasp-state volumes (thesis §3.4): which designs hold the object, over l21, φ22 and r_l, at a base and a friction.
//!
//! Every point is a design, sized by a [`Rule`], closed on the object, in equilibrium there. Where neither phalanx would have
//! to pull the grasp is stable (force positiveness); within the stable region one more quantity can be looked at: palm force
//! positiveness, form closure, forces, sizing, mass. Sizing and form closure know nothing of friction, so a design is
//! sized once for all coefficients. A design that does not exist stays in its place, with the reason.
//!
//! | file | job |
//! |---|---|
//! | `axes` | the three axes and the order of the points |
//! | `point` | one design: built, sized, closed, held |
//! | `run` | all points on many threads |
//! | `quantity` | what a point can be coloured by |
//! | `cells` | what each point shows, also of an intersection |
//! | `shares` | counts, maxima, intersections over the bases |

mod axes;
mod cells;
mod point;
mod quantity;
mod run;
mod shares;

pub use crate::study::pool::all_cores;
pub use axes::{Axes, Axis};
pub use cells::{Cell, cells, intersection_cells};
pub use point::{Closed, NoFinger, Point, Sized, State, close, design, hold};
pub use quantity::{Quantity, Worst};
pub use run::{MOST_POINTS, volumes, volumes_with};
pub use shares::{Best, Intersection, Shares, intersection, intersections, percent, shares};

use crate::scene::Template;
use crate::sizing::Rule;

/// What is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeRequest {
    /// What all designs have in common.
    pub template: Template,
    pub bases_m: Vec<f64>,
    pub mu_static: Vec<f64>,
    pub axes: Axes,
    pub rule: Rule,
}

impl VolumeRequest {
    /// The volumes of the thesis: four bases, three coefficients of friction, 20³ points each.
    pub fn thesis() -> Self {
        Self {
            template: Template::thesis(),
            bases_m: vec![0.012, 0.0155, 0.019, 0.0225],
            mu_static: vec![0.0, 0.4, 0.8],
            axes: Axes::thesis([20; 3]),
            rule: Rule::Rigid,
        }
    }

    /// Whether this can be computed. Designs that do not exist are no mistake; what no design could have is.
    fn check(&self) -> Result<(), VolumeError> {
        let lists = [("base", &self.bases_m, f64::MIN_POSITIVE), ("coefficient of friction", &self.mu_static, 0.0)];
        for (what, list, least) in lists {
            if list.is_empty() {
                return Err(VolumeError::Nothing { what });
            }
            if let Some(&value) = list.iter().find(|value| !(value.is_finite() && **value >= least)) {
                let allowed = if least > 0.0 { "above 0" } else { "at least 0" };
                return Err(VolumeError::Value { what, value, allowed });
            }
            if let Some((index, &value)) = list.iter().enumerate().find(|(i, value)| list[..*i].contains(value)) {
                return Err(VolumeError::Twice { what, value, place: index + 1 });
            }
        }
        for (what, axis) in
            [("l21", &self.axes.l21_fraction), ("phi22", &self.axes.phi22_rad), ("arm_ratio", &self.axes.arm_ratio)]
        {
            if !(axis.from.is_finite() && axis.to.is_finite() && axis.from <= axis.to) {
                return Err(VolumeError::Limits { what, from: axis.from, to: axis.to });
            }
            if axis.points == 0 {
                return Err(VolumeError::NoPoints { what });
            }
        }
        let lists = self.bases_m.len().checked_mul(self.mu_static.len());
        let points = self.axes.resolution().into_iter().try_fold(1usize, usize::checked_mul);
        match lists.zip(points).and_then(|(lists, points)| lists.checked_mul(points)) {
            Some(points) if points <= MOST_POINTS => Ok(()),
            points => Err(VolumeError::TooMany { points: points.unwrap_or(usize::MAX) }),
        }
    }
}

/// The volume of one base and one coefficient of friction.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    pub base_m: f64,
    pub mu_static: f64,
    pub axes: Axes,
    /// As [`Axes::index`] has them: r_l fastest, then φ22, then l21.
    pub points: Vec<Point>,
}

impl Volume {
    /// Points along l21, φ22 and r_l.
    pub fn resolution(&self) -> [usize; 3] {
        self.axes.resolution()
    }

    /// The point at indices along l21, φ22 and r_l.
    pub fn point(&self, at: [usize; 3]) -> &Point {
        &self.points[self.axes.index(at)]
    }
}

/// Why there are no volumes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VolumeError {
    #[error("no {what} was asked for: give at least one")]
    Nothing { what: &'static str },
    #[error("{value} is no {what}: it must be a finite number {allowed}")]
    Value { what: &'static str, value: f64, allowed: &'static str },
    #[error("the {what} {value} is there twice (its second place is {place}): give each once")]
    Twice { what: &'static str, value: f64, place: usize },
    #[error("the axis {what} goes from {from} to {to}: give finite limits, the lower one first")]
    Limits { what: &'static str, from: f64, to: f64 },
    #[error("the axis {what} has no points: give at least 1")]
    NoPoints { what: &'static str },
    #[error(
        "that is {points} points in all, more than the {MOST_POINTS} that are kept in memory: lower the resolution, or give \
         fewer bases or coefficients of friction"
    )]
    TooMany { points: usize },
    #[error("the volumes were stopped after {done} of {total} designs")]
    Stopped { done: usize, total: usize },
}
