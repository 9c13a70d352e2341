//! The grasp of a scene at rest: what `phalanx statics` reports.

use serde::Serialize;

use crate::fivebar::spring::gradient;
use crate::gripper::{FinalPosture, Finger, GraspError, Spring, final_posture};
use crate::numeric::elementary::{cos, sin};
use crate::scene::words::SceneKind;
use crate::scene::{Scene, WrongKind, torque};
use crate::shape::Placed;
use crate::statics::{
    AtRest, Birglen, Equilibrium, FormClosure, Hand, StaticsError, at_rest, birglen, decide, drive_loads,
    equilibrium_each, unilateral,
};

/// How far an object may be from the palm and still rest on it, in m.
const RESTS_M: f64 = 1e-6;

/// Everything about a grasp at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Grasp {
    pub scene: String,
    pub finger: Finger,
    pub object: Placed,
    pub end: FinalPosture,
    /// Proximal and distal.
    pub contacts: [Contact; 2],
    pub drive: Drive,
    /// One for each pair of friction coefficients that was asked for.
    pub forces: Vec<Forces>,
    pub palm: Palm,
    pub closure: FormClosure,
    /// Forces of 1 N·m of the motor without spring and friction: with a palm, all three are positive where the grasp is
    /// form-closed.
    pub pure: Equilibrium,
}

/// Where a phalanx touches.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Contact {
    /// Along the phalanx from its joint.
    pub from_joint_m: f64,
    pub phalanx_m: f64,
    /// On the surfaces of both.
    pub point_m: [f64; 2],
    /// n, from the object into the phalanx.
    pub normal: [f64; 2],
    /// t, from the joint of the phalanx to its end.
    #[serde(skip)]
    pub tangent: [f64; 2],
}

/// What the motor and the spring do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    pub motor_n_m: f64,
    pub spring: Option<SpringAtRest>,
    /// τ_a + τ_s on (q11, q21).
    pub loads_n_m: [f64; 2],
    /// Motor torque from which on the tip pushes (F22 ≥ 0); none where a motor that closes opens the tip.
    pub motor_min_n_m: Option<f64>,
}

/// The spring at the final posture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringAtRest {
    pub spring: Spring,
    /// On the joint it sits at.
    pub torque_n_m: f64,
    /// τ_s on (q11, q21).
    pub loads_n_m: [f64; 2],
}

/// Forces with friction coefficients of the proximal and the distal contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forces {
    pub mu_static: [f64; 2],
    pub equilibrium: Equilibrium,
    pub birglen: Birglen,
}

/// What holds the object from below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Palm {
    Rests,
    /// The scene has no palm.
    None,
    /// The object is above it.
    Apart {
        gap_m: f64,
    },
    /// The object is partly below it: it counts as resting there.
    Within {
        depth_m: f64,
    },
}

impl Palm {
    /// Whether the object cannot go down.
    pub fn holds(&self) -> bool {
        matches!(self, Palm::Rests | Palm::Within { .. })
    }
}

/// What stands in for the scene's values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Instead {
    /// Friction coefficients, of both contacts; none given: none at all, and those of the scene.
    pub mu_static: Vec<f64>,
    pub motor_n_m: Option<f64>,
}

/// Why a scene has no grasp at rest.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GraspStudyError {
    #[error(transparent)]
    Kind(#[from] WrongKind),
    #[error(
        "the scene \"{scene}\" has no object, and statics is about a grasp: take out [object] present = false, or give \
         another scene"
    )]
    NoObject { scene: String },
    #[error("the finger of \"{scene}\" does not grasp its object: {error}")]
    NoGrasp { scene: String, error: GraspError },
    #[error("the grasp of \"{scene}\" has no statics: {error}")]
    Statics { scene: String, error: StaticsError },
}

/// Statics of a scene with a finger and an object.
///
/// The motor torque is that of the end of the scene. The hand is the finger, its mirror image about the object's centre, and
/// the palm if the object rests on it.
///
/// # Errors
/// A scene of another kind or without an object, a finger that does not grasp it, a singular posture.
pub fn grasp(scene: &Scene, instead: &Instead) -> Result<Grasp, GraspStudyError> {
    let name = || scene.name.clone();
    let Some(object) = scene.only(SceneKind::Finger)?.object() else {
        return Err(GraspStudyError::NoObject { scene: name() });
    };
    let object = object.placed();
    let end = final_posture(&scene.finger().linkage.lengths, scene.finger().linkage.assembly, object)
        .map_err(|error| GraspStudyError::NoGrasp { scene: name(), error })?;
    at_rest_with(scene, object, end, instead).map_err(|error| GraspStudyError::Statics { scene: name(), error })
}

