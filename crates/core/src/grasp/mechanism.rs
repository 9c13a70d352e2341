//! The static grasp of a mechanism: results of `phalanx statics` for a scene of that kind.
//!
//! The posture is that of a run at a time. The results are force closure of one body by its contacts, form closure of
//! object and hand with the actuators blocked, and the accelerations of the base that the contacts can balance.

use crate::criteria::contact_at_rest;
use crate::drawing::states::{palm_pose, poses_in_world};
use crate::mechanism::{GROUND, JointCombination, Mechanism, OutlineId, point_in};
use crate::scene::{Scene, WrongKind};
use crate::statics::{
    ContactAtRest, DriveState, MechanismAtRest, MechanismClosure, NoGrasp, Roles, StaticsError, carries, default_base,
    default_object, efforts, mechanism_closure, radius_m, roles,
};
use crate::trace::{Model, Sample};

use super::friction::{FrictionCase, Held, friction_cases};
use super::gripper::run;

/// Request for the static grasp of a mechanism.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MechanismGraspRequest {
    /// Time of the run at which the grasp is analysed, s; `None` for the end of the run.
    pub at_s: Option<f64>,
    /// Largest gap of an active contact, m; `None` if only contacts with a force are active.
    pub within_m: Option<f64>,
    /// Name of the held body; `None` for the object of the scene, see [`default_object`].
    pub object: Option<String>,
    /// Name of the body that is accelerated, or `ground`. `None` for the last body that carries all bodies of the hand
    /// that can touch the object.
    pub base: Option<String>,
    /// Friction coefficients; each one is used for all contacts. If empty, the coefficients of the scene are used.
    pub mu_static: Vec<f64>,
    /// Number of acceleration directions, evenly spaced from x towards y.
    pub directions: usize,
}

/// Static grasp of a mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct MechanismGrasp {
    pub scene: String,
    /// State of the run in which the grasp is analysed.
    pub sample: Sample,
    pub object: String,
    pub mass_kg: f64,
    /// Centre of mass of the object, m.
    pub centre_m: [f64; 2],
    /// Length by which moments are divided in Q1, m: the largest distance from the centre of mass to the outlines.
    pub radius_m: f64,
    /// Names of all bodies, in the order of motions.
    pub bodies: Vec<String>,
    /// Name of the body that is accelerated, or `ground`.
    pub base: String,
    /// Names of the moving bodies that are not balanced, because nothing connects them with the object or the hand.
    pub left_out: Vec<String>,
    /// Names of the active contacts with the surroundings, which do not move with the base.
    pub surroundings: Vec<String>,
    /// Actuators: those of joints first, then those of tendons.
    pub actuators: Vec<ActuatorAtRest>,
    pub contacts: Vec<HeldContact>,
    /// Form closure of the object and the hand with the actuators blocked.
    pub closure: Result<MechanismClosure, StaticsError>,
    /// Names of the loads in `MechanismLimit::Limited::brakes`. With blocked actuators (first), they are the joints with
    /// friction; with actuators at their effort (second), the actuators with a brake, then the joints with friction.
    pub brakes: [Vec<String>; 2],
    pub friction_cases: Vec<FrictionCase>,
}

/// An actuator in the posture.
#[derive(Clone, Debug, PartialEq)]
pub struct ActuatorAtRest {
    pub name: String,
    pub role: ActuatorRole,
    /// Effort that its command gives at rest, N·m or N.
    pub effort: f64,
    /// Whether the effort is a torque.
    pub is_torque: bool,
    pub pulls_cable: bool,
}

/// Bodies that an actuator moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActuatorRole {
    /// It moves the object or the hand. It is blocked, or at its effort.
    Hand,
    /// It moves the base, which follows the acceleration. It is blocked in both cases.
    Base,
    /// It moves bodies that are not balanced.
    LeftOut,
}

