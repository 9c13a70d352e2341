//! Influence of the grid and of the torques on the volumes.
//!
//! A grid with points on the faces of the space overweights the faces; points at cell centres do not. Percentages with
//! other torques on the same points show the influence of sizing.

use super::designs::{PRINTED_MOTOR_N_M, PRINTED_SPRING_N_M};
use super::sizing::SizingFound;
use super::{INTERRUPTED, ReproduceError};
use crate::gripper::{Placement, Spring, SpringKind};
use crate::scene::Template;
use crate::sizing::Rule;
use crate::statics::{drive_loads, equilibrium};
use crate::study::volume::{Axes, Axis, ClosedFinger, close_finger, design_at};

/// Number of cells along each axis.
pub const CELLS_PER_AXIS: usize = 10;

/// Percentages for one base over the centres of [`CELLS_PER_AXIS`]³ cells, without friction and with μ_s = 0.8.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    pub base_m: f64,
    /// Stable, with the sizing of the volumes.
    pub stable_percent: [f64; 2],
    /// Stable without friction and form-closed.
    pub closed_percent: f64,
    /// Stable, with the spring torque scaled by the printed ratio of design 95.
    pub stronger_spring_percent: [f64; 2],
    /// Stable, with spring and motor torque scaled by the printed ratios of design 95.
    pub both_torques_percent: [f64; 2],
}

/// Computes the percentages for each base of the thesis.
///
/// # Errors
/// Returns an error if a finger or its statics cannot be computed, or `keep_running` returned `false`.
pub fn grids(sizing: &SizingFound, keep_running: &dyn Fn() -> bool) -> Result<Vec<Grid>, ReproduceError> {
    let spring_ratio = PRINTED_SPRING_N_M / sizing.rigid.spring_n_m;
    let motor_ratio = PRINTED_MOTOR_N_M / sizing.rigid.motor_n_m;
    let template = Template::thesis();
    let axes = cell_centres(Axes::thesis([CELLS_PER_AXIS; 3]));
    let grid = |base_m: f64| -> Result<Grid, ReproduceError> {
        let error = ReproduceError::in_step("the volumes by other torques");
        let (mut counts, mut closed_and_stable) = ([[0usize; 2]; 3], 0usize);
        for index in 0..axes.len() {
            if !keep_running() {
                return Err(error(&INTERRUPTED));
            }
            let closed = close_finger(&template, &design_at(&template, base_m, axes.at(index)), Rule::Rigid)
                .map_err(|reason| error(&reason))?;
            for (mu, mu_static) in [0.0, 0.8].into_iter().enumerate() {
                for (count, factors) in
                    counts.iter_mut().zip([[1.0, 1.0], [1.0, spring_ratio], [motor_ratio, spring_ratio]])
                {
                    count[mu] += usize::from(is_force_positive(&closed, factors, mu_static)?);
                }
            }
            closed_and_stable += usize::from(closed.sized.form_closed && is_force_positive(&closed, [1.0, 1.0], 0.0)?);
        }
        let percent = |count: usize| 100.0 * count as f64 / axes.len() as f64;
        let [stable, stronger_spring, both] = counts.map(|count| count.map(percent));
        Ok(Grid {
            base_m,
            stable_percent: stable,
            closed_percent: percent(closed_and_stable),
            stronger_spring_percent: stronger_spring,
            both_torques_percent: both,
        })
    };
    [0.012, 0.0155, 0.019, 0.0225].into_iter().map(grid).collect()
}

/// Returns the same space with points at cell centres.
fn cell_centres(axes: Axes) -> Axes {
    let shrink = |axis: Axis| {
        let half = 0.5 * (axis.to - axis.from) / axis.points as f64;
        Axis::new(axis.from + half, axis.to - half, axis.points)
    };
    Axes {
        l21_fraction: shrink(axes.l21_fraction),
        phi22_rad: shrink(axes.phi22_rad),
        arm_ratio: shrink(axes.arm_ratio),
    }
}

/// Returns whether the grasp is force-positive with motor and spring torque multiplied by factors.
fn is_force_positive(closed: &ClosedFinger, [motor, spring]: [f64; 2], mu_static: f64) -> Result<bool, ReproduceError> {
    let error = ReproduceError::in_step("static stability");
    let sizing = closed.sized.sizing;
    let kind = SpringKind::Constant { torque_n_m: sizing.spring_n_m * spring };
    let spring = Spring { kind, placement: Placement::Phalanges };
    let loads = drive_loads(&closed.finger, &closed.end, sizing.motor_n_m * motor, Some(&spring))
        .map_err(|reason| error(&reason))?;
    let forces = equilibrium(&closed.finger, &closed.end, loads, mu_static).map_err(|reason| error(&reason))?;
    Ok(forces.is_force_positive())
}
