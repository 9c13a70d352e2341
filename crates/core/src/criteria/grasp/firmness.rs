//! How firmly the object is held at the end: the accelerations that the contacts can balance, form closure and Q1.

use super::actuators::ActuatorCriteria;
use super::fate::Fate;
use super::object::ObjectCriteria;
use super::pose::{fixed_object, poses_in};
use crate::criteria::is_form_closed;
use crate::drawing::states::palm_pose;
use crate::mechanism::{Actuator, Command, ContactPair, Mechanism, PointContact, Pose, point_in, pose_in_world};
use crate::numeric::elementary::{atan2, sin_cos};
use crate::numeric::plane::{add, rotate};
use crate::scene::Scene;
use crate::statics::{
    BalanceAtRest, ContactAtRest, ContactMotion, DriveState, ForceClosure, FrictionContact, GraspRoles, LoadsAtRest,
    MechanismAtRest, MechanismLimit, Roles, balance_at_rest, balance_at_rest_towards, force_closure, mechanism_closure,
    roles,
};
use crate::trace::{ContactSample, Sample};
use serde::Serialize;

/// Number of directions of an acceleration, evenly spaced from x towards y.
pub const DIRECTIONS: usize = 24;

/// Directions whose limits differ by less than this part are equally bad.
const SAME_LIMIT: f64 = 1e-6;

/// How firmly an object is held.
#[derive(Clone, Debug, PartialEq)]
pub struct Firmness {
    /// Margin with the actuators as they are at the end. A servo below its limit gives any effort within it. Every
    /// other actuator gives its effort at the end; a brake adds an effort up to its limit.
    pub driven: Margin,
    /// Margin with actuators that give any effort.
    pub blocked: Margin,
    /// Whether the contacts hold the object and the hand without friction while the actuators are blocked; `None` if
    /// this cannot be decided. The rotation of a disc in a five-bar hand is ignored.
    pub form_closed: Option<bool>,
    /// Force closure of the contacts. Moments are divided by the radius of the object; Q1 is the field `q1_l1`.
    pub force_closure: ForceClosure,
}

/// The largest acceleration of the base, in its worst direction, that the contacts which are active at the end can
/// balance.
#[derive(Clone, Debug, PartialEq)]
pub enum Margin {
    /// Any acceleration in any direction.
    Any,
    Limited {
        /// Limit, at least 0. A grasp that balances its loads only within rounding errors balances no acceleration.
        acceleration_m_s2: f64,
        /// All directions with this limit, from x towards y.
        directions_rad: Vec<f64>,
        /// How the grasp fails under a larger acceleration in the first of these directions.
        failure: Failure,
    },
    /// The loads at the end are not balanced. `remainder` is the unbalanced part, relative to the largest load.
    NotAtRest { remainder: f64 },
    /// The programme has no certified result.
    Undecided { reason: String },
}

/// How a grasp fails: the motion caused by an acceleration above the limit.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Failure {
    /// Names of the pairs with a point that slips.
    pub slipping: Vec<String>,
    /// Names of the other pairs that tilt: one point opens while another stays in contact.
    pub tilting: Vec<String>,
    /// Names of the pairs that separate at all points.
    pub separating: Vec<String>,
    /// Names of the actuators that move against their effort.
    pub yielding: Vec<String>,
    /// Names of the places over which a cable with friction slips.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rubbing: Vec<String>,
}

/// Returns how firmly the object is held at the end. `None` unless the object is held or carried, and for a scene
/// without a grasp.
pub fn firmness(scene: &Scene, found: &ObjectCriteria) -> Option<Firmness> {
    let grasp = scene.grasp_roles().ok().filter(|_| matches!(found.fate, Fate::Held | Fate::Carried))?;
    let mechanism = scene.judged_mechanism();
    let posture = Posture::in_sample(scene, (&mechanism, &grasp), &found.end);
    let on_object = |contact: &ContactAtRest| {
        let push = contact.push_on(grasp.object)?;
        Some(FrictionContact { point_m: contact.point_m, push, mu: contact.mu })
    };
    let of_object: Vec<FrictionContact> = posture.contacts.iter().filter_map(on_object).collect();
    let loads = loads(&mechanism, found);
    let is_fixed = fixed_object(&scene.hand).is_some();
    let margin = |drives| match is_fixed {
        true => Margin::Undecided { reason: "the object is fixed".to_string() },
        false => margin(&posture, drives, &loads),
    };
    let object = &mechanism.bodies[grasp.object];
    let centre_m = point_in(Some(grasp.object), object.com_m, &posture.poses);
    Some(Firmness {
        driven: margin(DriveState::AtEffort),
        blocked: margin(DriveState::Blocked),
        form_closed: match scene.finger_count() {
            0 => mechanism_closure(&posture.at_rest(DriveState::Blocked)).ok().map(|found| found.closure.closed),
            // The disc of a five-bar hand may rotate.
            _ => is_form_closed(scene, &found.end),
        },
        force_closure: force_closure(&of_object, centre_m, grasp.radius_m),
    })
}

