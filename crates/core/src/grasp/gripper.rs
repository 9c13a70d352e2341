//! The static grasp of a gripper: results of `phalanx statics` for a scene with two fingers.
//!
//! The posture is taken from a run, is the geometric one around the object of the scene, or is given. The results are
//! force closure with friction, form closure, and the accelerations of the palm that the contacts can balance.

use super::friction::{FrictionCase, Held, friction_cases};
use super::gripper_at_rest::{DriveMode, GraspState, GripperAtRest, contact_value, grasp_state, gripper_at_rest};
use crate::criteria::{Fate, ObjectTracker};
use crate::gripper::{FingerContact, GraspError, Posture, close_loop, final_posture};
use crate::mechanism::Actuator;
use crate::numeric::elementary::hypot;
use crate::scene::{HandContact, Object, ObjectMotion, Scene, Side, WrongKind};
use crate::shape::max_radius;
use crate::statics::{
    Blocked, BodyMotion, ContactMotion, ContactPoint, FormClosure, PerContact, StaticsError, efforts, gripper_closure,
};
use crate::trace::{
    self, BodyState, Cancellable, ContactSample, FingerState, Model, Outcome, Removal, RunError, Sample, Schema, Sink,
};

/// Request for the static grasp of a gripper.
#[derive(Clone, Debug, PartialEq)]
pub struct GripperGraspRequest {
    pub posture: PostureRequest,
    /// Friction coefficients; each one is used for all contacts. If empty, the coefficients of the scene are used.
    pub mu_static: Vec<f64>,
    /// Torque of each motor, or of the input of the differential, N·m; `None` for the torque of the scene.
    pub motor_n_m: Option<f64>,
    /// Number of acceleration directions, evenly spaced from x towards y.
    pub directions: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PostureRequest {
    /// Posture of a run of the analytic model at `at_s`; by default at its end, or just before the release. The
    /// contacts are the active ones. If `within_m` is given, surfaces with at most this gap are also in contact.
    Run {
        at_s: Option<f64>,
        within_m: Option<f64>,
    },
    /// All phalanges touch the object at its position in the scene.
    Geometric,
    Explicit(ExplicitPosture),
}

/// A given posture. Surfaces whose gap is at most `within_m` are in contact with the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExplicitPosture {
    /// (q11, q21) of the right finger, and of the left finger.
    pub angles_rad: [[f64; 2]; 2],
    /// Centre of the object, m; `None` for a coordinate keeps that of the scene.
    pub object_m: [Option<f64>; 2],
    pub within_m: f64,
}

/// Static grasp of a gripper.
#[derive(Clone, Debug, PartialEq)]
pub struct GripperGrasp {
    pub scene: String,
    pub source: PostureSource,
    /// Configuration of fingers and object. After a run, the sample also contains forces.
    pub sample: Sample,
    /// Names of all bodies, in the order of motions.
    pub bodies: Vec<String>,
    pub mass_kg: f64,
    pub gravity_m_s2: [f64; 2],
    pub contacts: Vec<ObjectContact>,
    /// Joint limits that are reached.
    pub limits: Vec<HandContact>,
    /// Motors of the fingers, or of the input of the differential.
    pub motors: Vec<MotorAtRest>,
    /// Form closure with both driven links blocked and, with a differential, also with its input blocked.
    pub closures: Vec<(Blocked, Result<FormClosure, StaticsError>)>,
    /// One case for each requested friction coefficient.
    pub friction_cases: Vec<FrictionCase>,
}

/// A motor that is blocked, or that has its torque.
#[derive(Clone, Debug, PartialEq)]
pub struct MotorAtRest {
    /// `right` or `left`, or `input` of the differential.
    pub name: String,
    /// Positive torques close the finger.
    pub torque_n_m: f64,
    /// Smallest and largest torque of the brake that blocks the motor, N·m; infinite if the scene has no brake.
    pub brake_n_m: [f64; 2],
}

/// Force of a contact or joint limit at the largest acceleration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLoad {
    pub id: HandContact,
    /// Normal force, N; torque of a joint limit, N·m.
    pub normal_n: f64,
    /// Friction on phalanx or palm along t = (n_y, −n_x), N; for the left finger, in the mirror image.
    pub tangential_n: f64,
    pub motion: ContactMotion,
}

