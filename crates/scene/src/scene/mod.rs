//! Scene files: what a user writes, checked and resolved to SI with every default filled in.
//!
//! | file | job |
//! |---|---|
//! | `raw`, `raw_bodies`, `raw_gripper`, `sections` | the file as it is written, of each kind; source of the JSON Schema |
//! | `entry`, `kinds`, `words` | single values: read with their place, quantities and words |
//! | `compose` | several texts → one: what a scene extends, and fields that are set besides |
//! | `setting` | a field that is set besides, as a line of a scene |
//! | `over` | what gives way where one part goes over another |
//! | `text`, `keys` | text → raw, unknown keys |
//! | `check`, `error`, `suggest`, `locate` | collecting and showing what is wrong, and where |
//! | `table` | settings: every key with its kind, default, range and use |
//! | `resolve`, `defaults` | raw → [`Scene`], [`BodiesScene`] or [`GripperScene`], physics checked |
//! | `show` | any of them → a complete scene file |
//! | `template` | what all designs of a study have in common |
//! | `torque` | the motor torque of an actuation over time |
//! | `bodies` | scenes of discs instead of a finger |
//! | `gripper` | scenes of two fingers and what they grasp |
//! | `palm_motion`, `cycle` | how a gripper's palm moves, and brakes; when it carries |

pub mod any;
mod bodies;
pub mod check;
mod compose;
mod cycle;
mod defaults;
pub mod entry;
pub mod error;
mod gripper;
pub mod keys;
pub mod kinds;
mod locate;
mod over;
mod palm_motion;
mod raw;
mod raw_bodies;
mod raw_gripper;
mod resolve;
pub mod schema;
mod sections;
mod setting;
mod show;
mod suggest;
pub mod table;
mod template;
pub mod text;
mod torque;
pub mod words;

pub use bodies::{AnyScene, BodiesScene, DiscMotion, HalfPlane, NamedDisc, Pair, Partner};
pub use compose::{Layer, extended, parse_layers};
pub use cycle::Cycle;
pub use error::{Problem, SceneError};
pub use gripper::{Differential, GripperFinger, GripperObject, GripperScene, Motor, ObjectMotion, Place, Side, Table};
pub use kinds::Words;
pub use locate::{Located, located};
pub use palm_motion::{Axis, Brake, Move, PalmMotion, Path, Pose, Ramp, Vibration};
pub use schema::schema;
pub use setting::{setting, setting_of};
pub use show::{show, show_any, show_bodies, show_gripper, show_written};
pub use suggest::nearest;
pub use table::bounds::{BodiesBounds, Bounds, GripperBounds};
pub use table::engine::{Construction, ENGINE_MAX_STEP_S, Engine, Response, Stepping};
pub use table::integrator::{Integrator, Method, Preset};
pub use table::log::{LogExcess, LogRates};
pub use template::Template;
pub use text::{parse, parse_any, parse_template};
pub use torque::{next_corner, scaled, torque};

use crate::gripper::{Circle, Finger, Site};
pub use crate::gripper::{Placement, Spring, SpringKind};
use crate::law::{Bristle, ContactLaw, NormalLaw};

/// A resolved scene: everything a model needs, in SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    pub name: String,
    /// What the scene is for, in the user's words; empty if nothing was said.
    pub description: String,
    /// The exact text of the file, kept for the log's attachment.
    pub source: String,
    pub finger: Finger,
    /// The disc to be grasped; `None` for a free swing.
    pub object: Option<Disc>,
    /// Whether the palm (half plane y ≤ 0) is there.
    pub palm: bool,
    pub actuation: Actuation,
    pub spring: Option<Spring>,
    /// Joint limit q22 ≥ −φ22; `None` switches it off.
    pub limit: Option<NormalLaw>,
    /// Laws of the two object contacts.
    pub contact: Contacts,
    pub gravity_m_s2: [f64; 2],
    pub duration_s: f64,
    pub initial: Initial,
    pub integrator: Integrator,
    pub engine: Engine,
    pub bounds: Bounds,
    pub log: LogRates,
}

impl Scene {
    /// Whether friction holds at any contact.
    pub fn holds(&self) -> bool {
        self.object.is_some() && Site::ALL.into_iter().any(|site| self.bristle(site).is_some())
    }

    /// What holds at a contact; the joint limit has no friction.
    pub fn bristle(&self, site: Site) -> Option<Bristle> {
        match site {
            Site::Proximal => self.contact.proximal.bristle(),
            Site::Distal => self.contact.distal.bristle(),
            Site::Limit => None,
        }
    }
}

/// A fixed disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    pub radius_m: f64,
    pub centre_m: [f64; 2],
}

impl Disc {
    /// The disc as postures and grasps know it.
    pub fn circle(&self) -> Circle {
        Circle { radius_m: self.radius_m, centre_m: self.centre_m }
    }
}

/// Laws of the proximal (l21) and the distal (t22) contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contacts {
    pub proximal: ContactLaw,
    pub distal: ContactLaw,
}

impl Contacts {
    /// μ_s of both contacts; 0 without friction.
    pub fn mu_static(&self) -> [f64; 2] {
        [self.proximal, self.distal].map(|law| law.friction.map_or(0.0, |law| law.mu_static))
    }
}

/// Motor torque τ11 on l11.
#[derive(Clone, Debug, PartialEq)]
pub enum Actuation {
    Constant {
        torque_n_m: f64,
    },
    /// Torque over time; the first value holds before the first time, the last one after the last.
    Table {
        points: Vec<(f64, f64)>,
        interpolation: Interpolation,
    },
    /// Smooth rise 0 → torque over `rise_s` (cubic smoothstep), then constant.
    Ramp {
        torque_n_m: f64,
        rise_s: f64,
    },
    /// A half sine of the given length, then zero.
    HalfSine {
        torque_n_m: f64,
        length_s: f64,
    },
    /// Constant torque that changes sign at `at_s` (closing, then opening).
    Reversal {
        torque_n_m: f64,
        at_s: f64,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    Linear,
    /// Each value holds until the next time.
    Step,
}

/// Initial joint angles and rates of the two generalised coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Initial {
    pub q11_rad: f64,
    pub q21_rad: f64,
    pub qd11_rad_s: f64,
    pub qd21_rad_s: f64,
}
