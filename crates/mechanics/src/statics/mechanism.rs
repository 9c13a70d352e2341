//! A mechanism at rest: form closure, and the largest acceleration of its base that its contacts can balance.
//!
//! The velocities of the balanced bodies that joints and couplings allow are B ν, with an orthonormal basis B of the null
//! space of their gradients; all other bodies are at rest relative to the base. Translations are divided by a typical
//! length of the mechanism, so that they compare with rotations. A force with the load f on the bodies has the
//! generalised force Bᵀ f.
//!
//! Behind a place with friction, a cable at rest has any tension from exp(−μ_s ψ) to exp(μ_s ψ) times the tension before it.
//! Such places divide the cable into parts. The equations have one more row for each of them: the tension before the place is
//! the sum of the tensions at both ends of the range.

use super::balance::{
    BrakeLoad, Certified, Cone, ContactMotion, Equations, Largest, direction_at, largest_multiple, unit_direction,
};
use super::form_closure::{Certificate, decide_by_linear_program};
use super::simplex::{LinearProgram, Outcome, Rule};
use super::{FormClosure, Result, Roles, Row, StaticsError, Unilateral, Unknown};
use crate::gripper::number;
use crate::mechanism::tendon::{center_in, length_in, segment, settled_path, strands, turn};
use crate::mechanism::{
    JointCombination, Mechanism, Pose, Spring, SpringKind, Tendon, constraint_gradients, coordinate_gradient,
    coordinate_in, point_in,
};
use crate::numeric::elementary::{exp, hypot};
use crate::numeric::plane::{cross, dot, scale, sub};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// A row of constraints follows from others if these leave less than this part of it.
const RANK_TOLERANCE: f64 = 1e-9;

/// Parts of a generalised force below this part of the load are rounding.
const LOAD_ROUNDING: f64 = 1e-13;

/// Behind a place where the ratio of the tensions may be smaller than this, a cable has any tension: the programme has too few
/// digits for the ratio.
const SELF_LOCKING: f64 = 1e-8;

/// Rates of actuators below this part of the largest rate are rounding.
const RATE_ROUNDING: f64 = 1e-7;

/// A contact that can push.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactAtRest {
    /// Bodies of the points and of the face; `None` is the ground.
    pub bodies: [Option<usize>; 2],
    pub point_m: [f64; 2],
    /// Unit normal from the face to the points: the direction of the contact force on the body of the points.
    pub normal: [f64; 2],
    pub mu: f64,
}

impl ContactAtRest {
    /// Unit normal into a body; `None` if the contact does not involve this body.
    pub fn push_on(&self, body: usize) -> Option<[f64; 2]> {
        match self.bodies.map(|of| of == Some(body)) {
            [true, _] => Some(self.normal),
            [_, true] => Some(scale(self.normal, -1.0)),
            _ => None,
        }
    }
}

/// State of the actuators of the hand. Actuators that move the base of the hand are always blocked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveState {
    /// Every actuator gives any torque or force; on a cable, any tension.
    Blocked,
    /// Every actuator gives the effort of its command at rest. Its brake adds an effort up to the limit at this time.
    AtEffort,
}

/// A mechanism at rest in a posture.
#[derive(Clone, Debug, PartialEq)]
pub struct MechanismAtRest<'a> {
    pub mechanism: &'a Mechanism,
    pub poses: &'a [Pose],
    pub time_s: f64,
    /// Contacts that can push; contacts with the surroundings are excluded.
    pub contacts: &'a [ContactAtRest],
    pub drives: DriveState,
    pub roles: &'a Roles,
}

/// Loads of a motion that has come to rest. They remain constant while the base is accelerated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadsAtRest {
    /// Efforts of the actuators of joints, N·m or N.
    pub efforts: Vec<f64>,
    /// Ranges of the additional efforts of the actuators and their brakes.
    pub slack: Vec<[f64; 2]>,
    /// Tensions of all cables where they are pulled, N. The tension of a cable whose actuator is blocked is arbitrary instead.
    pub tensions_n: Vec<f64>,
}

/// Largest unbalanced part of the loads, relative to the largest load. 1 % is far above the residual of a decaying
/// motion, and far below a load that causes a motion.
pub const MAX_REMAINDER: f64 = 0.01;

/// Accelerations that a motion at rest can balance.
#[derive(Clone, Debug, PartialEq)]
pub enum BalanceAtRest {
    /// Limits in all directions.
    Limits(Vec<MechanismBalance>),
    /// The loads are not balanced. `remainder` is the unbalanced part, relative to the largest load.
    NotAtRest { remainder: f64 },
}

