//! What a simulation says, whichever model made it: samples, events, and the sinks that take them.

mod outcome;
mod sample;
mod sink;

pub use outcome::{Outcome, SiteSummary, Work};
pub use sample::{ContactSample, Energy, Event, EventKind, LimitSample, Sample, Site};
pub use sink::{Sink, SinkError, Tee};