/// An active contact.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldContact {
    pub name: String,
    pub at_rest: ContactAtRest,
    /// Unit normal into the object; `None` for a contact between other bodies.
    pub push: Option<[f64; 2]>,
    pub gap_m: f64,
    /// Normal and tangential force of the run, N.
    pub forces_n: [f64; 2],
}

/// Error returned by [`mechanism_grasp`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MechanismGraspError {
    #[error(transparent)]
    Kind(#[from] WrongKind),
    #[error(
        "the run of \"{scene}\" ends at {:.6} ms, before --at {:.6} ms: use an earlier time or a longer duration", .end_s * 1e3, .at_s * 1e3
    )]
    AfterEnd { scene: String, end_s: f64, at_s: f64 },
    #[error("\"{scene}\" has no body `{body}`: name one of {} with {flag}", .bodies.join(", "))]
    NoBody { scene: String, body: String, bodies: Vec<String>, flag: &'static str },
    #[error(
        "the body `{object}` of \"{scene}\" has a prescribed motion, which no force affects: name a body that moves by forces \
         with --object"
    )]
    Prescribed { scene: String, object: String },
    #[error(
        "the body `{base}` of \"{scene}\" is not the base of the hand: joints connect other bodies that can touch the object \
         with the ground without it; name the body that carries all of them with --base, or `ground`"
    )]
    NotBase { scene: String, base: String },
    #[error("\"{scene}\" has {}: name the held body with --object", which(.bodies))]
    WhichBody { scene: String, bodies: Vec<String> },
    #[error("the body `{object}` of \"{scene}\" has no contact{} at {:.6} ms: give another time with --at, or a gap with --within", with_hand(.base), .time_s * 1e3)]
    NoContact { scene: String, object: String, base: String, time_s: f64 },
    #[error("the run of \"{scene}\" was not completed: {reason}")]
    Run { scene: String, reason: String },
    #[error("statics of the grasp of \"{scene}\" failed: {error}")]
    Statics { scene: String, error: StaticsError },
    #[error("interrupted")]
    Stopped,
}

fn with_hand(base: &str) -> String {
    if base == GROUND { String::new() } else { format!(" with the hand on `{base}`") }
}

fn which(bodies: &[String]) -> String {
    match bodies {
        [] => "no body without joints that has contacts".to_string(),
        several => format!("several bodies without joints that have contacts, {}", several.join(" and ")),
    }
}

