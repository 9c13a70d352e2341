//! How much of the difference in the volumes is a matter of where the points lie and of the torques.
//!
//! A volume of points that has its ends on the faces of the space counts the faces for more than they are; points in the
//! middles of cells do not. With the same points the shares by other torques show what sizing does.

use super::designs::{PRINTED_MOTOR_N_M, PRINTED_SPRING_N_M};
use super::sizing::SizingFound;
use super::{ReproduceError, STOPPED};
use crate::gripper::{Placement, Spring, SpringKind};
use crate::scene::Template;
use crate::sizing::Rule;
use crate::statics::{drive_loads, equilibrium};
use crate::study::volume::{Axes, Axis, Closed, close, design};

/// Cells along each axis.
pub const CELLS: usize = 10;

/// Shares of one base, in percent, over the middles of [`CELLS`]³ cells; without friction and with μ_s = 0.8.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    pub base_m: f64,
    /// By the sizing of the volumes.
    pub stable_percent: [f64; 2],
    /// Stable without friction and form-closed.
    pub closed_percent: f64,
    /// With the spring stronger by the printed ratio of design 95, and with the motor weaker by its own too.
    pub strong_spring_percent: [f64; 2],
    pub both_percent: [f64; 2],
}

/// One for each base of the thesis, while it may `go_on`.
pub fn grids(sizing: &SizingFound, go_on: &dyn Fn() -> bool) -> Result<Vec<Grid>, ReproduceError> {
    let spring = PRINTED_SPRING_N_M / sizing.rigid.spring_n_m;
    let motor = PRINTED_MOTOR_N_M / sizing.rigid.motor_n_m;
    let template = Template::thesis();
    let axes = middles(Axes::thesis([CELLS; 3]));
    let one = |base_m: f64| -> Result<Grid, ReproduceError> {
        let error = ReproduceError::of("the volumes by other torques");
        let (mut counts, mut closed_and_stable) = ([[0usize; 2]; 3], 0usize);
        for index in 0..axes.len() {
            if !go_on() {
                return Err(error(&STOPPED));
            }
            let closed = close(&template, &design(&template, base_m, axes.at(index)), Rule::Rigid)
                .map_err(|reason| error(&reason))?;
            for (mu, mu_static) in [0.0, 0.8].into_iter().enumerate() {
                for (count, factors) in counts.iter_mut().zip([[1.0, 1.0], [1.0, spring], [motor, spring]]) {
                    count[mu] += usize::from(holds(&closed, factors, mu_static)?);
                }
            }
            closed_and_stable += usize::from(closed.sized.form_closed && holds(&closed, [1.0, 1.0], 0.0)?);
        }
        let percent = |count: usize| 100.0 * count as f64 / axes.len() as f64;
        let [stable, strong, both] = counts.map(|of| of.map(percent));
        Ok(Grid {
            base_m,
            stable_percent: stable,
            closed_percent: percent(closed_and_stable),
            strong_spring_percent: strong,
            both_percent: both,
        })
    };
    [0.012, 0.0155, 0.019, 0.0225].into_iter().map(one).collect()
}

/// The same space with points in the middles of cells.
fn middles(axes: Axes) -> Axes {
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

/// Force positiveness with motor and spring times these factors.
fn holds(closed: &Closed, [motor, spring]: [f64; 2], mu_static: f64) -> Result<bool, ReproduceError> {
    let error = ReproduceError::of("static stability");
    let sizing = closed.sized.sizing;
    let kind = SpringKind::Constant { torque_n_m: sizing.spring_n_m * spring };
    let spring = Spring { kind, placement: Placement::Phalanges };
    let loads = drive_loads(&closed.finger, &closed.end, sizing.motor_n_m * motor, Some(&spring))
        .map_err(|reason| error(&reason))?;
    let forces = equilibrium(&closed.finger, &closed.end, loads, mu_static).map_err(|reason| error(&reason))?;
    Ok(forces.is_force_positive())
}
