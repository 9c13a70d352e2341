//! What forces do on a gripper at rest in the frame of its palm, and on its object: the equations of balance, column by column.
//!
//! Rows are generalised forces on (q11, q21) of the right and the left finger, N·m (of the left one those of its mirror image), the force
//! on the object along x and y of the palm's frame, N, and its moment about the object's centre, N·m. A palm that moves without turning is
//! felt as a uniform field: gravity less its acceleration, on the object and on every link.

use super::equilibrium::spring_loads;
use super::posture::at_posture;
use super::stance::{Meeting, Reach};
use super::{AtRest, PerContact, Side, Stance, StaticsError};
use crate::fivebar::carried::{Carried, Field};
use crate::gripper::{Site, Spring};
use crate::numeric::plane::{add, cross, scale, sub};
use crate::shape;

/// Number of rows.
pub const ROWS: usize = 7;

/// One column.
pub type Load = [f64; ROWS];

const X: usize = 4;
const MOMENT: usize = 6;

/// A gripper at rest in the frame of its palm, and what acts there.
#[derive(Clone, Debug, PartialEq)]
pub struct HandAtRest<'a> {
    pub stance: Stance<'a>,
    /// Friction coefficients of the contacts that there are.
    pub friction: PerContact<Option<f64>>,
    /// Whether the tip is on its joint limit, right and left.
    pub limits: [bool; 2],
    pub springs: [Option<Spring>; 2],
    pub drives: Vec<Drive>,
    pub mass_kg: f64,
    /// In the palm's frame, turned as the palm is.
    pub gravity_m_s2: [f64; 2],
}

/// A motor: which of the driven links (right, left) it turns, and by how much of its torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    pub weights: [f64; 2],
    /// Of the motor, N·m; it closes where it is positive.
    pub torque_n_m: f64,
    /// Least and most that a brake adds to it, N·m: infinite where nothing turns it, 0 and 0 where there is none.
    pub brake_n_m: [f64; 2],
}

/// Where a force acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spot {
    Finger(Side, Site),
    Palm,
}

/// What may press: a contact with the object, or a joint limit, which has no friction, and a torque instead of a force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pressing {
    pub spot: Spot,
    /// On the surface of phalanx or palm; `None` of a joint limit.
    pub point_m: Option<[f64; 2]>,
    /// Unit normal into the object, in the palm's frame.
    pub normal: [f64; 2],
    pub mu: f64,
    /// Of a unit normal force (torque of a limit), and of a unit of friction: on phalanx or palm along t = (n_y, −n_x), mirrored on the left.
    pub columns: [Load; 2],
}

/// All columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Loads {
    pub pressing: Vec<Pressing>,
    /// Of a unit of torque of each drive, with what its brake gives.
    pub drives: Vec<(Load, [f64; 2])>,
    /// Springs, motors and weight.
    pub fixed: Load,
    /// Of 1 m/s² of the palm along x and along y.
    pub inertia: [Load; 2],
    /// Lengths by which rows with moments are made comparable to forces.
    pub length_m: f64,
}

fn rows(side: Side) -> [usize; 2] {
    [2 * side as usize, 2 * side as usize + 1]
}

fn number(name: &'static str, value: f64, in_range: bool, allowed: &'static str) -> Result<(), StaticsError> {
    if value.is_finite() && in_range { Ok(()) } else { Err(StaticsError::Number { name, value, allowed }) }
}