/// Velocity of the frame of a body.
pub type BodyMotion = Pose;

/// Form closure of a mechanism and the objects that it holds.
#[derive(Clone, Debug, PartialEq)]
pub struct MechanismClosure {
    pub closure: FormClosure,
    /// A motion of all bodies that separates contacts or slides along them; `None` with form closure. Its largest
    /// velocity is 1 mm/s, or 1 mm/s divided by the typical length for rotations.
    pub motion: Option<Vec<BodyMotion>>,
    /// Number of coordinates when the actuators are blocked.
    pub coordinates: usize,
}

/// Largest acceleration of the base in a direction.
#[derive(Clone, Debug, PartialEq)]
pub struct MechanismBalance {
    pub direction: [f64; 2],
    pub largest: MechanismLimit,
}

#[derive(Clone, Debug, PartialEq)]
pub enum MechanismLimit {
    /// Not even a base at rest can be balanced: no forces within the cones balance weight, springs and actuators.
    Infeasible {
        /// A motion in which every set of admissible forces has positive power.
        motion: Vec<BodyMotion>,
        /// Actuators that move in this motion, as in `Limited`.
        yielding: Vec<usize>,
    },
    /// Any acceleration can be balanced, because the balancing forces can grow with it.
    Unlimited,
    Limited {
        acceleration_m_s2: f64,
        /// For each contact, normal force, tangential force and motion. The forces are not necessarily unique.
        contacts: Vec<(f64, f64, ContactMotion)>,
        /// For each joint limit that is reached, its effort, N·m or N, and its motion.
        limits: Vec<(f64, ContactMotion)>,
        /// Brakes and joints with friction, in their order, each with whether it slips.
        brakes: Vec<BrakeLoad>,
        /// Places over which a cable with friction slips in this motion, by their names such as `flexor[2]`.
        rubbing: Vec<String>,
        /// Tensions of the blocked cables where they are pulled, in the order of the tendons with an actuator; none at effort.
        tensions_n: Vec<f64>,
        /// The motion that a larger acceleration causes.
        motion: Vec<BodyMotion>,
        /// Actuators that move in this motion, in the order of [`efforts`]. Their efforts determine the limit; a
        /// blocked cable becomes slack.
        yielding: Vec<usize>,
        /// Relative difference of the limits computed from forces and from the motion.
        gap: f64,
    },
}

impl MechanismLimit {
    /// Returns the limit, m/s²; `None` if there is no limit, or if the balance is infeasible.
    pub fn acceleration_m_s2(&self) -> Option<f64> {
        match self {
            MechanismLimit::Limited { acceleration_m_s2, .. } => Some(*acceleration_m_s2),
            MechanismLimit::Infeasible { .. } | MechanismLimit::Unlimited => None,
        }
    }
}

/// Decides whether the contacts hold all bodies with the actuators blocked, without friction.
pub fn mechanism_closure(at_rest: &MechanismAtRest<'_>) -> Result<MechanismClosure> {
    let frame = Frame::new(at_rest, DriveState::Blocked);
    let count = frame.basis.ncols();
    let unknowns = (0..count).map(|index| Unknown::Coordinate { index }).collect();
    let mut rates = Unilateral::new(unknowns, vec![1.0; count]);
    let contacts = at_rest.contacts.iter().map(|contact| frame.contact(contact)[0].clone());
    let blocked = frame.blocked_cables().map(|cable| frame.reduced(&-cable.gradient()));
    let rows = contacts.chain(frame.limits()).chain(blocked);
    for (index, row) in rows.enumerate() {
        rates.append(Row::Constraint { index }, &row);
    }
    let closure = decide_by_linear_program(&rates)?;
    let motion = match &closure.certificate {
        Certificate::Motion { values, .. } => Some(frame.motion(values)),
        Certificate::Multipliers { .. } => None,
    };
    Ok(MechanismClosure { closure, motion, coordinates: count })
}

/// Returns the largest acceleration of the base in a direction that forces within their cones can balance.
pub fn mechanism_balance_towards(at_rest: &MechanismAtRest<'_>, direction: [f64; 2]) -> Result<MechanismBalance> {
    let frame = Frame::new(at_rest, at_rest.drives);
    frame.balance(&frame.equations()?, direction, &mut false)
}

/// Like [`mechanism_balance_towards`], in `count` equally spaced directions from x towards y.
pub fn mechanism_balance(at_rest: &MechanismAtRest<'_>, count: usize) -> Result<Vec<MechanismBalance>> {
    let frame = Frame::new(at_rest, at_rest.drives);
    frame.balance_all(&frame.equations()?, count)
}