/// A motion of object and fingers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandMotion {
    pub object_m_s: [f64; 2],
    pub spin_rad_s: f64,
    /// (q̇11, q̇21) of the right finger, and of the mirror image of the left finger.
    pub fingers_rad_s: [[f64; 2]; 2],
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PostureSource {
    Run { time_s: f64, fate: Fate },
    Geometric,
    Explicit,
}

/// A contact with the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectContact {
    pub id: HandContact,
    pub point: ContactPoint,
    pub mu_static: f64,
    /// Normal and tangential force in the run, N; `None` without a run.
    pub forces_n: Option<[f64; 2]>,
}

impl GripperGrasp {
    /// Returns the forces of the contacts and of the joint limits that are reached. The order is that of
    /// [`HandContact::ALL`].
    pub fn loads(&self, contacts: &[(f64, f64, ContactMotion)], limits: &[(f64, ContactMotion)]) -> Vec<ContactLoad> {
        let of_contact = |(contact, load): (&ObjectContact, &(f64, f64, ContactMotion))| {
            let (id, (normal_n, tangential_n, motion)) = (contact.id, *load);
            ContactLoad { id, normal_n, tangential_n: tangent_sign(id) * tangential_n, motion }
        };
        let of_limit = |(id, (torque_n_m, motion)): (&HandContact, &(f64, ContactMotion))| ContactLoad {
            id: *id,
            normal_n: *torque_n_m,
            tangential_n: 0.0,
            motion: *motion,
        };
        let mut loads: Vec<ContactLoad> = self.contacts.iter().zip(contacts).map(of_contact).collect();
        loads.extend(self.limits.iter().zip(limits).map(of_limit));
        loads.sort_by_key(|load| load.id.index());
        loads
    }

    /// Converts a motion of all bodies to one of object and fingers. It is normalised to an object speed of 1 mm/s or,
    /// if the object is at rest, to 1 rad/s of the fastest joint.
    pub fn hand_motion(&self, motion: &[BodyMotion]) -> HandMotion {
        let of = |name: &str| self.bodies.iter().position(|body| body == name).map_or([0.0; 3], |index| motion[index]);
        let rate = |side: Side, link: &str| side.mirror() * of(&format!("{}_{link}", side.name()))[2];
        let fingers = Side::BOTH.map(|side| ["l11", "l21"].map(|link| rate(side, link)));
        let [x, y, spin] = of(Object::NAME);
        let speed = hypot(x, y);
        let fastest = fingers.as_flattened().iter().fold(spin.abs(), |most: f64, rate| most.max(rate.abs()));
        let unit = if speed > 0.0 { speed * 1e3 } else { fastest.max(f64::MIN_POSITIVE) };
        HandMotion {
            object_m_s: [x / unit, y / unit],
            spin_rad_s: spin / unit,
            fingers_rad_s: fingers.map(|finger| finger.map(|rate| rate / unit)),
        }
    }
}

/// Error returned by [`gripper_grasp`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GripperGraspError {
    #[error(transparent)]
    Kind(#[from] WrongKind),
    #[error(
        "the object of \"{scene}\" is fixed, so it needs no grasp: remove [object] motion = \"fixed\", or use another scene"
    )]
    Fixed { scene: String },
    #[error(
        "the run of \"{scene}\" ends at {:.6} ms, before --at {:.6} ms: use an earlier time or a longer duration", .end_s * 1e3, .at_s * 1e3
    )]
    AfterEnd { scene: String, end_s: f64, at_s: f64 },
    #[error(
        "the {side} finger of \"{scene}\" does not reach around its object: {error}; use the posture of a run, or give one with \
         --posture"
    )]
    NotReached { scene: String, side: &'static str, error: GraspError },
    #[error(
        "{contact} penetrates the object by {:.4} mm, more than the {:.4} mm of --within: give other angles or a larger --within", .depth_m * 1e3, .within_m * 1e3
    )]
    TooDeep { contact: String, depth_m: f64, within_m: f64 },
    #[error("the object of \"{scene}\" has no contacts {context}: {hint}")]
    NoContact { scene: String, context: String, hint: &'static str },
    #[error("the run of \"{scene}\" was not completed: {reason}")]
    Run { scene: String, reason: String },
    #[error("statics of the grasp of \"{scene}\" failed: {error}")]
    Statics { scene: String, error: StaticsError },
    #[error("interrupted")]
    Stopped,
}