/// Returns the static grasp of a mechanism.
///
/// # Errors
/// See [`MechanismGraspError`].
pub fn mechanism_grasp(
    scene: &Scene,
    request: &MechanismGraspRequest,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Result<MechanismGrasp, MechanismGraspError> {
    scene.require_fingers(0)?;
    let Some(mechanism) = &scene.mechanism else { return Err(MechanismGraspError::Stopped) };
    let name = || scene.display_name();
    let object = object_of(scene, mechanism, request.object.as_deref())?;
    let sample = posture(scene, request.at_s, keep_running)?;
    let poses = poses_in_world(mechanism, &sample);
    let base = base_of(scene, mechanism, object, request.base.as_deref())?;
    let active = active_contacts(mechanism, &sample, object, request.within_m);
    let surroundings = surroundings_of(scene);
    let of_bodies = active.iter().map(|contact| contact.at_rest.bodies);
    let roles = roles(mechanism, (object, base), surroundings, of_bodies);
    let (surroundings, contacts): (Vec<HeldContact>, Vec<HeldContact>) =
        active.into_iter().partition(|contact| roles.is_surroundings(mechanism, contact.at_rest.bodies));
    let base = mechanism.body_name(base).to_string();
    if contacts.iter().all(|contact| contact.push.is_none()) {
        let object = mechanism.bodies[object].name.clone();
        return Err(MechanismGraspError::NoContact { scene: name(), object, base, time_s: sample.time_s });
    }
    let body = &mechanism.bodies[object];
    let centre_m = point_in(Some(object), body.com_m, &poses);
    let held = Held { body: object, radius_m: radius_m(body) };
    let time_s = sample.time_s;
    let statics_error = |error| MechanismGraspError::Statics { scene: name(), error };
    let at_rest: Vec<ContactAtRest> = contacts.iter().map(|contact| contact.at_rest).collect();
    let both = [DriveState::Blocked, DriveState::AtEffort].map(|drives| MechanismAtRest {
        mechanism,
        poses: &poses,
        time_s,
        contacts: &at_rest,
        drives,
        roles: &roles,
    });
    let friction_cases = friction_cases(&both, held, &request.mu_static, request.directions).map_err(statics_error)?;
    let closure = mechanism_closure(&both[0]);
    let is_left_out = |index: &usize| !(roles.is_balanced[*index] || roles.moves_with_base[*index]);
    let left_out = (0..mechanism.bodies.len()).filter(is_left_out).map(|index| mechanism.bodies[index].name.clone());
    let with_friction = mechanism.joints.iter().filter(|joint| joint.friction.is_some());
    let joints: Vec<String> = with_friction.map(|joint| joint.name.clone()).collect();
    let braked = mechanism.actuators.iter().filter(|actuator| actuator.brake.is_some());
    let at_effort = braked.map(|actuator| actuator.name.clone()).chain(joints.clone()).collect();
    Ok(MechanismGrasp {
        scene: scene.name.clone(),
        object: body.name.clone(),
        mass_kg: body.mass_kg,
        centre_m,
        radius_m: held.radius_m,
        bodies: mechanism.bodies.iter().map(|body| body.name.clone()).collect(),
        base,
        left_out: left_out.collect(),
        surroundings: surroundings.into_iter().map(|contact| contact.name).collect(),
        actuators: actuators(mechanism, &roles, &efforts(mechanism, &poses, time_s)),
        contacts,
        closure,
        brakes: [joints, at_effort],
        friction_cases,
        sample,
    })
}

/// Finds the held body.
fn object_of(scene: &Scene, mechanism: &Mechanism, name: Option<&str>) -> Result<usize, MechanismGraspError> {
    let bodies = &mechanism.bodies;
    let names = |of: Vec<usize>| of.into_iter().map(|body| format!("`{}`", bodies[body].name)).collect();
    let scene_name = scene.display_name();
    if let Some(name) = name {
        let found = bodies.iter().position(|body| body.name == name);
        let all = names((0..bodies.len()).collect());
        let found = found.ok_or(MechanismGraspError::NoBody {
            scene: scene_name.clone(),
            body: name.to_string(),
            bodies: all,
            flag: "--object",
        })?;
        return match bodies[found].motion {
            None => Ok(found),
            Some(_) => Err(MechanismGraspError::Prescribed { scene: scene_name, object: name.to_string() }),
        };
    }
    if let Some(object) = scene.grasp.as_ref().and_then(|keys| keys.object) {
        return Ok(object);
    }
    default_object(mechanism).map_err(|error| {
        let bodies = if let NoGrasp::SeveralObjects(bodies) = error { bodies } else { Vec::new() };
        MechanismGraspError::WhichBody { scene: scene_name, bodies }
    })
}

/// Outlines that are no part of the hand.
fn surroundings_of(scene: &Scene) -> &[OutlineId] {
    scene.grasp.as_ref().map_or(&[], |keys| &keys.surroundings)
}

/// Finds the base; `None` is the ground.
fn base_of(
    scene: &Scene,
    mechanism: &Mechanism,
    object: usize,
    name: Option<&str>,
) -> Result<Option<usize>, MechanismGraspError> {
    let base = match name {
        None => {
            let given = scene.grasp.as_ref().and_then(|keys| keys.base);
            return Ok(given.unwrap_or_else(|| default_base(mechanism, object, surroundings_of(scene))));
        }
        Some(GROUND) => return Ok(mechanism.frame()),
        Some(name) => mechanism.bodies.iter().position(|body| body.name == name),
    };
    let surroundings = surroundings_of(scene);
    let (scene, body) = (scene.name.clone(), name.unwrap_or_default().to_string());
    let Some(base) = base else {
        let names = mechanism.bodies.iter().map(|body| body.name.as_str()).chain([GROUND]);
        let bodies = names.map(|name| format!("`{name}`")).collect();
        return Err(MechanismGraspError::NoBody { scene, body, bodies, flag: "--base" });
    };
    match carries(mechanism, (object, base), surroundings) {
        true => Ok(Some(base)),
        false => Err(MechanismGraspError::NotBase { scene, base: body }),
    }
}

fn actuators(mechanism: &Mechanism, roles: &Roles, efforts: &[f64]) -> Vec<ActuatorAtRest> {
    let role = |moves_balanced: bool, moves_base: bool| match (moves_balanced, moves_base) {
        (true, _) => ActuatorRole::Hand,
        (false, true) => ActuatorRole::Base,
        (false, false) => ActuatorRole::LeftOut,
    };
    let of_joints = mechanism.actuators.iter().map(|actuator| {
        let is_torque = actuator.on.terms.iter().all(|(joint, _)| mechanism.joints[*joint].kind.is_angle());
        let role = role(roles.moves_balanced(mechanism, &actuator.on), roles.moves_base(mechanism, &actuator.on));
        (actuator.name.clone(), role, is_torque, false)
    });
    let of_tendons = mechanism.tendons.iter().filter_map(|tendon| {
        let on = JointCombination { terms: tendon.joints.clone(), offset: 0.0 };
        let bodies = || tendon.path.iter().filter_map(|element| element.body);
        let moves_balanced = bodies().any(|body| roles.is_balanced[body]) || roles.moves_balanced(mechanism, &on);
        let moves_base = bodies().all(|body| roles.moves_with_base[body]) && roles.moves_base(mechanism, &on);
        Some((tendon.actuator.as_ref()?.name.clone(), role(moves_balanced, moves_base), false, true))
    });
    let all = of_joints.chain(of_tendons).zip(efforts);
    let found =
        |((name, role, is_torque, pulls_cable), &effort)| ActuatorAtRest { name, role, effort, is_torque, pulls_cable };
    all.map(found).collect()
}

/// Runs the scene and returns its state at a time, or at the end.
fn posture(
    scene: &Scene,
    at_s: Option<f64>,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Result<Sample, MechanismGraspError> {
    let end_s = scene.duration_s;
    if let Some(at_s) = at_s.filter(|at_s| *at_s > end_s) {
        return Err(MechanismGraspError::AfterEnd { scene: scene.display_name(), end_s, at_s });
    }
    let short = Scene { duration_s: at_s.unwrap_or(end_s), ..scene.clone() };
    match run(Model::Analytic, &short, &mut (), keep_running) {
        Some(Ok(outcome)) => Ok(outcome.last),
        Some(Err(reason)) => Err(MechanismGraspError::Run { scene: scene.display_name(), reason }),
        None => Err(MechanismGraspError::Stopped),
    }
}

fn active_contacts(mechanism: &Mechanism, sample: &Sample, object: usize, within_m: Option<f64>) -> Vec<HeldContact> {
    let (points, palm) = (mechanism.point_contacts().into_iter().enumerate(), palm_pose(mechanism, sample.time_s));
    let contact = |(index, point): (usize, crate::mechanism::PointContact)| {
        let (pair, found) = (&mechanism.contacts[point.pair], sample.contact(index));
        let is_active = found.normal_n > 0.0 || within_m.is_some_and(|within_m| found.gap_m <= within_m);
        let at_rest = contact_at_rest(pair, &found, palm);
        is_active.then_some(HeldContact {
            name: point.name,
            at_rest,
            push: at_rest.push_on(object),
            gap_m: found.gap_m,
            forces_n: [found.normal_n, found.tangential_n],
        })
    };
    points.filter_map(contact).collect()
}