fn at_rest_with(scene: &Scene, object: Placed, end: FinalPosture, instead: &Instead) -> Result<Grasp, StaticsError> {
    let finger = scene.finger().linkage;
    let motor_n_m = instead.motor_n_m.unwrap_or_else(|| torque(&scene.finger().motor.actuation, scene.duration_s).0);
    let drive = drive(&finger, &end, motor_n_m, scene.finger().spring.as_ref())?;
    let of_scene = scene.finger().contact.mu_static();
    let asked: Vec<[f64; 2]> = match &instead.mu_static[..] {
        [] if of_scene == [0.0; 2] => vec![of_scene],
        [] => vec![[0.0; 2], of_scene],
        given => given.iter().map(|&mu| [mu; 2]).collect(),
    };
    let forces = |mu_static: [f64; 2]| -> Result<Forces, StaticsError> {
        let equilibrium = equilibrium_each(&finger, &end, drive.loads_n_m, mu_static)?;
        // Of Birglen's two contacts only the distal one has a lever for friction.
        let birglen = birglen(&finger, &end, drive.loads_n_m, mu_static[1])?;
        Ok(Forces { mu_static, equilibrium, birglen })
    };
    let palm = palm(scene, &object);
    let hand = Hand { palm: palm.holds(), ..Hand::symmetric(&finger, &end) };
    Ok(Grasp {
        scene: scene.name.clone(),
        finger,
        object,
        end,
        contacts: contacts(&finger, &object, &end),
        drive,
        forces: asked.into_iter().map(forces).collect::<Result<_, _>>()?,
        palm,
        closure: decide(&unilateral(&hand)?)?,
        pure: equilibrium_each(&finger, &end, [1.0, 0.0], [0.0; 2])?,
    })
}

fn drive(finger: &Finger, end: &FinalPosture, motor_n_m: f64, spring: Option<&Spring>) -> Result<Drive, StaticsError> {
    let loads_n_m = drive_loads(finger, end, motor_n_m, spring)?;
    let AtRest { rates, tip_slope: [slope, _], .. } = at_rest(finger, end)?;
    let spring = spring.map(|&spring| {
        let [g11, g21] = gradient(spring.placement, &rates);
        let [s11, s21] = [loads_n_m[0] - motor_n_m, loads_n_m[1]];
        // τ_s = ∂q_s/∂q_a times a torque.
        let torque_n_m = ((g11 * s11 + g21 * s21) / (g11 * g11 + g21 * g21)).abs();
        SpringAtRest { spring, torque_n_m, loads_n_m: [s11, s21] }
    });
    let held_n_m = spring.map_or(0.0, |spring| -spring.loads_n_m[0]);
    let motor_min_n_m = (slope > 0.0).then_some(held_n_m);
    Ok(Drive { motor_n_m, spring, loads_n_m, motor_min_n_m })
}

fn contacts(finger: &Finger, object: &Placed, end: &FinalPosture) -> [Contact; 2] {
    let quarter = 0.5 * std::f64::consts::PI;
    let contact = |angle: f64, from_joint_m: f64, phalanx_m: f64| {
        let normal = [cos(angle), sin(angle)];
        Contact {
            from_joint_m,
            phalanx_m,
            point_m: object.furthest_m(normal),
            normal,
            tangent: [-normal[1], normal[0]],
        }
    };
    [
        contact(end.posture.q21_rad - quarter, end.l_c21_m, finger.lengths.l21_m),
        contact(end.phi_c_rad, end.l_c22_m, finger.lengths.t22_m),
    ]
}

fn palm(scene: &Scene, object: &Placed) -> Palm {
    let gap_m = object.lowest_m()[1];
    match scene.system.palm.is_some() {
        false => Palm::None,
        true if gap_m.abs() <= RESTS_M => Palm::Rests,
        true if gap_m > 0.0 => Palm::Apart { gap_m },
        true => Palm::Within { depth_m: -gap_m },
    }
}
