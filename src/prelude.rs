//! Types and functions of a typical program: `use phalanx::prelude::*;`.
//!
//! | name | purpose |
//! |---|---|
//! | [`scene`](mod@scene), [`Scene`] | `scene::load` reads a scene file; a `Scene` is its content in SI units |
//! | [`Model`] | the analytic model, or the engine model |
//! | [`run`], [`Sink`], [`Outcome`] | simulates a scene; a sink receives samples and events, the outcome is the summary |
//! | [`Simulation`] | a scene that its user advances, with inputs that change: a controller in the loop |
//! | [`Sample`], [`Event`] | the state at one instant; a change of a contact |
//! | [`record`], [`Recording`] | simulates a scene and stores its samples as columns |
//! | [`ObjectTracker`], [`ObjectCriteria`] | a sink that judges a grasp; what it finds: held or not, since when, how |
//! | [`validate`](fn@validate) | compares the engine model with the analytic model |
//! | [`sweep`](mod@sweep) | simulates all designs of a study |
//! | [`log`](mod@log) | writes a run to an MCAP file |

#[doc(inline)]
pub use crate::criteria::{ObjectCriteria, ObjectTracker};
#[doc(inline)]
pub use crate::scene::Scene;
#[doc(inline)]
pub use crate::trace::{
    Event, FingerContact, Model, Outcome, Recording, RunError, Sample, Simulation, Sink, record, run,
};
#[doc(inline)]
pub use crate::validate::validate;

/// Scene files.
pub mod scene {
    #[doc(inline)]
    pub use crate::scene::{Layer, SceneError, load, load_any, load_any_with, parse_any};
}

/// Sweeps over fields of a scene.
pub mod sweep {
    #[doc(inline)]
    pub use crate::study::sweep::{Row, RunStats, Study, StudyError, columns, load, parse, run_while, summary, table};
}

/// Logs of runs.
pub mod log {
    #[doc(inline)]
    pub use crate::log::{create, run_to};
}