/// The columns of a posture.
///
/// # Errors
/// A posture in which a loop does not close, the singular ones of [`at_rest`](super::at_rest), and numbers out of range.
pub fn loads(hand: &HandAtRest<'_>) -> Result<Loads, StaticsError> {
    let HandAtRest { stance, friction, mass_kg, gravity_m_s2: [gx, gy], .. } = hand;
    number("the object's mass", *mass_kg, *mass_kg > 0.0, "must be finite, more than 0 kg")?;
    number("gravity", gx + gy, true, "must be finite")?;
    let mut found = Loads {
        pressing: Vec::new(),
        drives: Vec::with_capacity(hand.drives.len()),
        fixed: [0.0; ROWS],
        inertia: [[0.0; ROWS]; 2],
        length_m: shape::reach(&stance.object.shape),
    };
    for side in Side::BOTH {
        add_finger(hand, side, &mut found)?;
    }
    if let Some(mu) = friction.palm {
        // Its point is on the palm, where the object is lowest: the lever of friction is the centre's height.
        let ([x, y], [lowest, _]) = (stance.object.centre_m, stance.object.lowest_m());
        let mut columns = [[0.0; ROWS]; 2];
        (columns[0][X + 1], columns[0][MOMENT]) = (1.0, lowest - x);
        (columns[1][X], columns[1][MOMENT]) = (-1.0, -y);
        found.pressing.push(Pressing {
            spot: Spot::Palm,
            point_m: Some([lowest, 0.0]),
            normal: [0.0, 1.0],
            mu,
            columns,
        });
    }
    for pressing in &found.pressing {
        number("mu_static", pressing.mu, pressing.mu >= 0.0, "must be finite, 0 or more")?;
    }
    for drive in &hand.drives {
        number("the motor torque", drive.torque_n_m, true, "must be finite")?;
        let mut column = [0.0; ROWS];
        for side in Side::BOTH {
            column[rows(side)[0]] = drive.weights[side as usize];
            found.fixed[rows(side)[0]] += drive.weights[side as usize] * drive.torque_n_m;
        }
        found.drives.push((column, drive.brake_n_m));
    }
    for (axis, gravity) in hand.gravity_m_s2.into_iter().enumerate() {
        found.fixed[X + axis] += mass_kg * gravity;
        found.inertia[axis][X + axis] -= mass_kg;
    }
    Ok(found)
}

fn add_finger(hand: &HandAtRest<'_>, side: Side, found: &mut Loads) -> Result<(), StaticsError> {
    let Reach { finger, posture, a22, object, phalanges } = hand.stance.reach(side)?;
    let at_rest = at_posture(finger, &posture)?;
    let AtRest { pose, rates, tip_slope } = &at_rest;
    let [first, second] = rows(side);
    let mirror = side.mirror();

    let spring = spring_loads(finger, &at_rest, hand.springs[side as usize].as_ref())?;
    (found.fixed[first], found.fixed[second]) = (found.fixed[first] + spring[0], found.fixed[second] + spring[1]);
    let carried = Carried::new(finger, [0.5 * hand.stance.palm_width_m, 0.0]);
    let felt = |[x, y]: [f64; 2]| {
        let field = Field { uniform: [mirror * x, y], ..Field::default() };
        carried.forces(pose, rates, [0.0; 4], &field)
    };
    let weight = felt(hand.gravity_m_s2);
    (found.fixed[first], found.fixed[second]) = (found.fixed[first] + weight[0], found.fixed[second] + weight[1]);
    for (axis, unit) in [[-1.0, 0.0], [0.0, -1.0]].into_iter().enumerate() {
        [found.inertia[axis][first], found.inertia[axis][second]] = felt(unit);
    }

    let sites = [Site::Proximal, Site::Distal];
    for (index, (site, Meeting { foot, normal, .. })) in sites.into_iter().zip(phalanges).enumerate() {
        let Some(mu) = hand.friction.phalanges[side as usize][index] else { continue };
        let point = add(foot, scale(normal, finger.lengths.half_width_m));
        let [nx, ny] = normal;
        // Along it on the phalanx: against the normal, which points into the object, and along t.
        let columns = [[-nx, -ny], [ny, -nx]].map(|force| {
            let mut column = [0.0; ROWS];
            match site {
                Site::Proximal => column[second] = cross(point, force),
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
        let (point_m, normal) = (Some(hand.stance.in_palm(side, point)), [mirror * nx, ny]);
        found.pressing.push(Pressing { spot: Spot::Finger(side, site), point_m, normal, mu, columns });
    }
    if hand.limits[side as usize] {
        // It opens the angle from l21 to the tip.
        let mut column = [0.0; ROWS];
        (column[first], column[second]) = (tip_slope[0], tip_slope[1]);
        let spot = Spot::Finger(side, Site::Limit);
        let columns = [column, [0.0; ROWS]];
        found.pressing.push(Pressing { spot, point_m: None, normal: [0.0; 2], mu: 0.0, columns });
    }
    Ok(())
}