/// Returns the largest acceleration of the base that the loads of a motion at rest can balance, in `count` equally
/// spaced directions from x towards y. Loads that are unbalanced without an acceleration are subtracted.
pub fn balance_at_rest(at_rest: &MechanismAtRest<'_>, loads: &LoadsAtRest, count: usize) -> Result<BalanceAtRest> {
    let frame = Frame::new(at_rest, at_rest.drives);
    Ok(match balanced_equations(&frame, loads)? {
        Ok(equations) => BalanceAtRest::Limits(frame.balance_all(&equations, count)?),
        Err(remainder) => BalanceAtRest::NotAtRest { remainder },
    })
}

/// Like [`balance_at_rest`], in one direction; `None` if the loads are not balanced.
pub fn balance_at_rest_towards(
    at_rest: &MechanismAtRest<'_>,
    loads: &LoadsAtRest,
    direction: [f64; 2],
) -> Result<Option<MechanismBalance>> {
    let frame = Frame::new(at_rest, at_rest.drives);
    let equations = balanced_equations(&frame, loads)?;
    equations.ok().map(|equations| frame.balance(&equations, direction, &mut false)).transpose()
}

/// Equations whose fixed load is balanced, or the unbalanced part of the loads, relative to the largest one.
fn balanced_equations(frame: &Frame<'_>, loads: &LoadsAtRest) -> Result<std::result::Result<Equations, f64>> {
    let (mut equations, largest) = frame.equations_at_rest(loads)?;
    let unbalanced = unbalanced(&equations, frame.basis.ncols())?;
    let size = unbalanced.iter().map(|part| part * part).sum::<f64>().sqrt();
    if size > MAX_REMAINDER * largest {
        return Ok(Err(size / largest));
    }
    equations.fixed.iter_mut().zip(&unbalanced).for_each(|(load, part)| *load -= part);
    Ok(Ok(equations))
}

/// The part of the fixed load on the coordinates that is left by the forces that balance most of it: of least sum of magnitudes.
fn unbalanced(equations: &Equations, coordinates: usize) -> Result<Vec<f64>> {
    let rows = equations.fixed.len();
    let mut columns: Vec<(Vec<f64>, [f64; 2], f64)> = Vec::new();
    let pushes = equations.contacts.iter().flat_map(Cone::edges);
    columns.extend(pushes.map(|column| (column, [0.0, f64::INFINITY], 0.0)));
    columns.extend(equations.drives.iter().map(|(column, range)| (column.clone(), *range, 0.0)));
    let forces = columns.len();
    for sign in [1.0, -1.0] {
        let unit = |row: usize| (0..rows).map(|other| if other == row { sign } else { 0.0 }).collect();
        columns.extend((0..coordinates).map(|row| (unit(row), [0.0, f64::INFINITY], -1.0)));
    }
    let programme = LinearProgram {
        matrix: DMatrix::from_fn(rows, columns.len(), |row, column| columns[column].0[row]),
        right: DVector::from_fn(rows, |row, _| -equations.fixed[row]),
        bounds: columns.iter().map(|(_, range, _)| *range).collect(),
        objective: columns.iter().map(|(.., cost)| *cost).collect(),
    };
    for rule in [Rule::Steepest, Rule::First] {
        if let Some(Outcome::Optimal { x, .. }) = programme.solve(rule) {
            return Ok((0..coordinates).map(|row| x[forces + coordinates + row] - x[forces + row]).collect());
        }
    }
    Err(StaticsError::Program { reason: "the least unbalanced load is not found".to_string() })
}

/// Efforts of all actuators at rest, without their brakes: those of joints, then those of tendons, N·m or N.
pub fn efforts(mechanism: &Mechanism, poses: &[Pose], time_s: f64) -> Vec<f64> {
    let of_joints = mechanism
        .actuators
        .iter()
        .map(|actuator| actuator.effort_at_rest(mechanism.command_at_rest(actuator, poses, time_s)));
    let of_tendons = mechanism.tendons.iter().filter_map(|tendon| tendon.actuator.as_ref());
    of_joints.chain(of_tendons.map(|actuator| actuator.tension.at(time_s).0.max(0.0))).collect()
}

/// Value of a combination of joint coordinates.
fn value_of(mechanism: &Mechanism, on: &JointCombination, poses: &[Pose]) -> f64 {
    on.value(|joint| coordinate_in(&mechanism.joints[joint], poses))
}

