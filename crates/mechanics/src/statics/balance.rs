//! Equations of a system at rest in SI units: the largest multiple of a driving load that contacts and drives can balance,
//! such as the acceleration of a base.
//!
//! Contact forces lie within their friction cones, and drives exert any torque between their bounds. The multiples that such
//! forces can balance are an interval; its upper end is the solution of a linear programme, certified by a motion. Existence
//! of these forces does not imply that they occur: if friction makes the forces indeterminate, they depend on how the hand was
//! closed. The result is therefore an upper bound on the acceleration that a grasp withstands without slipping.

use super::Result;
use super::balance_program::{self, Column, Load, Optimum, Program, ROUNDING, power, size};
use crate::gripper::number;
use crate::numeric::elementary::{hypot, sin_cos};

/// State of a contact in the motion, and hence in every set of forces that balances the largest acceleration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactMotion {
    /// The force may be anywhere in the friction cone.
    Sticks,
    /// The force is on an edge of the cone.
    Slips,
    /// The force is zero.
    Separates,
}

/// Torque of a brake at the largest acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrakeLoad {
    pub torque_n_m: f64,
    pub slips: bool,
}

/// Equations of a system at rest: what balances a multiple of a driving load.
#[derive(Clone, Debug)]
pub(super) struct Equations {
    /// Unilateral forces.
    pub contacts: Vec<Cone>,
    /// Column of a unit torque of each drive, with the range of its torque.
    pub drives: Vec<(Load, [f64; 2])>,
    /// Loads that do not change.
    pub fixed: Load,
    /// Load of an acceleration of 1 m/s².
    pub driving: Load,
    /// Length by which the load of each row is divided to give a force.
    pub lengths: Vec<f64>,
}

/// A unilateral normal force with friction: columns of unit forces along the normal and along the tangent.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cone {
    pub columns: [Load; 2],
    pub mu: f64,
}

/// Largest multiple of a driving load.
pub(super) enum Largest {
    /// All admissible forces have positive power in a motion, with the rate of each row as in [`Certified`].
    Infeasible {
        motion: Load,
    },
    Unlimited,
    Limited(Certified),
}

/// The largest multiple with its certificate.
pub(super) struct Certified {
    pub acceleration_m_s2: f64,
    /// Normal and tangential force of each cone, and its motion.
    pub contacts: Vec<(f64, f64, ContactMotion)>,
    pub brakes: Vec<BrakeLoad>,
    /// Rate of each row, m/s times the length of the row; rounding errors are cleared.
    pub motion: Load,
    pub gap: f64,
}

/// The linear programme in normalised units: rows in N, columns and fixed load of size about 1.
struct Scaled {
    program: Program,
    /// Unit of force, N.
    force: f64,
    /// Unit of acceleration, m/s².
    acceleration: f64,
}

impl Cone {
    /// Columns of unit forces along the edges; without friction there is one edge.
    pub(super) fn edges(&self) -> impl Iterator<Item = Load> + '_ {
        let [normal, tangential] = &self.columns;
        let edge =
            move |mu: f64| normal.iter().zip(tangential).map(|(normal, tangent)| normal + mu * tangent).collect();
        [self.mu, -self.mu].into_iter().take(if self.mu > 0.0 { 2 } else { 1 }).map(edge)
    }
}

fn scale_programme(equations: &Equations) -> Scaled {
    let Equations { contacts, drives, fixed, driving, lengths } = equations;
    let in_newtons =
        |column: &[f64]| -> Load { column.iter().zip(lengths).map(|(load, length)| load / length).collect() };
    let column = |load: &[f64], bounds: [f64; 2]| {
        let load = in_newtons(load);
        let size = Some(size(&load)).filter(|size| *size > 0.0).unwrap_or(1.0);
        Column { load: load.iter().map(|entry| entry / size).collect(), bounds, size }
    };
    let fixed = in_newtons(fixed);
    let drives: Vec<Column> = drives.iter().map(|(load, bounds)| column(load, *bounds)).collect();
    let brake_bounds = drives.iter().flat_map(|drive| drive.bounds.map(|bound| bound.abs() * drive.size));
    let largest_brake = brake_bounds.filter(|bound| bound.is_finite()).fold(0.0, f64::max);
    let force = [size(&fixed), largest_brake].into_iter().find(|force| *force > 0.0).unwrap_or(1.0);
    let unilateral = [0.0, f64::INFINITY];
    let driving = column(driving, unilateral);
    let acceleration = force / driving.size;
    let mut columns = vec![driving];
    columns.extend(contacts.iter().flat_map(Cone::edges).map(|edge| column(&edge, unilateral)));
    let edge_count = columns.len() - 1;
    columns.extend(
        drives
            .into_iter()
            .map(|drive| Column { bounds: drive.bounds.map(|bound| bound * drive.size / force), ..drive }),
    );
    let fixed = fixed.iter().map(|entry| entry / force).collect();
    Scaled { program: Program { columns, edge_count, fixed }, force, acceleration }
}

