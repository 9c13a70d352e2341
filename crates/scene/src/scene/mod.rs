//! Scene files: parsed, checked and resolved to SI with every default filled in.
//!
//! | file | contents |
//! |---|---|
//! | `settings` | the sections of a scene as structs: every key with its type, default and description |
//! | `quantity`, `keywords` | types of values: quantities with their dimension and range, keywords |
//! | `schema` | the JSON Schema of a scene, and what follows from it: allowed values, records, documentation |
//! | `value`, `toml_value` | reading single values by their type |
//! | `section_input` | the file as written, section by section |
//! | `compose`, `texts`, `setting`, `precedence` | merging of a scene with those it extends and with single settings |
//! | `parse`, `keys` | text → scene; unknown keys |
//! | `check`, `error`, `suggest`, `locate` | collecting, showing and locating problems |
//! | `resolve` | scene as written → [`Scene`], physics checked |
//! | `show` | a scene → a complete scene file |
//! | `template` | the common part of all designs of a study |
//! | `torque` | motor torque over time |
//! | `system` | [`System`], the description of the simulated system that both models read |
//! | `finger`, `disc` | components of a system: fingers, discs and planes |
//! | `gripper_contact`, `contact_id` | possible contacts |
//! | `unsupported`, `wrong_kind` | systems that neither model supports; scenes of the wrong kind |
//! | `palm_motion`, `cycle` | motion of a gripper's palm; brakes; times of a grasp cycle |

pub mod check;
mod compose;
mod contact_id;
mod cycle;
mod disc;
pub mod error;
mod finger;
mod gripper_contact;
pub mod keys;
pub mod keywords;
mod locate;
mod palm_motion;
pub mod parse;
pub mod precedence;
pub mod quantity;
mod resolve;
pub mod schema;
mod section_input;
mod setting;
pub mod settings;
mod show;
mod suggest;
mod system;
mod template;
mod texts;
pub mod toml_value;
mod torque;
mod unsupported;
pub mod value;
mod wrong_kind;

pub use compose::{Layer, extended, parse_layers};
pub use contact_id::ContactId;
pub use cycle::Cycle;
pub use disc::{Disc, DiscMotion, HalfPlane};
pub use error::{Problem, SceneError};
pub use finger::{Differential, DrivenFinger, FingerContactLaws, Initial, Motor};
pub use gripper_contact::{GripperContact, Side};
use keywords::SceneKind;
pub use locate::{LocatedProblem, locate_problems};
pub use palm_motion::{Axis, Brake, Move, PalmMotion, Path, Pose, Ramp, Vibration};
pub use parse::{parse, parse_any, parse_template};
pub use quantity::Keyword;
pub use schema::schema;
pub use setting::{parse_setting, setting_from_parts};
pub use settings::{
    Bounds, Construction, ENGINE_MAX_STEP_S, Engine, Integrator, LogExcess, LogRates, Method, Preset, Response,
    Stepping, Thresholds,
};
pub use show::{show, show_written};
pub use suggest::closest_match;
pub use system::System;
pub use template::Template;
pub use torque::{Actuation, Interpolation, largest_torque, next_discontinuity, scaled, torque};
pub use wrong_kind::WrongKind;

pub use crate::gripper::{Placement, Spring, SpringKind};

/// A resolved scene: everything a model needs, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    pub name: String,
    /// Description by the user; empty if there is none.
    pub description: String,
    /// The exact text of the file, for the attachment of the log.
    pub source: String,
    pub system: System,
    pub duration_s: f64,
    pub integrator: Integrator,
    pub engine: Engine,
    pub bounds: Bounds,
    /// Thresholds of the grasp criteria of a gripper; unused in other kinds of scene.
    pub thresholds: Thresholds,
    pub log: LogRates,
}

impl Scene {
    pub fn kind(&self) -> SceneKind {
        self.system.kind()
    }

    /// Returns the single finger, or the right finger of a gripper.
    ///
    /// # Panics
    /// Panics if there are no fingers: check [`Scene::kind`] first.
    #[inline]
    pub fn finger(&self) -> &DrivenFinger {
        &self.system.fingers[0]
    }

    /// Mutable access to [`Scene::finger`].
    ///
    /// # Panics
    /// Panics if there are no fingers.
    pub fn finger_mut(&mut self) -> &mut DrivenFinger {
        &mut self.system.fingers[0]
    }

    /// Returns the object that fingers grasp.
    #[inline]
    pub fn object(&self) -> Option<&Disc> {
        self.system.object()
    }

    /// Returns a copy with another palm motion and duration.
    pub fn with_palm_motion(&self, palm_motion: Option<PalmMotion>, duration_s: f64) -> Self {
        let mut moved = self.clone();
        (moved.system.palm_motion, moved.duration_s) = (palm_motion, duration_s);
        moved
    }

    /// Applies a preset of the integrator for this kind of scene and keeps the step budget. The reference preset
    /// resolves slip rates to 1e-5 of the narrowest slip range of a friction law: with a sticking range of 1 µm/s and a
    /// tolerance of 1e-9 m/s, two methods differed by 1.2e-7 m.
    pub fn apply_preset(&mut self, preset: Preset) {
        let max_steps = self.integrator.max_steps;
        self.integrator = match preset {
            Preset::Engineering => Integrator { max_steps, ..Integrator::engineering_for(self.kind()) },
            Preset::Reference => {
                let reference = self.integrator.with_preset(preset);
                let resolved = 1e-5 * self.system.narrowest_slip_range_m_s();
                Integrator { atol_rate_rad_s: reference.atol_rate_rad_s.min(resolved), ..reference }
            }
        };
    }
}