/// The mechanism with the basis of its motions.
struct Frame<'a> {
    at_rest: &'a MechanismAtRest<'a>,
    drives: DriveState,
    /// Typical length.
    length_m: f64,
    basis: DMatrix<f64>,
    /// All cables, in the order of the tendons.
    cables: Vec<CableAtRest>,
}

/// A cable at rest, divided by the places with friction.
struct CableAtRest {
    /// Load against which a unit tension of each part acts: the gradient of its length, and its moment on the bodies of the
    /// places with friction at its ends.
    parts: Vec<DVector<f64>>,
    /// exp(−μ_s ψ) of the place behind each part, except the last one, and its element of the path.
    places: Vec<(f64, usize)>,
    is_pulled: bool,
}

impl CableAtRest {
    /// Gradient of the length.
    fn gradient(&self) -> DVector<f64> {
        self.parts[1..].iter().fold(self.parts[0].clone(), |sum, part| sum + part)
    }
}

impl<'a> Frame<'a> {
    fn new(at_rest: &'a MechanismAtRest<'a>, drives: DriveState) -> Self {
        let MechanismAtRest { mechanism, poses, contacts, roles, .. } = at_rest;
        let balanced = poses.iter().zip(&roles.is_balanced).filter(|(_, is_balanced)| **is_balanced);
        let origins = balanced.map(|([x, y, _], _)| [*x, *y]);
        let points: Vec<[f64; 2]> = contacts.iter().map(|contact| contact.point_m).chain(origins).collect();
        let first = points.first().copied().unwrap_or_default();
        let reach = points.iter().map(|point| hypot(point[0] - first[0], point[1] - first[1])).fold(0.0, f64::max);
        let length_m = if reach > 0.0 { reach } else { 1.0 };
        let mut frame = Self { at_rest, drives, length_m, basis: DMatrix::zeros(0, 0), cables: Vec::new() };
        let mut rows: Vec<DVector<f64>> = Vec::new();
        for (index, body) in mechanism.bodies.iter().enumerate() {
            let fixed = if !roles.is_balanced[index] { 0..3 } else { if body.rotates() { 3..3 } else { 2..3 } };
            rows.extend(
                fixed.map(|part| DVector::from_fn(3 * poses.len(), |row, _| f64::from(row == 3 * index + part))),
            );
        }
        for joint in &mechanism.joints {
            rows.extend(
                constraint_gradients(joint, poses).map(|by_pose| frame.row(joint.bodies.into_iter().zip(by_pose))),
            );
        }
        rows.extend(mechanism.couplings.iter().map(|coupling| frame.combination(&coupling.on)));
        if drives == DriveState::Blocked {
            rows.extend(mechanism.actuators.iter().map(|actuator| frame.combination(&actuator.on)));
        }
        frame.basis = null_space(&rows, 3 * poses.len());
        frame.cables = mechanism.tendons.iter().map(|tendon| frame.cable(tendon)).collect();
        frame
    }

    /// Scaled row of gradients by the poses of bodies.
    fn row(&self, by_pose: impl Iterator<Item = (Option<usize>, Pose)>) -> DVector<f64> {
        let mut row = DVector::zeros(3 * self.at_rest.poses.len());
        for (body, [x, y, angle]) in by_pose {
            let Some(body) = body else { continue };
            for (part, value) in [x * self.length_m, y * self.length_m, angle].into_iter().enumerate() {
                row[3 * body + part] += value;
            }
        }
        row
    }

    fn combination(&self, on: &JointCombination) -> DVector<f64> {
        let joints = &self.at_rest.mechanism.joints;
        let term = |(joint, factor): &(usize, f64)| {
            let joint = &joints[*joint];
            *factor * self.row(joint.bodies.into_iter().zip(coordinate_gradient(joint, self.at_rest.poses)))
        };
        self.sum(on.terms.iter().map(term))
    }