/// Returns the largest acceleration of the base, in a direction of the world, that the contacts which are active at the
/// end can balance with the actuators as they are then. `None` without a grasp, or if the statics have no solution.
pub fn balanced_acceleration(scene: &Scene, found: &ObjectCriteria, direction: [f64; 2]) -> Option<MechanismLimit> {
    let (mechanism, grasp) = (scene.judged_mechanism(), scene.grasp_roles().ok()?);
    let posture = Posture::in_sample(scene, (&mechanism, &grasp), &found.end);
    let balance = balance_at_rest_towards(&posture.at_rest(DriveState::AtEffort), &loads(&mechanism, found), direction);
    Some(balance.ok()??.largest)
}

/// A mechanism in a sample, with the contacts that can push; gravity and the directions of accelerations are those of the world.
struct Posture<'a> {
    mechanism: &'a Mechanism,
    time_s: f64,
    poses: Vec<Pose>,
    contacts: Vec<ContactAtRest>,
    /// Name of the pair of each contact.
    names: Vec<String>,
    roles: Roles,
}

impl<'a> Posture<'a> {
    fn in_sample(scene: &Scene, (mechanism, grasp): (&'a Mechanism, &GraspRoles), sample: &Sample) -> Self {
        let (contacts, names): (Vec<ContactAtRest>, Vec<String>) =
            contacts(mechanism, grasp, (sample, scene.thresholds.loss_force_n)).into_iter().unzip();
        let of_bodies = contacts.iter().map(|contact| contact.bodies);
        let roles = roles(mechanism, (grasp.object, grasp.base), &grasp.surroundings, of_bodies);
        let palm = palm_pose(mechanism, sample.time_s);
        let poses = poses_in(scene, sample).into_iter().map(|pose| pose_in_world(palm, pose)).collect();
        Self { mechanism, time_s: sample.time_s, poses, contacts, names, roles }
    }

    /// What moves beyond a limit.
    fn failure(&self, contacts: &[(f64, f64, ContactMotion)], yielding: &[usize], rubbing: &[String]) -> Failure {
        let mut names: Vec<&String> = self.names.iter().collect();
        names.dedup();
        let mut failure = Failure { rubbing: rubbing.to_vec(), ..Failure::default() };
        for name in names {
            let of_pair = contacts.iter().zip(&self.names).filter(|(_, other)| *other == name);
            let motions: Vec<ContactMotion> = of_pair.map(|((.., motion), _)| *motion).collect();
            let separate = motions.iter().filter(|motion| **motion == ContactMotion::Separates).count();
            let list = if motions.contains(&ContactMotion::Slips) {
                &mut failure.slipping
            } else if separate == motions.len() {
                &mut failure.separating
            } else if separate > 0 {
                &mut failure.tilting
            } else {
                continue;
            };
            list.push(name.clone());
        }
        let pulls = self.mechanism.tendons.iter().filter_map(|tendon| tendon.actuator.as_ref());
        let actuators =
            self.mechanism.actuators.iter().map(|actuator| &actuator.name).chain(pulls.map(|pull| &pull.name));
        let actuators: Vec<&String> = actuators.collect();
        failure.yielding = yielding.iter().filter_map(|index| actuators.get(*index)).map(ToString::to_string).collect();
        failure
    }

    fn at_rest(&self, drives: DriveState) -> MechanismAtRest<'_> {
        let Self { mechanism, time_s, poses, contacts, roles, .. } = self;
        MechanismAtRest { mechanism, poses, time_s: *time_s, contacts, drives, roles }
    }
}

