//! Output of a simulation, independent of model and scene kind: samples, events, and the sinks that receive them.

mod analytic;
pub mod columns;
#[cfg(feature = "engine")]
mod consistency;
mod contact_tracker;
mod decimator;
#[cfg(feature = "engine")]
mod engine;
#[cfg(feature = "engine")]
mod engine_reading;
#[cfg(feature = "engine")]
mod engine_recorder;
mod extrema;
mod grid;
mod interpolation;
mod layout;
mod model;
mod outcome;
pub mod overrides;
mod reach;
mod reading;
mod recorder;
mod recording;
mod sample;
mod sink;

pub use analytic::run_analytic;
pub use decimator::Decimated;
#[cfg(feature = "engine")]
pub use engine::run_engine;
pub use interpolation::interpolate;
pub use layout::{ContactChannel, Layout};
pub use model::{Model, run};
pub use outcome::{ContactSummary, Outcome, RunError, Work};
pub use reach::Reach;
pub use recording::{Recording, record};
pub use sample::{BodyState, Channels, ContactSample, Energy, Event, EventKind, FingerContact, FingerState, Sample};
pub use sink::{Cancellable, KeepRunning, RequiredData, Sink, SinkError};