    fn cable(&self, tendon: &Tendon) -> CableAtRest {
        let poses = self.at_rest.poses;
        let bends = settled_path(&tendon.path, |element| center_in(element, poses));
        let spools =
            |joints: &[(usize, f64)]| self.combination(&JointCombination { terms: joints.to_vec(), offset: 0.0 });
        let (mut parts, mut places, mut terms) = (Vec::new(), Vec::new(), vec![spools(&tendon.joints)]);
        let mut before = None;
        for [from, to] in strands(&bends) {
            let ends = [from, to].map(|element| &tendon.path[element]);
            let centers = ends.map(|element| center_in(element, poses));
            let along = segment(ends, sub(centers[1], centers[0])).direction;
            if let Some((before, friction)) = before.replace(along).zip(ends[0].friction) {
                let ratio = exp(-friction.mu_static * turn(ends[0], bends[from], [before, along]));
                let ratio = if ratio < SELF_LOCKING { 0.0 } else { ratio };
                if ratio < 1.0 {
                    let moment = self.row([(ends[0].body, [0.0, 0.0, ends[0].signed_radius_m()])].into_iter());
                    let next = vec![-&moment];
                    terms.push(moment);
                    parts.push(self.sum(std::mem::replace(&mut terms, next).into_iter()));
                    places.push((ratio, from));
                }
            }
            for (k, sign) in [(0, -1.0), (1, 1.0)] {
                terms.push(self.force(ends[k].body, centers[k], scale(along, sign)));
            }
        }
        terms.push(spools(&tendon.far_joints));
        parts.push(self.sum(terms.into_iter()));
        CableAtRest { parts, places, is_pulled: tendon.actuator.is_some() }
    }

    /// Sum of loads. Parts below the rounding errors of the sum are zero: the columns of the programme are scaled, so that
    /// a cable whose whole path is on one body would become a load of size 1.
    fn sum(&self, terms: impl Iterator<Item = DVector<f64>>) -> DVector<f64> {
        let none = (DVector::zeros(3 * self.at_rest.poses.len()), 0.0);
        let (sum, size) = terms.fold(none, |(sum, size), term| (sum + &term, size + term.norm()));
        sum.map(|part| if part.abs() <= LOAD_ROUNDING * size { 0.0 } else { part })
    }

    /// Load of a force at a point of a body.
    fn force(&self, body: Option<usize>, point_m: [f64; 2], force: [f64; 2]) -> DVector<f64> {
        let arm = |body: usize| sub(point_m, [self.at_rest.poses[body][0], self.at_rest.poses[body][1]]);
        let by_pose = body.map_or([0.0; 3], |body| [force[0], force[1], cross(arm(body), force)]);
        self.row([(body, by_pose)].into_iter())
    }

    /// Generalised force of a load. Parts below its rounding errors are zero, as in [`Self::sum`]: the torque of a limit on
    /// a blocked joint has no other parts.
    fn reduced(&self, load: &DVector<f64>) -> Vec<f64> {
        let rounding = LOAD_ROUNDING * load.norm();
        let reduced = self.basis.tr_mul(load);
        reduced.iter().map(|part| if part.abs() <= rounding { 0.0 } else { *part }).collect()
    }

    /// Generalised forces of a unit normal force and a unit friction force (on the face along t = (n_y, −n_x)).
    fn contact(&self, contact: &ContactAtRest) -> [Vec<f64>; 2] {
        let ContactAtRest { bodies: [points, face], point_m, normal, .. } = *contact;
        let [x, y] = normal;
        [normal, [-y, x]].map(|force| {
            let pair = [self.force(points, point_m, force), self.force(face, point_m, scale(force, -1.0))];
            self.reduced(&self.sum(pair.into_iter()))
        })
    }

