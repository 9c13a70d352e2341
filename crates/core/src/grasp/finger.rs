//! The static grasp of one finger: results of `phalanx statics`.

use serde::Serialize;

use crate::fivebar::kinematics::gradient;
use crate::gripper::{FinalPosture, Finger, GraspError, Spring, final_posture};
use crate::numeric::elementary::{cos, sin};
use crate::scene::{Scene, WrongKind};
use crate::shape::PlacedShape;
use crate::statics::{
    Birglen, Equilibrium, FormClosure, Hand, StaticKinematics, StaticsError, birglen, decide_form_closure, drive_loads,
    equilibrium_with_mu, static_kinematics, unilateral,
};

/// Largest gap or penetration of an object that rests on the palm, m.
const PALM_TOLERANCE_M: f64 = 1e-6;

/// Static grasp of a finger.
#[derive(Clone, Debug, PartialEq)]
pub struct Grasp {
    pub scene: String,
    pub finger: Finger,
    pub object: PlacedShape,
    pub end: FinalPosture,
    /// Contacts of the proximal and the distal phalanx.
    pub contacts: [Contact; 2],
    pub drive: DriveAtRest,
    /// Forces for each requested pair of friction coefficients.
    pub forces: Vec<Forces>,
    pub palm: Palm,
    pub closure: FormClosure,
    /// Forces per 1 N·m of motor torque alone, without friction. With a palm, all of them are positive if the grasp is
    /// form-closed.
    pub unit_torque_forces: Equilibrium,
}

/// Contact of a phalanx with the object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Contact {
    /// Distance from the joint along the phalanx.
    pub from_joint_m: f64,
    pub phalanx_m: f64,
    pub point_m: [f64; 2],
    /// Unit normal n, from the object into the phalanx.
    pub normal: [f64; 2],
    /// Unit tangent t, from the joint of the phalanx to its end.
    #[serde(skip)]
    pub tangent: [f64; 2],
}

/// Torques of motor and spring in the final posture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveAtRest {
    pub motor_n_m: f64,
    pub spring: Option<SpringAtRest>,
    /// Generalised forces τ_a + τ_s on (q11, q21).
    pub loads_n_m: [f64; 2],
    /// Smallest motor torque at which the distal phalanx pushes (F22 ≥ 0), N·m; `None` if closing opens the phalanx.
    pub motor_min_n_m: Option<f64>,
}

/// Spring in the final posture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringAtRest {
    pub spring: Spring,
    /// Torque of the spring on its joint.
    pub torque_n_m: f64,
    /// Generalised forces τ_s on (q11, q21).
    pub loads_n_m: [f64; 2],
}

/// Forces for one pair of friction coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forces {
    /// Static friction coefficients of the proximal and the distal contact.
    pub mu_static: [f64; 2],
    pub equilibrium: Equilibrium,
    pub birglen: Birglen,
}

/// Support of the object by the palm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Palm {
    Resting,
    /// The scene has no palm.
    None,
    /// The object is above the palm.
    Separated {
        gap_m: f64,
    },
    /// The object penetrates the palm; it counts as resting.
    Penetrating {
        depth_m: f64,
    },
}

impl Palm {
    pub fn supports_object(&self) -> bool {
        matches!(self, Palm::Resting | Palm::Penetrating { .. })
    }
}

/// Values that replace the values of the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GraspOverrides {
    /// Friction coefficients; each one is used for both contacts. If empty, the forces are computed without friction
    /// and with the coefficients of the scene.
    pub mu_static: Vec<f64>,
    /// Motor torque, N·m; `None` for the torque at the end of the scene.
    pub motor_n_m: Option<f64>,
}

/// Error returned by [`grasp`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GraspStudyError {
    #[error(transparent)]
    Kind(#[from] WrongKind),
    #[error(
        "the scene \"{scene}\" has no object, and statics needs a grasp: remove [object] present = false, or use another scene"
    )]
    NoObject { scene: String },
    #[error("the finger of \"{scene}\" does not grasp its object: {error}")]
    NoGrasp { scene: String, error: GraspError },
    #[error("statics of the grasp of \"{scene}\" failed: {error}")]
    Statics { scene: String, error: StaticsError },
}