/// Returns the largest multiple of the driving load that can be balanced. `is_balanced` says whether the fixed load is known
/// to be balanced, for several driving loads of the same equations.
pub(super) fn largest_multiple(equations: &Equations, is_balanced: &mut bool) -> Result<Largest> {
    let scaled = scale_programme(equations);
    Ok(match scaled.program.largest(is_balanced)? {
        Optimum::Infeasible { motion } => Largest::Infeasible { motion: row_rates(equations, &motion) },
        Optimum::Unbounded => Largest::Unlimited,
        Optimum::Finite(limit) => Largest::Limited(certified(equations, &scaled, &limit)),
    })
}

/// Rates of the rows of the equations in a motion of the programme, without rounding errors.
fn row_rates(equations: &Equations, motion: &[f64]) -> Load {
    let rounding = ROUNDING * size(motion);
    let clear_rounding = |(rate, length): (&f64, &f64)| if rate.abs() <= rounding { 0.0 } else { rate / length };
    motion.iter().zip(&equations.lengths).map(clear_rounding).collect()
}

/// The verified result of the programme in the units of the equations.
fn certified(equations: &Equations, scaled: &Scaled, limit: &balance_program::ProgramLimit) -> Certified {
    let (program, balance_program::ProgramLimit { forces, motion, gap }) = (&scaled.program, limit);
    let rounding = ROUNDING * size(motion);
    let rate = |index: usize| power(motion, &program.columns[index].load);
    let si_force = |index: usize| forces[index] * scaled.force / program.columns[index].size;
    let mut edges = program.contact_edges().map(|index| (si_force(index), rate(index) > rounding));
    let mut contact_load = |cone: &Cone| {
        let mut next = || edges.next().unwrap_or((0.0, true));
        let (first, separates) = next();
        if cone.mu <= 0.0 {
            return (first, 0.0, if separates { ContactMotion::Separates } else { ContactMotion::Sticks });
        }
        let (second, other_separates) = next();
        let contact_motion = match (separates, other_separates) {
            (false, false) => ContactMotion::Sticks,
            (true, true) => ContactMotion::Separates,
            _ => ContactMotion::Slips,
        };
        (first + second, cone.mu * (first - second), contact_motion)
    };
    let contacts = equations.contacts.iter().map(&mut contact_load).collect();
    let brakes = program.torques().map(|index| {
        let [lo, hi] = program.columns[index].bounds;
        BrakeLoad { torque_n_m: si_force(index), slips: lo < hi && rate(index).abs() > rounding }
    });
    Certified {
        acceleration_m_s2: forces[0] * scaled.acceleration,
        contacts,
        brakes: brakes.collect(),
        motion: row_rates(equations, motion),
        gap: *gap,
    }
}

/// Returns the unit vector at an angle; exact along the axes.
pub(super) fn direction_at(angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = sin_cos(angle_rad);
    [cos, sin].map(|component| if component.abs() < f64::EPSILON { 0.0 } else { component })
}

