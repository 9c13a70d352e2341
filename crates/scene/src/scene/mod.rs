//! Scene files: parsed, checked and resolved to SI with every default filled in.
//!
//! | file | contents |
//! |---|---|
//! | `sections` | the sections of a scene: every key with its type, default and description; resolved, physics checked |
//! | `quantity`, `keywords` | types of values: quantities with their dimension and range, keywords |
//! | `schema` | the schema of a scene, and what follows from it: allowed values, records, documentation |
//! | `value`, `toml_value` | reading single values by their type |
//! | `section_input` | the file as written, section by section |
//! | `parse` | text → scene as written → [`Scene`] |
//! | `keys` | unknown keys, suggestions |
//! | `compose`, `precedence` | merging of a scene with those it extends and with single settings |
//! | `check`, `error` | collecting, showing and locating problems |
//! | `show` | a scene → a complete scene file |
//! | `template` | the common part of all designs of a study |
//! | `system` | [`System`], the description of the simulated system that both models read, and its possible contacts |
//! | `torque`, `palm_motion` | motor torque over time, brakes; motion of a gripper's palm |

pub mod check;
mod compose;
pub mod error;
pub mod keys;
pub mod keywords;
mod palm_motion;
pub mod parse;
pub mod precedence;
pub mod quantity;
pub mod schema;
mod section_input;
pub mod sections;
mod show;
mod system;
mod template;
pub mod toml_value;
mod torque;
pub mod value;

pub use compose::{Layer, extended, parse_layers, parse_setting, setting_from_parts};
pub use error::{LocatedProblem, Problem, SceneError, locate_problems};
pub use keys::closest_match;
use keywords::SceneKind;
pub use palm_motion::{Axis, Cycle, Move, PalmMotion, Path, Pose, Ramp, Vibration};
pub use parse::{parse, parse_any, parse_template};
pub use quantity::Keyword;
pub use schema::schema;
pub use sections::{
    Bounds, Construction, ENGINE_MAX_STEP_S, Engine, Integrator, LogExcess, LogRates, Method, Preset, Response,
    Stepping, Thresholds,
};
pub use show::{show, show_written};
pub use system::{
    ContactId, Differential, Disc, DiscMotion, DrivenFinger, FingerContactLaws, GripperContact, HalfPlane, Initial,
    Motor, Side, System,
};
pub use template::Template;
pub use torque::{Actuation, Brake, Interpolation, largest_torque, next_discontinuity, scaled, torque};

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

    /// Returns the scene if it is of the required kind.
    ///
    /// # Errors
    /// Returns an error if the scene is of another kind.
    pub fn require_kind(&self, required: SceneKind) -> Result<&Self, WrongKind> {
        match self.kind() {
            found if found == required => Ok(self),
            found => Err(WrongKind { scene: self.name.clone(), found, required }),
        }
    }
}

/// A scene of one kind where another kind is required.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{scene}\" is a scene of kind \"{}\", but a scene of kind \"{}\" is required: give another scene",
    .found.keyword(), .required.keyword()
)]
pub struct WrongKind {
    pub scene: String,
    pub found: SceneKind,
    pub required: SceneKind,
}