/// Returns the static grasp of a scene with a finger and an object.
///
/// The motor torque is the one at the end of the scene. The hand consists of the finger, its mirror image about the
/// centre of the object, and the palm if the object rests on it.
///
/// # Errors
/// Returns an error if the scene is of another kind or has no object, the finger cannot grasp the object, or the
/// posture is singular.
pub fn grasp(scene: &Scene, overrides: &GraspOverrides) -> Result<Grasp, GraspStudyError> {
    let name = || scene.display_name();
    let Some(object) = scene.require_fingers(1)?.object() else {
        return Err(GraspStudyError::NoObject { scene: name() });
    };
    let object = object.placed();
    let end = final_posture(&scene.finger().linkage.lengths, scene.finger().linkage.assembly, object)
        .map_err(|error| GraspStudyError::NoGrasp { scene: name(), error })?;
    solve_grasp(scene, object, end, overrides).map_err(|error| GraspStudyError::Statics { scene: name(), error })
}

fn solve_grasp(
    scene: &Scene,
    object: PlacedShape,
    end: FinalPosture,
    overrides: &GraspOverrides,
) -> Result<Grasp, StaticsError> {
    let finger = scene.finger().linkage;
    let motor_n_m = overrides.motor_n_m.unwrap_or_else(|| scene.finger().motor.actuation.at(scene.duration_s).0);
    let drive = drive(&finger, &end, motor_n_m, scene.finger().spring.as_ref())?;
    let scene_mu_static = scene.finger().contact.mu_static();
    let mu_static: Vec<[f64; 2]> = match &overrides.mu_static[..] {
        [] if scene_mu_static == [0.0; 2] => vec![scene_mu_static],
        [] => vec![[0.0; 2], scene_mu_static],
        given => given.iter().map(|&mu| [mu; 2]).collect(),
    };
    let forces = |mu_static: [f64; 2]| -> Result<Forces, StaticsError> {
        let equilibrium = equilibrium_with_mu(&finger, &end, drive.loads_n_m, mu_static)?;
        // In Birglen's model only the distal contact has a lever for friction.
        let birglen = birglen(&finger, &end, drive.loads_n_m, mu_static[1])?;
        Ok(Forces { mu_static, equilibrium, birglen })
    };
    let palm = palm(scene, &object);
    let hand = Hand { palm: palm.supports_object(), ..Hand::symmetric(&finger, &end) };
    Ok(Grasp {
        scene: scene.name.clone(),
        finger,
        object,
        end,
        contacts: contacts(&finger, &object, &end),
        drive,
        forces: mu_static.into_iter().map(forces).collect::<Result<_, _>>()?,
        palm,
        closure: decide_form_closure(&unilateral(&hand)?)?,
        unit_torque_forces: equilibrium_with_mu(&finger, &end, [1.0, 0.0], [0.0; 2])?,
    })
}

fn drive(
    finger: &Finger,
    end: &FinalPosture,
    motor_n_m: f64,
    spring: Option<&Spring>,
) -> Result<DriveAtRest, StaticsError> {
    let loads_n_m = drive_loads(finger, end, motor_n_m, spring)?;
    let StaticKinematics { rates, tip_slope: [slope, _], .. } = static_kinematics(finger, end)?;
    let spring = spring.map(|&spring| {
        let [g11, g21] = gradient(spring.placement, &rates);
        let [s11, s21] = [loads_n_m[0] - motor_n_m, loads_n_m[1]];
        // τ_s = ∂q_s/∂q_a times a torque.
        let torque_n_m = ((g11 * s11 + g21 * s21) / (g11 * g11 + g21 * g21)).abs();
        SpringAtRest { spring, torque_n_m, loads_n_m: [s11, s21] }
    });
    let spring_n_m = spring.map_or(0.0, |spring| -spring.loads_n_m[0]);
    let motor_min_n_m = (slope > 0.0).then_some(spring_n_m);
    Ok(DriveAtRest { motor_n_m, spring, loads_n_m, motor_min_n_m })
}

fn contacts(finger: &Finger, object: &PlacedShape, end: &FinalPosture) -> [Contact; 2] {
    let quarter_turn = 0.5 * std::f64::consts::PI;
    let contact = |angle: f64, from_joint_m: f64, phalanx_m: f64| {
        let normal = [cos(angle), sin(angle)];
        Contact {
            from_joint_m,
            phalanx_m,
            point_m: object.furthest_point_m(normal),
            normal,
            tangent: [-normal[1], normal[0]],
        }
    };
    [
        contact(end.posture.q21_rad - quarter_turn, end.l_c21_m, finger.lengths.l21_m),
        contact(end.phi_c_rad, end.l_c22_m, finger.lengths.t22_m),
    ]
}

fn palm(scene: &Scene, object: &PlacedShape) -> Palm {
    let gap_m = object.lowest_point_m()[1];
    match scene.hand.palm.is_some() {
        false => Palm::None,
        true if gap_m.abs() <= PALM_TOLERANCE_M => Palm::Resting,
        true if gap_m > 0.0 => Palm::Separated { gap_m },
        true => Palm::Penetrating { depth_m: -gap_m },
    }
}