/// Returns the static grasp of a gripper.
pub fn gripper_grasp(
    scene: &Scene,
    request: &GripperGraspRequest,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Result<GripperGrasp, GripperGraspError> {
    let name = || scene.display_name();
    let ObjectMotion::Free { mass_kg, .. } = scene.require_fingers(2)?.hand.grasped().motion else {
        return Err(GripperGraspError::Fixed { scene: name() });
    };
    let statics_error = |error| GripperGraspError::Statics { scene: name(), error };
    let (source, sample) = posture(scene, request.posture, keep_running)?;
    let mut state = grasp_state(scene, &sample);
    let points = state.configuration.contact_points().map_err(statics_error)?;
    select_contacts(scene, request.posture, &points, &sample, &mut state)?;
    let contacts = object_contacts(scene, &sample, &state, &points, matches!(source, PostureSource::Run { .. }));
    if contacts.is_empty() {
        return Err(no_contact(scene, source));
    }
    let differential = scene.hand.differential.as_ref().map(|_| Blocked::Input);
    let closures = [Blocked::Outputs].into_iter().chain(differential);
    let in_mode = |mode| {
        let found = gripper_at_rest(&scene.hand, &state, mode).map_err(statics_error);
        found.map(|found| found.with_motor_torque(request.motor_n_m))
    };
    let (blocked, at_torque) = (in_mode(DriveMode::Blocked)?, in_mode(DriveMode::AtTorque)?);
    let held = Held { body: blocked.object, radius_m: max_radius(&scene.hand.grasped().shape) };
    let both = [blocked.at_rest(), at_torque.at_rest()];
    Ok(GripperGrasp {
        scene: scene.name.clone(),
        source,
        mass_kg,
        gravity_m_s2: blocked.mechanism.gravity_m_s2,
        bodies: blocked.mechanism.bodies.iter().map(|body| body.name.clone()).collect(),
        limits: Side::BOTH
            .into_iter()
            .filter(|side| state.at_limit[*side as usize])
            .map(|side| HandContact::Finger(side, FingerContact::Limit))
            .collect(),
        motors: motors(&blocked),
        closures: closures
            .map(|blocked| (blocked, gripper_closure(&state.configuration, &state.active, blocked)))
            .collect(),
        friction_cases: friction_cases(&both, held, &request.mu_static, request.directions).map_err(statics_error)?,
        contacts,
        sample,
    })
}

/// Returns the sample of a posture.
fn posture(
    scene: &Scene,
    posture: PostureRequest,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Result<(PostureSource, Sample), GripperGraspError> {
    let centre_m = scene.hand.grasped().centre_m;
    match posture {
        PostureRequest::Run { at_s, .. } => run_posture(scene, at_s, keep_running),
        PostureRequest::Geometric => {
            let not_reached = |(side, error): (Side, GraspError)| GripperGraspError::NotReached {
                scene: scene.display_name(),
                side: side.name(),
                error,
            };
            let angles_rad = geometric_posture(scene).map_err(not_reached)?;
            Ok((PostureSource::Geometric, rest_sample(scene, angles_rad, centre_m)?))
        }
        PostureRequest::Explicit(ExplicitPosture { angles_rad, object_m, .. }) => {
            let centre_m = [0, 1].map(|axis| object_m[axis].unwrap_or(centre_m[axis]));
            Ok((PostureSource::Explicit, rest_sample(scene, angles_rad, centre_m)?))
        }
    }
}

/// Selects the contacts and joint limits of a posture: those of the run, and those that follow from its geometry.
fn select_contacts(
    scene: &Scene,
    posture: PostureRequest,
    points: &PerContact<ContactPoint>,
    sample: &Sample,
    state: &mut GraspState<'_>,
) -> Result<(), GripperGraspError> {
    match posture {
        PostureRequest::Run { within_m, .. } => {
            let nearby = within_m.map(|within_m| contacts_within(scene, points, within_m));
            state.active = nearby.map_or(state.active, |nearby| {
                state.active.zip_with(nearby, |is_active, is_near| is_active || is_near)
            });
        }
        PostureRequest::Geometric => state.active = contacts_within(scene, points, GEOMETRIC_TOLERANCE_M),
        PostureRequest::Explicit(ExplicitPosture { within_m, .. }) => {
            check_depth(scene, points, within_m)?;
            state.active = contacts_within(scene, points, within_m);
            state.at_limit = limits_reached(scene, sample);
        }
    }
    Ok(())
}

/// Motors with the brakes that block them.
fn motors(blocked: &GripperAtRest) -> Vec<MotorAtRest> {
    let GripperAtRest { mechanism, poses, time_s, .. } = blocked;
    let motor = |(actuator, torque_n_m): (&Actuator, f64)| {
        let name = actuator.name.strip_suffix("_motor").unwrap_or("input").to_string();
        MotorAtRest {
            name,
            torque_n_m,
            brake_n_m: actuator.brake.map_or([0.0; 2], |brake| brake.torque_range(*time_s)),
        }
    };
    mechanism.actuators.iter().zip(efforts(mechanism, poses, *time_s)).map(motor).collect()
}

/// Largest gap of a contact in a geometric posture, for rounding errors and the position of the palm.
const GEOMETRIC_TOLERANCE_M: f64 = 1e-6;

/// Largest bending of a distal phalanx that is on its joint limit.
const STRAIGHT_TOLERANCE_RAD: f64 = 1e-6;

/// Runs the scene and returns its posture at a time, or at the end.
fn run_posture(
    scene: &Scene,
    at_s: Option<f64>,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Result<(PostureSource, Sample), GripperGraspError> {
    let (name, end_s) = (scene.display_name(), scene.duration_s);
    if let Some(at_s) = at_s.filter(|at_s| *at_s > end_s) {
        return Err(GripperGraspError::AfterEnd { scene: name, end_s, at_s });
    }
    // After the release there is no grasp, so the time is just before it.
    let duration_s = at_s.or(scene.cycle().release_s.map(f64::next_down)).unwrap_or(end_s);
    let short = Scene { duration_s, ..scene.clone() };
    let mut tracker = ObjectTracker::for_scene(&short);
    match run(Model::Analytic, &short, &mut tracker, keep_running) {
        Some(Ok(outcome)) => {
            let fate =
                tracker.and_then(|tracker| tracker.criteria()).map_or(Fate::NotGrasped, |criteria| criteria.fate);
            Ok((PostureSource::Run { time_s: outcome.last.time_s, fate }, outcome.last))
        }
        Some(Err(reason)) => Err(GripperGraspError::Run { scene: name, reason }),
        None => Err(GripperGraspError::Stopped),
    }
}

/// Returns a sample of fingers and object at rest, at the end of the scene.
fn rest_sample(scene: &Scene, angles_rad: [[f64; 2]; 2], centre_m: [f64; 2]) -> Result<Sample, GripperGraspError> {
    let mut sample = Sample::new(scene.duration_s, Schema::from_scene(scene).counts());
    for side in Side::BOTH {
        let (finger, [q11_rad, q21_rad]) = (&scene.hand.finger(side).linkage, angles_rad[side as usize]);
        let posture = close_loop(&finger.lengths, finger.assembly, q11_rad, q21_rad)
            .map_err(|error| GripperGraspError::Statics { scene: scene.display_name(), error: error.into() })?;
        let Posture { q12_rad, q22_rad, .. } = posture;
        sample.set_finger(side as usize, &FingerState { q11_rad, q21_rad, q12_rad, q22_rad, ..FingerState::default() });
    }
    let object = BodyState { centre_m, angle_rad: scene.hand.grasped().angle_rad, ..BodyState::default() };
    (0..sample.counts().bodies).for_each(|body| sample.set_body(body, &object));
    (0..sample.counts().contacts).for_each(|contact| sample.set_contact(contact, &ContactSample::NONE));
    Ok(sample)
}

/// Returns which phalanges, and whether the palm, have a gap of at most `within_m` to the object.
fn contacts_within(scene: &Scene, points: &PerContact<ContactPoint>, within_m: f64) -> PerContact<bool> {
    let is_near = points.map(|point| point.gap_m <= within_m);
    PerContact { palm: is_near.palm && scene.hand.palm.is_some(), ..is_near }
}

/// Returns whether the joint limits of a posture are reached, right and left.
fn limits_reached(scene: &Scene, sample: &Sample) -> [bool; 2] {
    Side::BOTH.map(|side| {
        let finger = scene.hand.finger(side);
        let angle_from_straight_rad = sample.finger(side as usize).q22_rad + finger.linkage.lengths.phi22_rad;
        finger.limit.is_some() && angle_from_straight_rad <= STRAIGHT_TOLERANCE_RAD
    })
}

fn check_depth(scene: &Scene, points: &PerContact<ContactPoint>, within_m: f64) -> Result<(), GripperGraspError> {
    for id in hand_contacts(scene) {
        let depth_m = -contact_value(points, id).gap_m;
        if depth_m > within_m {
            return Err(GripperGraspError::TooDeep { contact: contact_label(id), depth_m, within_m });
        }
    }
    Ok(())
}

fn contact_label(id: HandContact) -> String {
    match id {
        HandContact::Finger(side, FingerContact::Proximal) => format!("the {} proximal phalanx", side.name()),
        HandContact::Finger(side, _) => format!("the {} distal phalanx", side.name()),
        HandContact::Palm | HandContact::Table => "the palm".to_string(),
    }
}

/// Returns the contacts of the hand in the scene: phalanges and palm.
fn hand_contacts(scene: &Scene) -> impl Iterator<Item = HandContact> {
    let has_palm = scene.hand.palm.is_some();
    HandContact::ALL.into_iter().filter(move |id| match id {
        HandContact::Finger(_, contact) => *contact != FingerContact::Limit,
        HandContact::Palm => has_palm,
        HandContact::Table => false,
    })
}

fn object_contacts(
    scene: &Scene,
    sample: &Sample,
    state: &GraspState<'_>,
    points: &PerContact<ContactPoint>,
    has_forces: bool,
) -> Vec<ObjectContact> {
    let active = hand_contacts(scene).filter(|id| contact_value(&state.active, *id));
    let contacts = active.map(|id| {
        let contact = sample.hand_contact(&scene.hand, id);
        let forces_n = has_forces.then_some([contact.normal_n, tangent_sign(id) * contact.tangential_n]);
        let mu_static = scene.hand.law(id).and_then(|law| law.friction).map_or(0.0, |friction| friction.mu_static);
        ObjectContact { id, point: contact_value(points, id), mu_static, forces_n }
    });
    contacts.collect()
}

/// The tangent is mirrored on the left, but not in samples and in mechanisms.
fn tangent_sign(id: HandContact) -> f64 {
    if matches!(id, HandContact::Finger(Side::Left, _)) { -1.0 } else { 1.0 }
}

fn no_contact(scene: &Scene, source: PostureSource) -> GripperGraspError {
    let (context, hint) = match source {
        PostureSource::Run { time_s, fate } => {
            let context = format!("at {:.6} ms of its run, where its fate is \"{}\"", time_s * 1e3, fate.name());
            (context, "give another time with --at, or another posture with --posture")
        }
        PostureSource::Geometric | PostureSource::Explicit => {
            ("in this posture".to_string(), "give other angles, or a larger --within")
        }
    };
    GripperGraspError::NoContact { scene: scene.display_name(), context, hint }
}

/// Returns (q11, q21) of the right and of the left finger at which all phalanges touch the object, at its position in
/// the scene.
///
/// # Errors
/// Returns the first finger that does not reach around the object, and the reason.
pub fn geometric_posture(scene: &Scene) -> Result<[[f64; 2]; 2], (Side, GraspError)> {
    let object = scene.hand.grasped().placed();
    let mut angles_rad = [[0.0; 2]; 2];
    for side in Side::BOTH {
        let finger = &scene.hand.finger(side).linkage;
        let object_in_finger_frame = object.in_finger_frame(side.mirror(), 0.5 * scene.hand.palm_width_m);
        let end =
            final_posture(&finger.lengths, finger.assembly, object_in_finger_frame).map_err(|error| (side, error))?;
        angles_rad[side as usize] = [end.posture.q11_rad, end.posture.q21_rad];
    }
    Ok(angles_rad)
}

/// Runs a scene. Returns the outcome or the reason of a failure; `None` if the run was interrupted.
pub fn run(
    model: Model,
    scene: &Scene,
    sink: &mut impl Sink,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Option<Result<Outcome, String>> {
    run_until_removal(model, scene, Removal { at_s: 0.0, contacts: &[] }, sink, keep_running)
}

/// Like [`run`], for a mechanism from which some contacts are removed at a given time.
pub fn run_until_removal(
    model: Model,
    scene: &Scene,
    removal: Removal<'_>,
    sink: &mut impl Sink,
    keep_running: &(dyn Fn() -> bool + Sync),
) -> Option<Result<Outcome, String>> {
    match trace::run_until_removal(model, scene, removal, &mut Cancellable { sink, keep_running }) {
        Ok(outcome) => Some(Ok(outcome)),
        Err(error) if error.is_stop() => None,
        Err(RunError::Simulation { failure, .. }) => Some(Err(failure.to_string())),
        Err(RunError::Sink(error)) => Some(Err(error.to_string())),
    }
}
