//! Largest palm acceleration at which the contacts can still keep the object at rest in the hand.
//!
//! At rest in the frame of the palm, all forces on the object and on both coordinates of each finger balance. Contact
//! forces lie within their friction cones, motors exert their torque, and brakes any torque up to their limit. The
//! accelerations that such forces can balance form a convex set; its boundary in a direction is the solution of a
//! linear programme, certified by a motion. Existence of these forces does not imply that they occur: if friction makes
//! the forces indeterminate, they depend on how the hand was closed. The result is therefore an upper bound on the
//! acceleration that a grasp withstands without slipping.

use super::balance_program::{self, Column, Load, Optimum, Program, ROUNDING, power, size};
use super::equilibrium::spring_loads;
use super::equilibrium::static_kinematics_at;
use super::hand::{ClosestPoint, FingerGeometry};
use super::{GraspConfiguration, PerContact, Result, Side, StaticKinematics};
use crate::fivebar::dynamics::{AccelerationField, InertialForces};
use crate::gripper::{FingerContact, Spring, number};
use crate::numeric::elementary::{hypot, sin_cos};
use crate::numeric::plane::{add, cross, scale, sub};
use crate::shape;
use std::f64::consts::TAU;

/// Number of equilibrium equations of a gripper and its object at rest in the frame of the palm.
///
/// Rows are the generalised forces on (q11, q21) of the right and the left finger, N·m (for the left finger, of its
/// mirror image), the force on the object along x and y of the palm frame, N, and the moment about the object's centre,
/// N·m. A translating palm causes a uniform field, gravity minus its acceleration, on the object and on every link.
const ROWS: usize = 7;

/// The largest acceleration of the palm in one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Balance {
    /// Unit vector in the frame of the palm.
    pub direction: [f64; 2],
    pub largest: AccelerationLimit,
}

/// Range of accelerations that can be balanced.
#[derive(Clone, Debug, PartialEq)]
pub enum AccelerationLimit {
    /// Not even a palm at rest: no forces within the cones balance weight, springs and motors.
    Infeasible,
    /// Any acceleration up to a limit.
    Limited(Limit),
    /// Any acceleration: the balancing forces can grow with it.
    Unlimited,
}

impl AccelerationLimit {
    /// Returns the limit, m/s²; `None` if there is no limit and if the balance is infeasible.
    pub fn acceleration_m_s2(&self) -> Option<f64> {
        match self {
            AccelerationLimit::Limited(limit) => Some(limit.acceleration_m_s2),
            AccelerationLimit::Infeasible | AccelerationLimit::Unlimited => None,
        }
    }
}

/// The largest acceleration with its certificate.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    pub acceleration_m_s2: f64,
    /// Forces that balance the acceleration; not necessarily unique.
    pub contacts: Vec<ContactLoad>,
    /// Torque of each brake, N·m, and whether it slips.
    pub brakes: Vec<BrakeLoad>,
    /// The motion that a larger acceleration causes and no force within the cones prevents, normalised to an object
    /// speed of 1 mm/s (if the object is at rest, to 1 rad/s of the fastest joint).
    pub motion: HandMotion,
    /// Difference of the limits from forces and from motion, relative to the limit or the scale of the fixed loads.
    pub gap: f64,
}

/// Force of a contact or joint limit at the largest acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLoad {
    pub location: ContactLocation,
    /// Normal force, N; for a joint limit a torque, N·m.
    pub normal_n: f64,
    /// Friction on phalanx or palm along t = (n_y, −n_x), N; mirrored on the left.
    pub tangential_n: f64,
    pub contact_motion: ContactMotion,
}

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

/// A motion of object and fingers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandMotion {
    pub object_m_s: [f64; 2],
    pub spin_rad_s: f64,
    /// (q̇11, q̇21) of the right and the left finger; for the left finger, of its mirror image.
    pub fingers_rad_s: [[f64; 2]; 2],
}

/// Returns the largest acceleration of a translating palm in a direction that forces within their cones can balance.
pub fn balanced_acceleration(hand: &HandAtRest<'_>, direction: [f64; 2]) -> Result<Balance> {
    largest_acceleration(&loads(hand)?, direction)
}

