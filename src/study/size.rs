//! What a test trajectory asks of spring and motor, for the finger of a scene.

use std::f64::consts::PI;

use crate::gripper::contact_angle_proximal;
use crate::scene::words::SceneKind;
use crate::scene::{Actuation, Scene, SpringKind, WrongKind};
use crate::sizing::{CLOSING_S, Profile, Rule, SizingError, Task, profile};

/// Samples of the profile.
const SAMPLES: usize = 400;

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Over what the motor torque is averaged.
    pub rule: Rule,
    /// Length of the test trajectory.
    pub closing_s: f64,
    /// How far the torsional spring that the constant one is compared with is turned where the finger is straight; `None`: as far as the
    /// scene's own, a right angle where it has none with a preload.
    pub preload_rad: Option<f64>,
}

impl Default for Asked {
    fn default() -> Self {
        Asked { rule: Rule::Rigid, closing_s: CLOSING_S, preload_rad: None }
    }
}

/// A finger's sizing, with what its scene has now.
#[derive(Clone, Debug)]
pub struct Sized {
    pub scene: String,
    pub asked: Asked,
    /// Preload of the torsional spring.
    pub preload_rad: f64,
    pub profile: Profile,
    /// Torques that the scene itself has, where it has constant ones.
    pub given_motor_n_m: Option<f64>,
    pub given_spring_n_m: Option<f64>,
}

/// Why a finger cannot be sized.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SizeError {
    #[error(transparent)]
    Kind(#[from] WrongKind),
    #[error(
        "{scene} has no object to close on, so nothing says how far its finger goes; give a scene without [object] present = false"
    )]
    NoObject { scene: String },
    #[error(transparent)]
    Sizing(#[from] SizingError),
}

/// Sizes the finger of a scene for its object, from where it starts.
///
/// # Errors
/// A scene of another kind or without an object, or a finger that does not close on it.
pub fn size(scene: &Scene, asked: Asked) -> Result<Sized, SizeError> {
    let object =
        scene.only(SceneKind::Finger)?.object().ok_or_else(|| SizeError::NoObject { scene: scene.name.clone() })?;
    let object = object.placed();
    let contact_rad =
        contact_angle_proximal(scene.finger().linkage.lengths.half_width_m, object).map_err(SizingError::from)?;
    let task = Task {
        object,
        opening_rad: contact_rad - scene.finger().initial.q21_rad,
        gravity_m_s2: scene.system.gravity_m_s2,
        closing_s: asked.closing_s,
    };
    let own_rad = scene.finger().spring.and_then(|spring| match spring.kind {
        SpringKind::Torsional { preload_rad, .. } => Some(preload_rad).filter(|preload_rad| *preload_rad > 0.0),
        SpringKind::Constant { .. } => None,
    });
    let preload_rad = asked.preload_rad.or(own_rad).unwrap_or(0.5 * PI);
    Ok(Sized {
        scene: scene.name.clone(),
        asked,
        preload_rad,
        profile: profile(&scene.finger().linkage, &task, preload_rad, SAMPLES)?,
        given_motor_n_m: match scene.finger().motor.actuation {
            Actuation::Constant { torque_n_m } => Some(torque_n_m),
            _ => None,
        },
        given_spring_n_m: scene.finger().spring.and_then(|spring| match spring.kind {
            SpringKind::Constant { torque_n_m } => Some(torque_n_m),
            SpringKind::Torsional { .. } => None,
        }),
    })
}
