//! Equilibrium equations of a gripper and its object at rest in the frame of the palm, column by column.
//!
//! Rows are the generalised forces on (q11, q21) of the right and the left finger, N·m (for the left finger, of its
//! mirror image), the force on the object along x and y of the palm frame, N, and the moment about the object's centre,
//! N·m. A translating palm causes a uniform field, gravity minus its acceleration, on the object and on every link.

use super::equilibrium::spring_loads;
use super::error::number;
use super::hand::{ClosestPoint, FingerGeometry};
use super::posture::static_kinematics_at;
use super::{GraspConfiguration, PerContact, Side, StaticKinematics, StaticsError};
use crate::fivebar::inertial_forces::{AccelerationField, InertialForces};
use crate::gripper::{FingerContact, Spring};
use crate::numeric::plane::{add, cross, scale, sub};
use crate::shape;

/// Number of equations.
pub const ROWS: usize = 7;

/// Generalised forces of one load: one column of the equations.
pub type Load = [f64; ROWS];

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

/// Location of a contact force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactLocation {
    Finger(Side, FingerContact),
    Palm,
}

/// An active contact with the object, or an active joint limit, which has a torque instead of a force, and no friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActiveContact {
    pub location: ContactLocation,
    /// Point on the surface of phalanx or palm; `None` for a joint limit.
    pub point_m: Option<[f64; 2]>,
    /// Unit normal into the object, in the frame of the palm.
    pub normal: [f64; 2],
    pub mu: f64,
    /// Columns of a unit normal force (torque of a limit) and of a unit friction force on phalanx or palm along t =
    /// (n_y, −n_x), mirrored on the left.
    pub columns: [Load; 2],
}

/// All columns of the equations.
#[derive(Clone, Debug, PartialEq)]
pub struct Loads {
    pub contacts: Vec<ActiveContact>,
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
///
/// # Errors
/// Returns an error if a loop does not close or a number is out of range, and for the singular postures of
/// [`static_kinematics`](super::static_kinematics).
pub fn loads(hand: &HandAtRest<'_>) -> Result<Loads, StaticsError> {
    let HandAtRest { configuration, friction, mass_kg, gravity_m_s2: [gx, gy], .. } = hand;
    number("the object's mass", *mass_kg, *mass_kg > 0.0, "must be finite, more than 0 kg")?;
    number("gravity", gx + gy, true, "must be finite")?;
    let mut loads = Loads {
        contacts: Vec::new(),
        drives: Vec::with_capacity(hand.drives.len()),
        fixed: [0.0; ROWS],
        inertia: [[0.0; ROWS]; 2],
        length_m: shape::max_radius(&configuration.object.shape),
    };
    for side in Side::BOTH {
        add_finger(hand, side, &mut loads)?;
    }
    if let Some(mu) = friction.palm {
        // The contact point is on the palm below the lowest point of the object: the lever of friction is the height of
        // the centre.
        let ([x, y], [lowest, _]) = (configuration.object.centre_m, configuration.object.lowest_point_m());
        let mut columns = [[0.0; ROWS]; 2];
        (columns[0][X + 1], columns[0][MOMENT]) = (1.0, lowest - x);
        (columns[1][X], columns[1][MOMENT]) = (-1.0, -y);
        loads.contacts.push(ActiveContact {
            location: ContactLocation::Palm,
            point_m: Some([lowest, 0.0]),
            normal: [0.0, 1.0],
            mu,
            columns,
        });
    }
    for contact in &loads.contacts {
        number("mu_static", contact.mu, contact.mu >= 0.0, "must be finite, 0 or more")?;
    }
    for drive in &hand.drives {
        number("the motor torque", drive.torque_n_m, true, "must be finite")?;
        let mut column = [0.0; ROWS];
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

fn add_finger(hand: &HandAtRest<'_>, side: Side, loads: &mut Loads) -> Result<(), StaticsError> {
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
            let mut column = [0.0; ROWS];
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
        loads.contacts.push(ActiveContact {
            location: ContactLocation::Finger(side, contact),
            point_m,
            normal,
            mu,
            columns,
        });
    }
    if hand.limits[side as usize] {
        // The torque of the joint limit opens the angle from l21 to the tip.
        let mut column = [0.0; ROWS];
        (column[first], column[second]) = (tip_slope[0], tip_slope[1]);
        let location = ContactLocation::Finger(side, FingerContact::Limit);
        let columns = [column, [0.0; ROWS]];
        loads.contacts.push(ActiveContact { location, point_m: None, normal: [0.0; 2], mu: 0.0, columns });
    }
    Ok(())
}