    /// Generalised forces of unit torques of the joint limits that are reached.
    fn limits(&self) -> impl Iterator<Item = Vec<f64>> + '_ {
        let MechanismAtRest { mechanism, poses, .. } = self.at_rest;
        let reached = mechanism.limits().into_iter().filter(|limit| {
            let coordinate = mechanism.limited(limit).value(|joint| coordinate_in(&mechanism.joints[joint], poses));
            limit.side * (coordinate - limit.value) >= 0.0
        });
        reached.map(|limit| self.reduced(&(-limit.side * self.combination(&mechanism.limited(&limit)))))
    }

    /// Cables with any tension, which can only pull.
    fn blocked_cables(&self) -> impl Iterator<Item = &CableAtRest> {
        self.cables.iter().filter(|cable| self.is_blocked(cable))
    }

    fn is_blocked(&self, cable: &CableAtRest) -> bool {
        cable.is_pulled && self.drives == DriveState::Blocked
    }

    /// Generalised force of a uniform field, m/s², on all masses.
    fn field(&self, field: [f64; 2]) -> Vec<f64> {
        let mut load = DVector::zeros(3 * self.at_rest.poses.len());
        let bodies = self.at_rest.mechanism.bodies.iter().enumerate();
        for (index, body) in bodies.filter(|(index, _)| self.at_rest.roles.is_balanced[*index]) {
            let center_m = point_in(Some(index), body.com_m, self.at_rest.poses);
            load += self.force(Some(index), center_m, scale(field, body.mass_kg));
        }
        self.reduced(&load)
    }

    /// Solves the equations for accelerations in `count` equally spaced directions from x towards y.
    fn balance_all(&self, equations: &Equations, count: usize) -> Result<Vec<MechanismBalance>> {
        let angle_rad = |index: usize| TAU * index as f64 / count as f64;
        let mut is_balanced = false;
        (0..count).map(|index| self.balance(equations, direction_at(angle_rad(index)), &mut is_balanced)).collect()
    }

    /// Solves the equations for an acceleration in a direction; `is_balanced` as in [`largest_multiple`].
    fn balance(&self, equations: &Equations, direction: [f64; 2], is_balanced: &mut bool) -> Result<MechanismBalance> {
        let direction = unit_direction(direction)?;
        let mut driving = self.field(scale(direction, -1.0));
        driving.resize(equations.fixed.len(), 0.0);
        let largest = match largest_multiple(&Equations { driving, ..equations.clone() }, is_balanced)? {
            Largest::Infeasible { motion } => {
                MechanismLimit::Infeasible { motion: self.motion(&motion), yielding: self.yielding(&motion) }
            }
            Largest::Unlimited => MechanismLimit::Unlimited,
            Largest::Limited(found) => self.limit(found),
        };
        Ok(MechanismBalance { direction, largest })
    }

    fn limit(&self, found: Certified) -> MechanismLimit {
        // In the order of the equations: contacts, joint limits, blocked cables, friction of cables.
        let (contacts, others) = found.contacts.split_at(self.at_rest.contacts.len());
        let (limits, cables) = others.split_at(self.limits().count());
        let (blocked, frictions) = cables.split_at(self.blocked_cables().count());
        MechanismLimit::Limited {
            acceleration_m_s2: found.acceleration_m_s2,
            contacts: contacts.to_vec(),
            limits: limits.iter().map(|(effort, _, motion)| (*effort, *motion)).collect(),
            brakes: found.brakes,
            rubbing: self.rubbing(frictions),
            tensions_n: blocked.iter().map(|(tension_n, ..)| *tension_n).collect(),
            motion: self.motion(&found.motion),
            yielding: self.yielding(&found.motion),
            gap: found.gap,
        }
    }

    /// Names of the places over which a cable slips: its tension is at one end of the range only. `ends` are both ends of all
    /// places.
    fn rubbing(&self, ends: &[(f64, f64, ContactMotion)]) -> Vec<String> {
        let places = self.cables.iter().enumerate().flat_map(|(tendon, cable)| {
            cable.places.iter().map(move |(_, element)| self.at_rest.mechanism.element_name(tendon, *element))
        });
        let slips = |ends: &[(f64, f64, ContactMotion)]| ends[0].2 != ends[1].2;
        places.zip(ends.chunks(2)).filter(|(_, ends)| slips(ends)).map(|(name, _)| name).collect()
    }

    /// All columns of the equations of a motion at rest, except the driving load, and the size of the largest load.
    fn equations_at_rest(&self, loads: &LoadsAtRest) -> Result<(Equations, f64)> {
        let mechanism = self.at_rest.mechanism;
        let mut fixed = self.springs();
        let size = |load: &DVector<f64>| DVector::from_vec(self.reduced(load)).norm();
        let mut largest = size(&fixed).max(DVector::from_vec(self.field(mechanism.gravity_m_s2)).norm());
        for (cable, tension_n) in self.cables.iter().zip(&loads.tensions_n) {
            let tension_n = if self.is_blocked(cable) { 0.0 } else { *tension_n };
            largest = largest.max(size(&(-tension_n * cable.gradient())));
            fixed += -tension_n * &cable.parts[0];
        }
        let mut drives = Vec::new();
        for (index, actuator) in mechanism.actuators.iter().enumerate() {
            let on = self.combination(&actuator.on);
            let load = loads.efforts[index] * &on;
            largest = largest.max(size(&load));
            fixed += load;
            if self.drives != DriveState::Blocked && loads.slack[index] != [0.0; 2] {
                drives.push((self.reduced(&on), loads.slack[index]));
            }
        }
        Ok((self.with_contacts(&fixed, &loads.tensions_n, drives)?, largest))
    }

    /// All columns of the equations, except the driving load.
    fn equations(&self) -> Result<Equations> {
        let MechanismAtRest { mechanism, poses, time_s, .. } = self.at_rest;
        let mut fixed = self.springs();
        let tensions_n = self.add_efforts(&efforts(mechanism, poses, *time_s), &mut fixed);
        self.with_contacts(&fixed, &tensions_n, self.brakes().collect())
    }

    /// Equations with the fixed load and these drives, the friction of joints, the weight, the cones of contacts, and the
    /// cables. The fixed load contains the tensions of cables without friction, and those of the first parts of the others.
    fn with_contacts(
        &self,
        fixed: &DVector<f64>,
        tensions_n: &[f64],
        drives: Vec<(Vec<f64>, [f64; 2])>,
    ) -> Result<Equations> {
        let MechanismAtRest { mechanism, contacts, .. } = self.at_rest;
        for contact in *contacts {
            number("mu_static", contact.mu, contact.mu >= 0.0, "must be finite, 0 or more")?;
        }
        let coordinates = self.basis.ncols();
        let count = coordinates + self.cables.iter().map(|cable| cable.places.len()).sum::<usize>();
        let padded = |mut load: Vec<f64>| {
            load.resize(count, 0.0);
            load
        };
        let one_sided = |normal: Vec<f64>| Cone { columns: [normal, vec![0.0; count]], mu: 0.0 };
        let weight = self.field(mechanism.gravity_m_s2);
        let mut fixed = padded(self.reduced(fixed).iter().zip(&weight).map(|(load, weight)| load + weight).collect());
        let cones = contacts.iter().map(|contact| Cone { columns: self.contact(contact).map(padded), mu: contact.mu });
        let mut forces: Vec<Cone> = cones.chain(self.limits().map(|limit| one_sided(padded(limit)))).collect();
        let (mut row, mut frictions) = (coordinates, Vec::new());
        for (cable, tension_n) in self.cables.iter().zip(tensions_n) {
            if self.is_blocked(cable) {
                let mut first = padded(self.reduced(&-&cable.parts[0]));
                if !cable.places.is_empty() {
                    first[row] = 1.0;
                }
                forces.push(one_sided(first));
            } else if !cable.places.is_empty() {
                fixed[row] = *tension_n;
            }
            for (k, (ratio, _)) in cable.places.iter().enumerate() {
                let part = self.reduced(&-&cable.parts[k + 1]);
                for [before, behind] in [[*ratio, 1.0], [1.0, *ratio]] {
                    let mut load = padded(part.iter().map(|load| behind * load).collect());
                    load[row] = -before;
                    if k + 1 < cable.places.len() {
                        load[row + 1] = behind;
                    }
                    frictions.push(one_sided(load));
                }
                row += 1;
            }
        }
        forces.extend(frictions);
        let drives = drives.into_iter().chain(self.joint_friction()).map(|(load, range)| (padded(load), range));
        let lengths = (0..count).map(|row| if row < coordinates { self.length_m } else { 1.0 });
        Ok(Equations {
            contacts: forces,
            drives: drives.collect(),
            fixed,
            driving: Vec::new(),
            lengths: lengths.collect(),
        })
    }

    /// Load of the springs.
    fn springs(&self) -> DVector<f64> {
        let MechanismAtRest { mechanism, poses, .. } = self.at_rest;
        let load = |spring: &Spring| match &spring.kind {
            SpringKind::Torsional { on, preload } => {
                (preload - spring.stiffness * (value_of(mechanism, on, poses) - spring.rest)) * self.combination(on)
            }
            SpringKind::Linear { bodies, points_m } => {
                let ends = [0, 1].map(|k: usize| point_in(bodies[k], points_m[k], poses));
                let between = sub(ends[1], ends[0]);
                let length = dot(between, between).sqrt();
                let pull = scale(between, spring.stiffness * (length - spring.rest) / length);
                self.force(bodies[0], ends[0], pull) + self.force(bodies[1], ends[1], scale(pull, -1.0))
            }
        };
        mechanism.springs.iter().map(load).fold(DVector::zeros(3 * poses.len()), |sum, load| sum + load)
    }

    /// Adds the load of the actuators of joints and of all cables that are not blocked, and returns the tensions of all cables
    /// where they are pulled.
    fn add_efforts(&self, efforts: &[f64], load: &mut DVector<f64>) -> Vec<f64> {
        let MechanismAtRest { mechanism, poses, .. } = self.at_rest;
        let (of_joints, of_tendons) = efforts.split_at(mechanism.actuators.len());
        let mut of_tendons = of_tendons.iter();
        let mut tensions_n = Vec::with_capacity(self.cables.len());
        for (tendon, cable) in mechanism.tendons.iter().zip(&self.cables) {
            let pull = tendon.actuator.as_ref().and_then(|_| of_tendons.next()).unwrap_or(&0.0);
            let elongation = (length_in(mechanism, tendon, poses) - tendon.rest_m).max(0.0);
            let tension_n = tendon.stiffness_n_per_m * elongation + pull;
            tensions_n.push(tension_n);
            if !self.is_blocked(cable) {
                *load += -tension_n * &cable.parts[0];
            }
        }
        for (actuator, effort) in mechanism.actuators.iter().zip(of_joints) {
            *load += *effort * self.combination(&actuator.on);
        }
        tensions_n
    }

    /// Generalised forces of unit torques of the brakes, with the ranges of their torques. A blocked actuator has none.
    fn brakes(&self) -> impl Iterator<Item = (Vec<f64>, [f64; 2])> + '_ {
        let actuators = self.at_rest.mechanism.actuators.iter().filter(|_| self.drives == DriveState::AtEffort);
        actuators.filter_map(|actuator| {
            let range = actuator.brake?.torque_range(self.at_rest.time_s);
            Some((self.reduced(&self.combination(&actuator.on)), range))
        })
    }

    /// Generalised forces of unit frictional efforts of joints, with their ranges.
    fn joint_friction(&self) -> impl Iterator<Item = (Vec<f64>, [f64; 2])> + '_ {
        self.at_rest.mechanism.joints.iter().enumerate().filter_map(|(index, joint)| {
            let largest = joint.friction?.mu_static;
            Some((self.reduced(&self.combination(&JointCombination::of_joint(index))), [-largest, largest]))
        })
    }

    /// Scaled velocities of all bodies from the rates of all rows, of which the first are those of the coordinates.
    fn velocities(&self, rates: &[f64]) -> DVector<f64> {
        &self.basis * DVector::from_column_slice(&rates[..self.basis.ncols()])
    }

    /// Actuators whose coordinates move: those of joints, then those of tendons.
    fn yielding(&self, rates: &[f64]) -> Vec<usize> {
        let all = self.velocities(rates);
        let mechanism = self.at_rest.mechanism;
        let of_joints = mechanism.actuators.iter().map(|actuator| self.combination(&actuator.on));
        let of_tendons = self.cables.iter().filter(|cable| cable.is_pulled);
        let rows = of_joints.chain(of_tendons.map(CableAtRest::gradient)).enumerate();
        let moving = rows.filter(|(_, row)| row.dot(&all).abs() > RATE_ROUNDING * row.norm() * all.norm());
        moving.map(|(index, _)| index).collect()
    }

    /// Velocities of all bodies, with a largest translation or rotation (times the typical length) of 1 mm/s.
    fn motion(&self, rates: &[f64]) -> Vec<BodyMotion> {
        let all = self.velocities(rates);
        let largest = all.amax().max(f64::MIN_POSITIVE);
        let clear = |rate: f64| if rate.abs() < 1e-9 * largest { 0.0 } else { 1e-3 * rate / largest };
        let body = |part: &[f64]| [clear(part[0]), clear(part[1]), clear(part[2]) / self.length_m];
        all.as_slice().chunks(3).map(body).collect()
    }
}