fn margin(posture: &Posture<'_>, drives: DriveState, loads: &LoadsAtRest) -> Margin {
    let balances = match balance_at_rest(&posture.at_rest(drives), loads, DIRECTIONS) {
        Ok(BalanceAtRest::Limits(balances)) => balances,
        Ok(BalanceAtRest::NotAtRest { remainder }) => return Margin::NotAtRest { remainder },
        Err(error) => return Margin::Undecided { reason: error.to_string() },
    };
    let mut limits = Vec::new();
    for balance in balances {
        match balance.largest {
            MechanismLimit::Infeasible { .. } => {
                let reason = "no forces within the friction cones balance the loads at the end".to_string();
                return Margin::Undecided { reason };
            }
            MechanismLimit::Unlimited => {}
            // The rounding of a programme without any margin may be negative.
            MechanismLimit::Limited { acceleration_m_s2, contacts, yielding, rubbing, .. } => {
                limits.push((balance.direction, acceleration_m_s2.max(0.0), (contacts, yielding, rubbing)));
            }
        }
    }
    let Some(least) = limits.iter().map(|(_, limit, _)| *limit).reduce(f64::min) else { return Margin::Any };
    let worst: Vec<_> = limits.iter().filter(|(_, limit, _)| *limit <= least + SAME_LIMIT * least.abs()).collect();
    let angle = |[x, y]: [f64; 2]| atan2(y, x).rem_euclid(std::f64::consts::TAU);
    Margin::Limited {
        acceleration_m_s2: least,
        directions_rad: worst.iter().map(|(direction, ..)| angle(*direction)).collect(),
        failure: worst
            .first()
            .map(|(.., (contacts, yielding, rubbing))| posture.failure(contacts, yielding, rubbing))
            .unwrap_or_default(),
    }
}

/// A contact of a sample with this palm in the world, as one that can push.
pub(crate) fn contact_at_rest(pair: &ContactPair, found: &ContactSample, [x, y, turn]: Pose) -> ContactAtRest {
    let (sin, cos) = sin_cos(turn);
    // From the face to the points.
    let sign = if pair.is_reported_on_face { -1.0 } else { 1.0 };
    ContactAtRest {
        bodies: [pair.points.body, pair.face.body],
        point_m: add([x, y], rotate(found.point_m, [cos, sin])),
        normal: rotate(found.normal.map(|component| sign * component), [cos, sin]),
        mu: pair.law.friction.map_or(0.0, |friction| friction.mu_static),
    }
}

/// Contacts active at the end, with forces above a threshold, of the object with the hand and of the hand with itself; each with
/// the name of its pair.
fn contacts(
    mechanism: &Mechanism,
    grasp: &GraspRoles,
    (sample, loss_force_n): (&Sample, f64),
) -> Vec<(ContactAtRest, String)> {
    let pairs = mechanism.outline_pairs(Some(grasp.object));
    let name = |index: usize| {
        pairs.iter().find(|pair| pair.points.contains(&index)).map_or_else(String::new, |pair| pair.name.clone())
    };
    let palm = palm_pose(mechanism, sample.time_s);
    let is_hand = |body: Option<usize>| {
        body.map_or(grasp.base.is_none(), |body| body == grasp.object || mechanism.has_joint(Some(body)))
    };
    let contact = |(index, point): (usize, PointContact)| {
        let (pair, found) = (&mechanism.contacts[point.pair], sample.contact(index));
        let outlines = [pair.points, pair.face];
        let is_outside = outlines.iter().any(|id| grasp.surroundings.contains(id) || !is_hand(id.body));
        let is_active = found.normal_n > loss_force_n && !is_outside;
        is_active.then(|| (contact_at_rest(pair, &found, palm), name(index)))
    };
    mechanism.point_contacts().into_iter().enumerate().filter_map(contact).collect()
}

/// Loads at the end of a run.
fn loads(mechanism: &Mechanism, found: &ObjectCriteria) -> LoadsAtRest {
    let sample = &found.end;
    let kept = |actuator: &Actuator, ActuatorCriteria { command, is_at_limit, .. }: &ActuatorCriteria| {
        let limit = actuator.effort_limit().unwrap_or(f64::INFINITY);
        match actuator.command {
            Command::Servo { .. } if !is_at_limit => (0.0, [-limit, limit]),
            _ => (command.clamp(-limit, limit), [0.0; 2]),
        }
    };
    let with_brake = |(actuator, found): (&Actuator, &ActuatorCriteria)| {
        let (effort, [low, high]) = kept(actuator, found);
        let [least, most] = actuator.brake.map_or([0.0; 2], |brake| brake.torque_range(sample.time_s));
        (effort, [low + least, high + most])
    };
    let (efforts, slack) = mechanism.actuators.iter().zip(&found.actuators).map(with_brake).unzip();
    LoadsAtRest {
        efforts,
        slack,
        tensions_n: (0..mechanism.tendons.len()).map(|index| sample.tendon(index).tension_n).collect(),
    }
}