pub(super) fn unit_direction(direction: [f64; 2]) -> Result<[f64; 2]> {
    let length = hypot(direction[0], direction[1]);
    number("the norm of the direction", length, length > 0.0, "must be finite, more than 0")?;
    Ok(direction.map(|component| component / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    const R: f64 = 0.02;
    const N: f64 = 5.0;
    const M: f64 = 0.05;
    const G: f64 = 9.81;

    /// Returns a disc between two contacts on the x axis, each loaded by N and by the torque of a brake, and accelerated in a
    /// direction. Rows are the torques on the two fingers, and the force and moment on the disc.
    fn antipodal(mu: f64, brake_n_m: [f64; 2], degrees: f64) -> Equations {
        let contact = |finger: usize, mirror: f64| {
            let mut columns = [vec![0.0; 5], vec![0.0; 5]];
            (columns[0][finger], columns[0][2]) = (-R, -mirror);
            (columns[1][3], columns[1][4]) = (-1.0, -mirror * R);
            Cone { columns, mu }
        };
        let drive = |finger: usize| ((0..5).map(|row| f64::from(row == finger)).collect(), brake_n_m);
        let [x, y] = direction_at(degrees.to_radians());
        Equations {
            contacts: vec![contact(0, 1.0), contact(1, -1.0)],
            drives: vec![drive(0), drive(1)],
            fixed: vec![N * R, N * R, 0.0, M * G, 0.0],
            driving: vec![0.0, 0.0, -M * x, -M * y, 0.0],
            lengths: vec![R, R, 1.0, 1.0, R],
        }
    }

    #[track_caller]
    fn limit(equations: &Equations) -> Certified {
        match largest_multiple(equations, &mut false).expect("a solution") {
            Largest::Limited(limit) => limit,
            Largest::Infeasible { .. } => panic!("infeasible"),
            Largest::Unlimited => panic!("unlimited"),
        }
    }

    #[test]
    fn a_disc_between_two_fixed_forces_is_limited_by_their_friction() {
        for mu in [0.1, 0.3, 0.8] {
            let largest = 2.0 * mu * N / M;
            for (degrees, expected) in
                [(-90.0, largest - G), (90.0, largest + G), (0.0, 0.0), (180.0, 0.0), (40.0, 0.0)]
            {
                let found = limit(&antipodal(mu, [0.0; 2], degrees));
                let acceleration = found.acceleration_m_s2;
                assert!((acceleration - expected).abs() < 1e-9 * largest, "{mu} {degrees}: {acceleration}");
                assert!(found.gap < 1e-12 && found.contacts.iter().all(|(normal, ..)| (normal - N).abs() < 1e-9));
            }
            // For upward acceleration both contacts slip and the object moves; friction on the fingers points up.
            let up = limit(&antipodal(mu, [0.0; 2], -90.0));
            for (_, tangential, motion) in &up.contacts {
                assert!(*motion == ContactMotion::Slips && (tangential - mu * N).abs() < 1e-9, "{:?}", up.contacts);
            }
            assert!(up.motion[3] > 0.0 && up.motion[2] == 0.0, "{:?}", up.motion);
        }
        // Friction cannot balance the weight: 2 μ N = 0.4 N of 0.49 N.
        let heavy = antipodal(0.04, [0.0; 2], -90.0);
        assert!(matches!(largest_multiple(&heavy, &mut false), Ok(Largest::Infeasible { .. })));
        // Without weight, friction balances the inertia alone.
        let weightless = Equations { fixed: vec![N * R, N * R, 0.0, 0.0, 0.0], ..heavy };
        assert!((limit(&weightless).acceleration_m_s2 - 2.0 * 0.04 * N / M).abs() < 1e-9);
    }

    /// With brakes up to T/r: m |a_x| ≤ T/r, and at the unloaded contact m |g − a_y|/2 ≤ μ (N + T/r − m |a_x|).
    #[test]
    fn one_way_brakes_match_the_analytic_polygon() {
        let (mu, torque) = (0.4, 0.06);
        for degrees in (0..360).step_by(7).map(f64::from) {
            let [x, y] = direction_at(degrees.to_radians());
            let x = x.abs();
            let loaded = N + torque / R;
            // m (g − a y)/2 ≤ μ (loaded − m a x), for either sign of the left side.
            let sinking_limit = (mu * loaded - 0.5 * M * G) / (M * (mu * x - 0.5 * y));
            let rising_limit = (mu * loaded + 0.5 * M * G) / (M * (mu * x + 0.5 * y));
            let sliding_limit = torque / R / (M * x);
            let expected = [sinking_limit, rising_limit, sliding_limit]
                .into_iter()
                .filter(|a| *a > 0.0)
                .fold(f64::INFINITY, f64::min);
            let found = limit(&antipodal(mu, [0.0, torque], degrees)).acceleration_m_s2;
            assert!((found - expected).abs() < 1e-8 * expected, "{degrees}: {found} {expected}");
        }
        // Unlimited brakes: the normal forces can grow without bound, and so can the acceleration.
        let independent = antipodal(mu, [0.0, f64::INFINITY], -67.0);
        assert!(matches!(largest_multiple(&independent, &mut false), Ok(Largest::Unlimited)));
        // Overloaded brakes slip; motors without brakes do not.
        assert!(limit(&antipodal(mu, [0.0, torque], 0.0)).brakes.iter().any(|brake| brake.slips));
        assert!(limit(&antipodal(mu, [0.0; 2], -90.0)).brakes.iter().all(|brake| !brake.slips));
    }

    #[test]
    fn rejects_directions_of_zero_or_undefined_length() {
        for direction in [[0.0, 0.0], [f64::NAN, 1.0]] {
            let error = unit_direction(direction).expect_err("no direction");
            assert!(error.to_string().contains("norm of the direction"), "{error}");
        }
    }
}