/// Orthonormal basis of the vectors orthogonal to all rows, as columns.
///
/// Unit vectors that no row contains are columns as they are, so that the equations of free bodies are exact.
fn null_space(rows: &[DVector<f64>], count: usize) -> DMatrix<f64> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let rest = |vector: &DVector<f64>, basis: &[DVector<f64>]| {
        let mut rest = vector.clone();
        // The second pass removes the rounding errors of the first.
        for _ in 0..2 {
            for unit in basis {
                let part = unit.dot(&rest);
                rest.axpy(-part, unit, 1.0);
            }
        }
        rest
    };
    for row in rows {
        let (rest, size) = (rest(row, &basis), row.norm());
        if rest.norm() > RANK_TOLERANCE * size {
            basis.push(rest.normalize());
        }
    }
    let rank = basis.len();
    while basis.len() < count {
        let uncovered = |axis: usize| 1.0 - basis.iter().map(|unit| unit[axis] * unit[axis]).sum::<f64>();
        let Some(axis) = (0..count).max_by(|a, b| uncovered(*a).total_cmp(&uncovered(*b)).then(b.cmp(a))) else {
            break;
        };
        let unit = DVector::from_fn(count, |row, _| f64::from(row == axis));
        basis.push(rest(&unit, &basis).normalize());
    }
    DMatrix::from_fn(count, basis.len() - rank, |row, column| basis[rank + column][row])
}
