//! The static grasp of a mechanism: results of `phalanx statics` for a scene of that kind.
//!
//! The posture is that of a run at a time. The results are force closure of one body by its contacts, form closure of all
//! bodies with the actuators blocked, and the accelerations of the base that the contacts can balance.

use crate::drawing::states::in_sample;
use crate::mechanism::{Body, Mechanism, OutlineShape, Pose, point_in};
use crate::numeric::elementary::hypot;
use crate::numeric::plane::sub;
use crate::scene::{Scene, WrongKind};
use crate::statics::{
    ContactAtRest, DriveState, FrictionContact, MechanismAtRest, MechanismBalance, MechanismClosure, StaticsError,
    force_closure, mechanism_balance, mechanism_closure,
};
use crate::trace::{Model, Sample};

use super::gripper::{FrictionCase, run};

/// Request for the static grasp of a mechanism.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MechanismGraspRequest {
    /// Time of the run; `None` for its end.
    pub at_s: Option<f64>,
    /// Largest gap of a contact; `None` for contacts with a force only.
    pub within_m: Option<f64>,
    /// The held body; `None` for the only body without joints that has contacts.
    pub object: Option<String>,
    /// Friction coefficients, each for all contacts; empty: the coefficients of the scene.
    pub mu_static: Vec<f64>,
    /// Number of acceleration directions, evenly spaced from x towards y.
    pub directions: usize,
}

/// Static grasp of a mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct MechanismGrasp {
    pub scene: String,
    /// State of the run.
    pub sample: Sample,
    pub object: String,
    pub mass_kg: f64,
    /// Centre of mass of the object, and the length by which moments are divided in Q1: its largest distance to the
    /// outlines.
    pub centre_m: [f64; 2],
    pub radius_m: f64,
    /// Names of all bodies, in the order of motions.
    pub bodies: Vec<String>,
    pub contacts: Vec<HeldContact>,
    /// Form closure of all bodies with the actuators blocked.
    pub closure: Result<MechanismClosure, StaticsError>,
    /// Names of the brakes and of the joints with friction, in the order of the limits; brakes only at effort.
    pub brakes: [Vec<String>; 2],
    pub friction_cases: Vec<FrictionCase<MechanismBalance>>,
}

