//! Scene files: what a user writes, checked and resolved to SI with every default filled in.
//!
//! | file | job |
//! |---|---|
//! | `raw` | the file as it is written |
//! | `sections`, `schema` | which sections a scene has; its JSON Schema |
//! | `entry`, `kinds`, `words` | single values: read with their place, quantities and words |
//! | `compose` | several texts → one: what a scene extends, and fields that are set besides |
//! | `setting` | a field that is set besides, as a line of a scene |
//! | `over` | what gives way where one part goes over another |
//! | `text`, `keys` | text → raw, unknown keys |
//! | `check`, `error`, `suggest`, `locate` | collecting and showing what is wrong, and where |
//! | `table` | settings: every key with its kind, default, range and use |
//! | `resolve`, `defaults` | raw → [`Scene`], physics checked |
//! | `show` | a scene → a complete scene file |
//! | `template` | what all designs of a study have in common |
//! | `torque` | the motor torque of an actuation over time |
//! | `system` | what is simulated: [`System`], the description that both models read |
//! | `finger`, `disc` | its parts: fingers, discs and planes |
//! | `place`, `pairs`, `touching` | where they touch |
//! | `sound`, `wrong_kind` | which systems neither model takes; a scene of another kind than is wanted |
//! | `palm_motion`, `cycle` | how a gripper's palm moves, and brakes; when it carries |

pub mod any;
pub mod check;
mod compose;
mod cycle;
mod defaults;
mod disc;
pub mod entry;
pub mod error;
mod finger;
pub mod keys;
pub mod kinds;
mod locate;
pub mod over;
mod pairs;
mod palm_motion;
mod place;
mod raw;
mod resolve;
pub mod schema;
mod sections;
mod setting;
mod show;
mod sound;
mod suggest;
mod system;
pub mod table;
mod template;
pub mod text;
mod torque;
mod touching;
pub mod words;
mod wrong_kind;

pub use compose::{Layer, extended, parse_layers};
pub use cycle::Cycle;
pub use disc::{Disc, DiscMotion, HalfPlane};
pub use error::{Problem, SceneError};
pub use finger::{Contacts, Differential, DrivenFinger, Initial, Motor};
pub use kinds::Words;
pub use locate::{Located, located};
pub use pairs::{Pair, Partner};
pub use palm_motion::{Axis, Brake, Move, PalmMotion, Path, Pose, Ramp, Vibration};
pub use place::{Place, Side};
pub use schema::schema;
pub use setting::{setting, setting_of};
pub use show::{show, show_written};
pub use suggest::nearest;
pub use system::System;
pub use table::bounds::Bounds;
pub use table::criteria::Thresholds;
pub use table::engine::{Construction, ENGINE_MAX_STEP_S, Engine, Response, Stepping};
pub use table::integrator::{Integrator, Method, Preset};
pub use table::log::{LogExcess, LogRates};
pub use template::Template;
pub use text::{parse, parse_any, parse_template};
pub use torque::{Actuation, Interpolation, next_corner, scaled, torque};
pub use touching::Touching;
use words::SceneKind;
pub use wrong_kind::WrongKind;

pub use crate::gripper::{Placement, Spring, SpringKind};

/// A resolved scene: everything a model needs, in SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    pub name: String,
    /// What the scene is for, in the user's words; empty if nothing was said.
    pub description: String,
    /// The exact text of the file, kept for the log's attachment.
    pub source: String,
    /// What is simulated.
    pub system: System,
    pub duration_s: f64,
    pub integrator: Integrator,
    pub engine: Engine,
    pub bounds: Bounds,
    /// Thresholds of the grasp criteria of a gripper; without meaning in other kinds of scene.
    pub thresholds: Thresholds,
    pub log: LogRates,
}

impl Scene {
    /// Of which kind it is.
    pub fn kind(&self) -> SceneKind {
        self.system.kind()
    }

    /// The finger that is alone, or the right one.
    ///
    /// # Panics
    /// Where there is none: where its kind is not known, look at that first.
    #[inline]
    pub fn finger(&self) -> &DrivenFinger {
        &self.system.fingers[0]
    }

    /// The same, to be changed.
    ///
    /// # Panics
    /// Where there is none.
    pub fn finger_mut(&mut self) -> &mut DrivenFinger {
        &mut self.system.fingers[0]
    }

    /// What fingers grasp.
    #[inline]
    pub fn object(&self) -> Option<&Disc> {
        self.system.object()
    }

    /// The same for so long in a palm that moves so.
    pub fn moved_by(&self, palm_motion: Option<PalmMotion>, duration_s: f64) -> Self {
        let mut moved = self.clone();
        (moved.system.palm_motion, moved.duration_s) = (palm_motion, duration_s);
        moved
    }

    /// Integrates as a preset says for this kind of scene, within the same step budget. A reference resolves slip to a hundred thousandth of
    /// the narrowest range of a friction law: under one that sticks up to 1 µm/s, with rates to 1e-9 m/s, two methods were 1.2e-7 m apart.
    pub fn integrate_by(&mut self, preset: Preset) {
        let max_steps = self.integrator.max_steps;
        self.integrator = match preset {
            Preset::Engineering => Integrator { max_steps, ..Integrator::everyday(self.kind()) },
            Preset::Reference => {
                let reference = self.integrator.with_preset(preset);
                let resolved = 1e-5 * self.system.narrowest_friction_m_s();
                Integrator { atol_rate_rad_s: reference.atol_rate_rad_s.min(resolved), ..reference }
            }
        };
    }
}
