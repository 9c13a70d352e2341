//! What a simulation says, whichever model made it: samples, events, and the sinks that take them.

mod analytic;
mod between;
pub mod bodies;
pub mod columns;
mod engine;
mod engine_reading;
mod engine_recorder;
mod error;
mod grid;
mod instant;
mod model;
mod moments;
mod outcome;
mod reading;
mod recorder;
mod recording;
mod sample;
mod search;
mod sink;
mod thin;
mod tracked;

pub use analytic::run_analytic;
pub use between::between;
pub use engine::run_engine;
pub use error::RunError;
pub use instant::Instant;
pub use model::{Model, run};
pub use outcome::{Outcome, SiteSummary, Work};
pub use recording::{Recording, record, record_bodies};
pub use sample::{ContactSample, Energy, Event, EventKind, Sample, Site};
pub use sink::{Sink, SinkError};
pub use thin::{Thin, Thinned};
