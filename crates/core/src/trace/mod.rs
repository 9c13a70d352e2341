//! Output of a simulation, independent of model and scene kind: samples, events, and the sinks that receive them.
//!
//! | file | job |
//! |---|---|
//! | `sample`, `outcome` | one instant and the events between instants; the summary of a finished run |
//! | `layout`, `columns` | names of the fingers, bodies and contacts of a sample; its values as named columns with units |
//! | `model`, `overrides` | common interface of both models; settings of a run that replace those of its scene |
//! | `sink`, `decimator`, `recording` | receivers of a run; the samples stored in a log; recording as arrays |
//! | `interpolation`, `grid` | interpolation between two samples; the uniform sampling grid |
//! | `analytic`, `recorder`, `peak_search`, `slip_events`, `reading` | runs of the analytic model; conversion of its states to samples |
//! | `cancellation` | cancellable runs |
//! | `reach` | the region that the fingers of a gripper can reach |
//! | `engine`, `step_observer`, `engine_recorder`, `engine_reading` | runs of the engine; conversion of its nodes to samples |
//! | `contact_tracker`, `step_extrema`, `consistency` | engine contacts through time; extrema within a step; joint and energy checks |

mod analytic;
mod cancellation;
pub mod columns;
#[cfg(feature = "engine")]
mod consistency;
#[cfg(feature = "engine")]
mod contact_tracker;
mod decimator;
#[cfg(feature = "engine")]
mod engine;
#[cfg(feature = "engine")]
mod engine_reading;
#[cfg(feature = "engine")]
mod engine_recorder;
mod error;
mod grid;
mod interpolation;
mod layout;
mod model;
mod outcome;
pub mod overrides;
mod peak_search;
mod reach;
mod reading;
mod recorder;
mod recording;
mod sample;
mod sink;
mod slip_events;
#[cfg(feature = "engine")]
mod step_extrema;
#[cfg(feature = "engine")]
mod step_observer;

pub use analytic::run_analytic;
pub use cancellation::{Cancellable, KeepRunning};
pub use decimator::{Decimated, Decimator};
#[cfg(feature = "engine")]
pub use engine::run_engine;
pub use error::RunError;
pub use interpolation::interpolate;
pub use layout::{ContactChannel, Layout};
pub use model::{Model, run};
pub use outcome::{ContactSummary, Outcome, Work};
pub use reach::Reach;
pub use recording::{Recording, record};
pub use sample::{BodyState, ContactSample, Energy, Event, EventKind, FingerContact, FingerState, Sample};
pub use sink::{RequiredData, Sink, SinkError};
pub use slip_events::MAX_FRICTION_EVENTS;