/// An active contact.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldContact {
    pub name: String,
    pub at_rest: ContactAtRest,
    /// Unit normal into the object; `None` for a contact of other bodies.
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
    #[error("\"{scene}\" has no body `{object}`: name one of {} with --object", .bodies.join(", "))]
    NoBody { scene: String, object: String, bodies: Vec<String> },
    #[error("\"{scene}\" has {}: name the held body with --object", which(.bodies))]
    WhichBody { scene: String, bodies: Vec<String> },
    #[error("the body `{object}` of \"{scene}\" has no contact at {:.6} ms: give another time with --at, or a gap with --within", .time_s * 1e3)]
    NoContact { scene: String, object: String, time_s: f64 },
    #[error("the run of \"{scene}\" was not completed: {reason}")]
    Run { scene: String, reason: String },
    #[error("statics of the grasp of \"{scene}\" failed: {error}")]
    Statics { scene: String, error: StaticsError },
    #[error("interrupted")]
    Stopped,
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
    let states = in_sample(mechanism, &sample).bodies.into_iter();
    let poses: Vec<Pose> = states.map(|body| [body.centre_m[0], body.centre_m[1], body.angle_rad]).collect();
    let contacts = active_contacts(mechanism, &sample, object, request.within_m);
    if contacts.iter().all(|contact| contact.push.is_none()) {
        let object = mechanism.bodies[object].name.clone();
        return Err(MechanismGraspError::NoContact { scene: name(), object, time_s: sample.time_s });
    }
    let body = &mechanism.bodies[object];
    let centre_m = point_in(Some(object), body.com_m, &poses);
    let radius_m = reach_m(body);
    let time_s = sample.time_s;
    let statics_error = |error| MechanismGraspError::Statics { scene: name(), error };
    let case = |mu_static: Option<f64>| {
        let at_rest: Vec<ContactAtRest> = contacts
            .iter()
            .map(|contact| ContactAtRest { mu: mu_static.unwrap_or(contact.at_rest.mu), ..contact.at_rest.clone() })
            .collect();
        let polar = |drives| {
            let at_rest = MechanismAtRest { mechanism, poses: &poses, time_s, contacts: &at_rest, drives };
            mechanism_balance(&at_rest, request.directions).map_err(statics_error)
        };
        let of_object: Vec<FrictionContact> = contacts
            .iter()
            .zip(&at_rest)
            .filter_map(|(contact, at_rest)| {
                Some(FrictionContact { point_m: at_rest.point_m, push: contact.push?, mu: at_rest.mu })
            })
            .collect();
        Ok(FrictionCase {
            mu_static,
            force_closure: force_closure(&of_object, centre_m, radius_m),
            polar: [polar(DriveState::Blocked)?, polar(DriveState::AtEffort)?],
        })
    };
    let coefficients: Vec<Option<f64>> = match &request.mu_static[..] {
        [] => vec![None],
        given => given.iter().copied().map(Some).collect(),
    };
    let friction_cases = coefficients.into_iter().map(case).collect::<Result<_, MechanismGraspError>>()?;
    let at_rest: Vec<ContactAtRest> = contacts.iter().map(|contact| contact.at_rest.clone()).collect();
    let drives = DriveState::Blocked;
    let closure = mechanism_closure(&MechanismAtRest { mechanism, poses: &poses, time_s, contacts: &at_rest, drives });
    let with_friction = mechanism.joints.iter().filter(|joint| joint.friction.is_some());
    let joints: Vec<String> = with_friction.map(|joint| joint.name.clone()).collect();
    let braked = mechanism.actuators.iter().filter(|actuator| actuator.brake.is_some());
    let at_effort = braked.map(|actuator| actuator.name.clone()).chain(joints.clone()).collect();
    Ok(MechanismGrasp {
        scene: scene.name.clone(),
        object: body.name.clone(),
        mass_kg: body.mass_kg,
        centre_m,
        radius_m,
        bodies: mechanism.bodies.iter().map(|body| body.name.clone()).collect(),
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
        return found.ok_or(MechanismGraspError::NoBody { scene: scene_name, object: name.to_string(), bodies: all });
    }
    let touches = |body: usize| {
        mechanism.contacts.iter().any(|pair| pair.points.body == Some(body) || pair.face.body == Some(body))
    };
    let held = |body: &usize| bodies[*body].motion.is_none() && !mechanism.has_joint(Some(*body)) && touches(*body);
    let found: Vec<usize> = (0..bodies.len()).filter(held).collect();
    match found[..] {
        [object] => Ok(object),
        _ => Err(MechanismGraspError::WhichBody { scene: scene_name, bodies: names(found) }),
    }
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
    let points = mechanism.point_contacts().into_iter().enumerate();
    let contact = |(index, point): (usize, crate::mechanism::PointContact)| {
        let (pair, found) = (&mechanism.contacts[point.pair], sample.contact(index));
        let is_active = found.normal_n > 0.0 || within_m.is_some_and(|within_m| found.gap_m <= within_m);
        let bodies = [pair.points.body, pair.face.body];
        let mu = pair.law.friction.map_or(0.0, |friction| friction.mu_static);
        // From the face to the points.
        let sign = if pair.is_reported_on_face { -1.0 } else { 1.0 };
        let normal @ [x, y] = found.normal.map(|component| sign * component);
        let push = match bodies.map(|body| body == Some(object)) {
            [true, _] => Some([x, y]),
            [_, true] => Some([-x, -y]),
            _ => None,
        };
        is_active.then_some(HeldContact {
            name: point.name,
            at_rest: ContactAtRest { bodies, point_m: found.point_m, normal, mu },
            push,
            gap_m: found.gap_m,
            forces_n: [found.normal_n, found.tangential_n],
        })
    };
    points.filter_map(contact).collect()
}

/// Largest distance of the outlines of a body from its centre of mass.
fn reach_m(body: &Body) -> f64 {
    let reach = |shape: &OutlineShape| match shape {
        OutlineShape::Ellipse { center_m, semi_axes_m: [a, b], .. } => {
            let [x, y] = sub(*center_m, body.com_m);
            hypot(x, y) + a.max(*b)
        }
        other => {
            let distances = other.vertices_m().into_iter().map(|vertex| {
                let [x, y] = sub(vertex, body.com_m);
                hypot(x, y)
            });
            distances.fold(0.0, f64::max) + other.radius_m()
        }
    };
    body.outlines.iter().map(|outline| reach(&outline.shape)).fold(f64::MIN_POSITIVE, f64::max)
}