/// [`balanced_acceleration`] in `count` equally spaced directions, from x towards y of the frame of the palm.
pub fn balance_polar(hand: &HandAtRest<'_>, count: usize) -> Result<Vec<Balance>> {
    let loads = loads(hand)?;
    (0..count).map(|index| largest_acceleration(&loads, direction_at(TAU * index as f64 / count as f64))).collect()
}

/// Returns the unit vector at an angle; exact along the axes.
fn direction_at(angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = sin_cos(angle_rad);
    [cos, sin].map(|component| if component.abs() < f64::EPSILON { 0.0 } else { component })
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
    fn edges(&self) -> impl Iterator<Item = Load> + '_ {
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

/// Returns the largest multiple of the driving load that can be balanced.
pub(super) fn largest_multiple(equations: &Equations) -> Result<Largest> {
    let scaled = scale_programme(equations);
    Ok(match scaled.program.largest()? {
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

fn largest_acceleration(loads: &Loads, direction: [f64; 2]) -> Result<Balance> {
    let direction = unit_direction(direction)?;
    let [x, y] = direction;
    let r = loads.length_m;
    let equations = Equations {
        contacts: loads.contacts.iter().map(|contact| contact.cone.clone()).collect(),
        drives: loads.drives.clone(),
        fixed: loads.fixed.clone(),
        driving: (0..ROWS).map(|row| x * loads.inertia[0][row] + y * loads.inertia[1][row]).collect(),
        lengths: vec![r, r, r, r, 1.0, 1.0, r],
    };
    let limit = |found: Certified| Limit {
        acceleration_m_s2: found.acceleration_m_s2,
        contacts: (loads.contacts.iter().zip(found.contacts))
            .map(|(contact, (normal_n, tangential_n, contact_motion))| ContactLoad {
                location: contact.location,
                normal_n,
                tangential_n,
                contact_motion,
            })
            .collect(),
        brakes: found.brakes,
        motion: normalised_motion(&found.motion),
        gap: found.gap,
    };
    let largest = match largest_multiple(&equations)? {
        Largest::Infeasible { .. } => AccelerationLimit::Infeasible,
        Largest::Unlimited => AccelerationLimit::Unlimited,
        Largest::Limited(found) => AccelerationLimit::Limited(limit(found)),
    };
    Ok(Balance { direction, largest })
}

pub(super) fn unit_direction(direction: [f64; 2]) -> Result<[f64; 2]> {
    let length = hypot(direction[0], direction[1]);
    number("the norm of the direction", length, length > 0.0, "must be finite, more than 0")?;
    Ok(direction.map(|component| component / length))
}

/// Normalises a motion.
fn normalised_motion(rates: &[f64]) -> HandMotion {
    let rates: [f64; ROWS] = std::array::from_fn(|row| rates[row]);
    let [q11_r, q21_r, q11_l, q21_l, x, y, spin] = rates;
    let speed = hypot(x, y);
    let fastest = [q11_r, q21_r, q11_l, q21_l, spin].into_iter().fold(0.0, |most: f64, rate| most.max(rate.abs()));
    let unit = if speed > 0.0 { speed * 1e3 } else { fastest.max(f64::MIN_POSITIVE) };
    HandMotion {
        object_m_s: [x / unit, y / unit],
        spin_rad_s: spin / unit,
        fingers_rad_s: [[q11_r, q21_r], [q11_l, q21_l]].map(|finger| finger.map(|rate| rate / unit)),
    }
}

const X: usize = 4;
const MOMENT: usize = 6;

/// A gripper at rest in the frame of its palm, with its loads.
#[derive(Clone, Debug, PartialEq)]
pub struct HandAtRest<'a> {
    pub configuration: GraspConfiguration<'a>,
    /// Friction coefficients of the active contacts.
    pub friction: PerContact<Option<f64>>,
    /// Whether the tip is on its joint limit, right and left.
    pub limits: [bool; 2],
    pub springs: [Option<Spring>; 2],
    pub drives: Vec<Drive>,
    pub mass_kg: f64,
    /// Gravity in the frame of the palm.
    pub gravity_m_s2: [f64; 2],
}

/// A motor and the fractions of its torque on the driven links (right, left).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    pub weights: [f64; 2],
    /// Motor torque, N·m; positive torques close the finger.
    pub torque_n_m: f64,
    /// Smallest and largest torque of the brake, N·m: infinite for a blocked motor, 0 and 0 without a brake.
    pub brake_n_m: [f64; 2],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactLocation {
    Finger(Side, FingerContact),
    Palm,
}

/// An active contact with the object, or an active joint limit, which has a torque instead of a force, and no friction.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ContactColumns {
    pub location: ContactLocation,
    /// Point on the surface of phalanx or palm; `None` for a joint limit.
    pub point_m: Option<[f64; 2]>,
    /// Unit normal into the object, in the frame of the palm.
    pub normal: [f64; 2],
    /// Columns of a unit normal force (torque of a limit) and of a unit friction force on phalanx or palm along t =
    /// (n_y, −n_x), mirrored on the left.
    pub cone: Cone,
}

/// All columns of the equations.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Loads {
    pub contacts: Vec<ContactColumns>,
    /// Column of a unit torque of each drive, with the range of its brake torque.
    pub drives: Vec<(Load, [f64; 2])>,
    /// Column of springs, motors and weight.
    pub fixed: Load,
    /// Columns of a palm acceleration of 1 m/s² along x and along y.
    pub inertia: [Load; 2],
    /// Length by which moments are divided to make them comparable with forces.
    pub length_m: f64,
}

fn rows(side: Side) -> [usize; 2] {
    [2 * side as usize, 2 * side as usize + 1]
}

/// Computes the columns of a posture.
pub(super) fn loads(hand: &HandAtRest<'_>) -> Result<Loads> {
    let HandAtRest { configuration, friction, mass_kg, gravity_m_s2: [gx, gy], .. } = hand;
    number("the object's mass", *mass_kg, *mass_kg > 0.0, "must be finite, more than 0 kg")?;
    number("gravity", gx + gy, true, "must be finite")?;
    let mut loads = Loads {
        contacts: Vec::new(),
        drives: Vec::with_capacity(hand.drives.len()),
        fixed: vec![0.0; ROWS],
        inertia: [vec![0.0; ROWS], vec![0.0; ROWS]],
        length_m: shape::max_radius(&configuration.object.shape),
    };
    for side in Side::BOTH {
        add_finger(hand, side, &mut loads)?;
    }
    if let Some(mu) = friction.palm {
        // The contact point is on the palm below the object: the lever of friction is the height of its centre.
        let ([x, y], [lowest, _]) = (configuration.object.centre_m, configuration.object.lowest_point_m());
        let mut columns = [vec![0.0; ROWS], vec![0.0; ROWS]];
        (columns[0][X + 1], columns[0][MOMENT]) = (1.0, lowest - x);
        (columns[1][X], columns[1][MOMENT]) = (-1.0, -y);
        loads.contacts.push(ContactColumns {
            location: ContactLocation::Palm,
            point_m: Some([lowest, 0.0]),
            normal: [0.0, 1.0],
            cone: Cone { columns, mu },
        });
    }
    for contact in &loads.contacts {
        number("mu_static", contact.cone.mu, contact.cone.mu >= 0.0, "must be finite, 0 or more")?;
    }
    for drive in &hand.drives {
        number("the motor torque", drive.torque_n_m, true, "must be finite")?;
        let mut column = vec![0.0; ROWS];
        for side in Side::BOTH {
            column[rows(side)[0]] = drive.weights[side as usize];
            loads.fixed[rows(side)[0]] += drive.weights[side as usize] * drive.torque_n_m;
        }
        loads.drives.push((column, drive.brake_n_m));
    }
    for (axis, gravity) in hand.gravity_m_s2.into_iter().enumerate() {
        loads.fixed[X + axis] += mass_kg * gravity;
        loads.inertia[axis][X + axis] -= mass_kg;
    }
    Ok(loads)
}

fn add_finger(hand: &HandAtRest<'_>, side: Side, loads: &mut Loads) -> Result<()> {
    let FingerGeometry { finger, posture, a22, object, phalanges } = hand.configuration.finger_geometry(side)?;
    let static_kinematics = static_kinematics_at(finger, &posture)?;
    let StaticKinematics { pose, rates, tip_slope } = &static_kinematics;
    let [first, second] = rows(side);
    let mirror = side.mirror();

    let spring = spring_loads(finger, &static_kinematics, hand.springs[side as usize].as_ref())?;
    (loads.fixed[first], loads.fixed[second]) = (loads.fixed[first] + spring[0], loads.fixed[second] + spring[1]);
    let links = InertialForces::new(finger, [0.5 * hand.configuration.palm_width_m, 0.0]);
    let generalised_force = |[x, y]: [f64; 2]| {
        let field = AccelerationField { uniform: [mirror * x, y], ..AccelerationField::default() };
        links.forces(pose, rates, [0.0; 4], &field)
    };
    let weight = generalised_force(hand.gravity_m_s2);
    (loads.fixed[first], loads.fixed[second]) = (loads.fixed[first] + weight[0], loads.fixed[second] + weight[1]);
    for (axis, unit) in [[-1.0, 0.0], [0.0, -1.0]].into_iter().enumerate() {
        [loads.inertia[axis][first], loads.inertia[axis][second]] = generalised_force(unit);
    }

    let phalanx_contacts = [FingerContact::Proximal, FingerContact::Distal];
    for (index, (contact, ClosestPoint { foot, normal, .. })) in phalanx_contacts.into_iter().zip(phalanges).enumerate()
    {
        let Some(mu) = hand.friction.phalanges[side as usize][index] else { continue };
        let point = add(foot, scale(normal, finger.lengths.half_width_m));
        let [nx, ny] = normal;
        // Unit forces on the phalanx: against the normal, which points into the object, and along t.
        let columns = [[-nx, -ny], [ny, -nx]].map(|force| {
            let mut column = vec![0.0; ROWS];
            match contact {
                FingerContact::Proximal => column[second] = cross(point, force),
                _ => {
                    let about_joint = cross(sub(point, a22), force);
                    column[first] = rates.a4[0] * about_joint;
                    column[second] = cross(a22, force) + rates.a4[1] * about_joint;
                }
            }
            let on_object = scale(force, -1.0);
            (column[X], column[X + 1]) = (mirror * on_object[0], on_object[1]);
            column[MOMENT] = mirror * cross(sub(point, object.centre_m), on_object);
            column
        });
        let (point_m, normal) = (Some(hand.configuration.in_palm_frame(side, point)), [mirror * nx, ny]);
        loads.contacts.push(ContactColumns {
            location: ContactLocation::Finger(side, contact),
            point_m,
            normal,
            cone: Cone { columns, mu },
        });
    }
    if hand.limits[side as usize] {
        // The torque of the joint limit opens the angle from l21 to the tip.
        let mut column = vec![0.0; ROWS];
        (column[first], column[second]) = (tip_slope[0], tip_slope[1]);
        let location = ContactLocation::Finger(side, FingerContact::Limit);
        let columns = [column, vec![0.0; ROWS]];
        loads.contacts.push(ContactColumns {
            location,
            point_m: None,
            normal: [0.0; 2],
            cone: Cone { columns, mu: 0.0 },
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gripper::FingerContact;
    use crate::statics::Side;

    const R: f64 = 0.02;
    const N: f64 = 5.0;
    const M: f64 = 0.05;
    const G: f64 = 9.81;

    /// Returns a disc between two contacts on the x axis, each loaded by N and by the torque of a brake; finger rows
    /// contain nothing else.
    fn antipodal(mu: f64, brake_n_m: [f64; 2]) -> Loads {
        let contact = |side: Side| {
            let mirror = side.mirror();
            let mut columns = [vec![0.0; ROWS], vec![0.0; ROWS]];
            (columns[0][2 * side as usize], columns[0][4]) = (-R, -mirror);
            (columns[1][5], columns[1][6]) = (-1.0, -mirror * R);
            let (location, point_m) = (ContactLocation::Finger(side, FingerContact::Proximal), Some([mirror * R, 0.0]));
            ContactColumns { location, point_m, normal: [-mirror, 0.0], cone: Cone { columns, mu } }
        };
        let drive = |row: usize| {
            let mut column = vec![0.0; ROWS];
            column[row] = 1.0;
            (column, brake_n_m)
        };
        Loads {
            contacts: Side::BOTH.map(contact).to_vec(),
            drives: vec![drive(0), drive(2)],
            fixed: vec![N * R, 0.0, N * R, 0.0, 0.0, M * G, 0.0],
            inertia: [vec![0.0, 0.0, 0.0, 0.0, -M, 0.0, 0.0], vec![0.0, 0.0, 0.0, 0.0, 0.0, -M, 0.0]],
            length_m: R,
        }
    }

    #[track_caller]
    fn limit(loads: &Loads, degrees: f64) -> Limit {
        match largest_acceleration(loads, direction_at(degrees.to_radians())).expect("a solution").largest {
            AccelerationLimit::Limited(limit) => limit,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_disc_between_two_fixed_forces_is_limited_by_their_friction() {
        for mu in [0.1, 0.3, 0.8] {
            let loads = antipodal(mu, [0.0; 2]);
            let largest = 2.0 * mu * N / M;
            for (degrees, expected) in
                [(-90.0, largest - G), (90.0, largest + G), (0.0, 0.0), (180.0, 0.0), (40.0, 0.0)]
            {
                let found = limit(&loads, degrees);
                assert!((found.acceleration_m_s2 - expected).abs() < 1e-9 * largest, "{mu} {degrees}: {found:?}");
                assert!(
                    found.gap < 1e-12
                        && found.contacts.iter().all(|contact_load| (contact_load.normal_n - N).abs() < 1e-9)
                );
            }
            // For upward acceleration both contacts slip and the object moves; friction on the fingers points up.
            let up = limit(&loads, -90.0);
            assert!(
                up.contacts.iter().all(|contact_load| contact_load.contact_motion == ContactMotion::Slips),
                "{up:?}"
            );
            assert!(up.contacts.iter().all(|contact_load| (contact_load.tangential_n - mu * N).abs() < 1e-9), "{up:?}");
            assert!((up.motion.object_m_s[1] - 1e-3).abs() < 1e-12 && up.motion.object_m_s[0].abs() < 1e-9, "{up:?}");
        }
        // Friction cannot balance the weight: 2 μ N = 0.4 N of 0.49 N.
        let found = largest_acceleration(&antipodal(0.04, [0.0; 2]), [0.0, -1.0]).expect("a solution");
        assert_eq!(found.largest, AccelerationLimit::Infeasible);
        // Without weight, friction balances the inertia alone.
        let mut weightless = antipodal(0.04, [0.0; 2]);
        weightless.fixed[5] = 0.0;
        assert!((limit(&weightless, -90.0).acceleration_m_s2 - 2.0 * 0.04 * N / M).abs() < 1e-9);
    }

    /// With brakes up to T/r: m |a_x| ≤ T/r, and at the unloaded contact m |g − a_y|/2 ≤ μ (N + T/r − m |a_x|).
    #[test]
    fn one_way_brakes_match_the_analytic_polygon() {
        let (mu, torque) = (0.4, 0.06);
        let loads = antipodal(mu, [0.0, torque]);
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
            let found = limit(&loads, degrees);
            assert!(
                (found.acceleration_m_s2 - expected).abs() < 1e-8 * expected,
                "{degrees}: {} {expected}",
                found.acceleration_m_s2
            );
        }
        // Unlimited brakes: the normal forces can grow without bound, and so can the acceleration.
        let independent = antipodal(mu, [0.0, f64::INFINITY]);
        assert_eq!(
            largest_acceleration(&independent, [0.3, -0.7]).expect("a solution").largest,
            AccelerationLimit::Unlimited
        );
        // Overloaded brakes slip; motors without brakes do not.
        let lateral_limit = limit(&loads, 0.0);
        assert!(lateral_limit.brakes.iter().any(|brake| brake.slips), "{lateral_limit:?}");
        assert!(limit(&antipodal(mu, [0.0; 2]), -90.0).brakes.iter().all(|brake| !brake.slips));
    }

    #[test]
    fn rejects_directions_of_zero_or_undefined_length() {
        let loads = antipodal(0.4, [0.0; 2]);
        for direction in [[0.0, 0.0], [f64::NAN, 1.0]] {
            let error = largest_acceleration(&loads, direction).expect_err("no direction");
            assert!(error.to_string().contains("norm of the direction"), "{error}");
        }
    }
}
