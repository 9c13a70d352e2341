//! Scene files: what a user writes, checked and resolved to SI with every default filled in.
//!
//! | file | job |
//! |---|---|
//! | `raw`, `raw_bodies` | the file as it is written, of either kind; source of the JSON Schema |
//! | `entry`, `kinds`, `words` | single values: read with their place, quantities and words |
//! | `compose` | several texts → one: what a scene extends, and fields that are set besides |
//! | `text`, `keys` | text → raw, unknown keys |
//! | `check`, `error`, `suggest` | collecting and showing what is wrong |
//! | `resolve`, `defaults` | raw → [`Scene`] or [`BodiesScene`], physics checked |
//! | `show` | either → a complete scene file |
//! | `template` | what all designs of a study have in common |
//! | `torque` | the motor torque of an actuation over time |
//! | `bodies` | scenes of discs instead of a finger |
//! | `gripper` | scenes of two fingers and what they grasp |

mod bodies;
pub mod check;
mod compose;
mod defaults;
pub mod entry;
pub mod error;
mod gripper;
pub mod keys;
pub mod kinds;
mod raw;
mod raw_bodies;
mod resolve;
pub mod schema;
mod show;
mod suggest;
mod template;
pub mod text;
mod torque;
pub mod words;

pub use bodies::{AnyScene, BodiesBounds, BodiesScene, DiscMotion, HalfPlane, NamedDisc, Pair, Partner};
pub use compose::{Layer, extended, parse_layers};
pub use defaults::ENGINE_MAX_STEP_S;
pub use error::{Problem, SceneError};
pub use gripper::{Differential, GripperFinger, GripperObject, GripperScene, Motor, ObjectMotion, Place, Side, Table};
pub use kinds::Words;
pub use schema::schema;
pub use show::{show, show_any, show_bodies, show_written};
pub use suggest::nearest;
pub use template::Template;
pub use text::{parse, parse_any, parse_template};
pub use torque::{next_corner, scaled, torque};

use crate::gripper::{Circle, Finger};
pub use crate::gripper::{Placement, Spring, SpringKind};
use crate::law::{ContactLaw, NormalLaw};
use crate::limits::{MOST_PICTURES, MOST_SAMPLES};

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

/// Integrator of the analytic model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Integrator {
    pub preset: Preset,
    pub method: Method,
    /// Relative tolerance (of rates only: angles have an absolute tolerance).
    pub rtol: f64,
    pub atol_angle_rad: f64,
    pub atol_rate_rad_s: f64,
    /// Step budget; a run that needs more ends with an error and keeps its log.
    pub max_steps: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    Engineering,
    Reference,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    Rodas5p,
    RadauIIa5,
}

/// How the engine model is built and stepped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Engine {
    pub construction: Construction,
    pub response: Response,
    pub stepping: Stepping,
    /// Sweeps of rapier's projected Gauss–Seidel solver over the joints, per step.
    pub iterations: u32,
    /// Step budget; a run that needs more ends with an error and keeps its log.
    pub max_steps: u64,
}

/// Coordinates of the engine model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Construction {
    /// Every body moves freely, every joint is a constraint between two of them: second order.
    Maximal,
    /// A tree of joints in its own coordinates, closed by one constraint: first order.
    Reduced,
}

/// What answers when bodies of the engine model touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Response {
    /// The scene's contact laws, through the contact-force hook.
    Laws,
    /// rapier's own rigid contact, with its Coulomb friction and Newton restitution.
    Rapier { friction: f64, restitution: f64 },
}

/// Step sizes of the engine model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stepping {
    Fixed {
        step_s: f64,
    },
    /// Steps in which no joint strays further than `tolerance_m` from its arc; shorter around impacts.
    Adaptive {
        tolerance_m: f64,
        max_step_s: f64,
    },
}

/// How far the engine model may be from the analytic one before `phalanx validate` says no.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Largest difference of any joint angle over the run.
    pub angle_rad: f64,
    /// Largest difference of a first touch-down.
    pub contact_time_s: f64,
    /// Largest relative difference of a normal force at the end.
    pub final_force: f64,
    /// Largest relative difference of the normal impulse of an impact.
    pub impulse: f64,
    /// Largest opening of a joint of the engine model.
    pub loop_gap_m: f64,
    /// Trajectories are compared up to here (rebounds beyond may be chaotic); the run's duration unless said.
    pub until_s: f64,
}

/// How often the log gets a sample, besides every integrator step within an impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogRates {
    pub numeric_hz: f64,
    /// How often it gets a picture for 3-D views; 0 for none.
    pub picture_hz: f64,
}

/// A log that would be larger than anybody can use.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "{:.0} {} (a rate of {:e} Hz over {} s) are more than the {:e} that a log takes",
    .rate_hz * .duration_s, if *.pictures { "pictures" } else { "samples" }, .rate_hz, .duration_s, .most
)]
pub struct LogExcess {
    /// Of pictures, or else of numbers.
    pub pictures: bool,
    pub rate_hz: f64,
    pub duration_s: f64,
    pub most: f64,
}

impl LogExcess {
    /// The largest rate for this run, as a scene says it.
    pub fn remedy(&self) -> String {
        let key = if self.pictures { "picture_rate" } else { "numeric_rate" };
        format!("{key} = \"{}\"", self.remedy_rate())
    }

    /// The largest rate for this run, rounded down to one digit.
    pub fn remedy_rate(&self) -> String {
        let rate_hz = self.most / self.duration_s;
        let digit = 10f64.powf(rate_hz.log10().floor());
        format!("{:e} Hz", (rate_hz / digit).floor() * digit)
    }
}

impl LogRates {
    /// What there would be too much of in a run of this length, if anything.
    pub fn excess(&self, duration_s: f64) -> Option<LogExcess> {
        let of = |pictures, rate_hz, most| LogExcess { pictures, rate_hz, duration_s, most };
        [of(false, self.numeric_hz, MOST_SAMPLES), of(true, self.picture_hz, MOST_PICTURES)]
            .into_iter()
            .find(|excess| excess.rate_hz * duration_s > excess.most)
    }
}
