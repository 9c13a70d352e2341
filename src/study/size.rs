//! Sizing of spring and motor for the finger of a scene from a test trajectory.

use std::f64::consts::PI;

use super::constant_spring;
use crate::gripper::contact_angle_proximal;
use crate::scene::{self, Scene, SpringKind, WrongKind};
use crate::sizing::{CLOSING_S, Profile, Rule, SizingError, Task, profile};

const SAMPLES: usize = 400;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizingOptions {
    /// Rule for averaging the motor torque.
    pub rule: Rule,
    /// Duration of the test trajectory, s.
    pub closing_s: f64,
    /// Deflection of the torsional spring when the finger is straight, rad. This spring is compared with the constant
    /// spring. Default: the preload of the scene's spring, or a right angle if the scene has no preloaded torsional
    /// spring.
    pub preload_rad: Option<f64>,
}

impl Default for SizingOptions {
    fn default() -> Self {
        SizingOptions { rule: Rule::Rigid, closing_s: CLOSING_S, preload_rad: None }
    }
}

/// Sized torques of a finger, and the present torques of its scene.
#[derive(Clone, Debug)]
pub struct FingerSizing {
    pub scene: String,
    pub options: SizingOptions,
    pub preload_rad: f64,
    pub profile: Profile,
    /// Constant motor torque of the scene, N·m; `None` if it is not constant.
    pub given_motor_n_m: Option<f64>,
    /// Constant spring torque of the scene, N·m; `None` if it is not constant.
    pub given_spring_n_m: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SizeError {
    #[error(transparent)]
    Kind(#[from] WrongKind),
    #[error(
        "{scene} has no object, so the closing angle of its finger is undefined; give a scene without [object] present = false"
    )]
    NoObject { scene: String },
    #[error(transparent)]
    Sizing(#[from] SizingError),
}

/// Sizes the spring and the motor of the finger. The task is to close on the object from the initial posture.
pub fn size_finger(scene: &Scene, options: SizingOptions) -> Result<FingerSizing, SizeError> {
    let object =
        scene.require_fingers(1)?.object().ok_or_else(|| SizeError::NoObject { scene: scene.display_name() })?;
    let object = object.placed();
    let contact_rad =
        contact_angle_proximal(scene.finger().linkage.lengths.half_width_m, object).map_err(SizingError::from)?;
    let task = Task {
        object,
        opening_rad: contact_rad - scene.finger().initial.q21_rad,
        gravity_m_s2: scene.hand.gravity_m_s2,
        closing_s: options.closing_s,
    };
    let scene_preload_rad = scene.finger().spring.and_then(|spring| match spring.kind {
        SpringKind::Torsional { preload_rad, .. } => Some(preload_rad).filter(|preload_rad| *preload_rad > 0.0),
        SpringKind::Constant { .. } => None,
    });
    let preload_rad = options.preload_rad.or(scene_preload_rad).unwrap_or(0.5 * PI);
    Ok(FingerSizing {
        scene: scene.name.clone(),
        options,
        preload_rad,
        profile: profile(&scene.finger().linkage, &task, preload_rad, SAMPLES)?,
        given_motor_n_m: match scene.finger().motor.actuation {
            scene::Profile::Constant { value: torque_n_m } => Some(torque_n_m),
            _ => None,
        },
        given_spring_n_m: constant_spring(scene.finger()),
    })
}
