//! What a simulation says, whichever model made it and whatever it simulates: samples, events, and the sinks that take them.
//!
//! | file | job |
//! |---|---|
//! | `sample`, `outcome` | one instant, the events between instants, and what remains in the end |
//! | `layout`, `columns` | what the samples of a scene consist of: its fingers, bodies and contacts by name, its figures with their units |
//! | `model`, `overrides` | the two models behind one face; a run that is made otherwise than its scene says |
//! | `sink`, `thin`, `recording` | who takes a run: everything, what a log keeps, arrays |
//! | `between`, `grid` | a sample between two others; the even grid of times |
//! | `analytic`, `recorder`, `search`, `reading` | runs of the analytic model, and how its states are read |
//! | `gate` | runs that end when they are told to |
//! | `reach` | the region that the fingers of a gripper can reach |
//! | `engine`, `engine_recorder`, `moments`, `tracked`, `engine_reading` | runs of the engine, and how its nodes are read |

mod analytic;
mod between;
pub mod columns;
#[cfg(feature = "engine")]
mod engine;
#[cfg(feature = "engine")]
mod engine_reading;
#[cfg(feature = "engine")]
mod engine_recorder;
mod error;
#[cfg(feature = "engine")]
mod follow;
mod gate;
mod grid;
mod layout;
mod model;
#[cfg(feature = "engine")]
mod moments;
mod outcome;
pub mod overrides;
mod reach;
mod reading;
mod recorder;
mod recording;
mod sample;
mod search;
mod sink;
mod slipping;
#[cfg(feature = "engine")]
mod soundness;
mod thin;
#[cfg(feature = "engine")]
mod tracked;

pub use analytic::run_analytic;
pub use between::between;
#[cfg(feature = "engine")]
pub use engine::run_engine;
pub use error::RunError;
pub use gate::{GoOn, While};
pub use layout::{Layout, Place};
pub use model::{Model, run};
pub use outcome::{ContactSummary, Outcome, Work};
pub use reach::Reach;
pub use recording::{Recording, record};
pub use sample::{BodyState, ContactSample, Energy, Event, EventKind, FingerState, Sample, Site};
pub use sink::{Sink, SinkError, Wants};
pub use slipping::MOST_FRICTION_EVENTS;
pub use thin::{Thin, Thinned};
