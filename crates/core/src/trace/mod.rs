//! Output of a simulation, independent of model and scene kind: samples, events, and the sinks that receive them.

mod analytic;
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
mod mechanism;
mod model;
mod outcome;
pub mod overrides;
mod reach;
mod reading;
mod recorder;
mod recording;
mod sample;
mod sampled;
pub mod schema;
mod simulation;
mod sink;
mod stepper;

pub use decimator::{Decimated, OffGrid};
pub use grid::is_grid_point;
use model::build;
pub use model::{Model, Removal, run, run_analytic, run_until_removal};
pub use outcome::{ContactSummary, Outcome, RunError, Work};
pub(crate) use reach::BOUNDARY_TOLERANCE;
pub use reach::{Exit, Reach};
pub use recording::{Recording, record};
pub use sample::{Event, EventKind, FingerContact, Sample, interpolate};
pub use schema::{BodyState, Channel, ContactName, ContactSample, Counts, Energy, FingerState, JointState, Schema};
pub use simulation::{Action, Simulation, SimulationError};
pub use sink::{Cancellable, KeepRunning, RequiredData, Sink, SinkError};

// What the derivatives of a run need of it.
pub(crate) use analytic::with_kernel;
pub(crate) use grid::{RecordingOptions, Span};
pub(crate) use model::check_supported;
pub(crate) use reading::{Kernel, KernelUser, Start};
pub(crate) use recorder::StepObserver;
pub(crate) use sampled::has_sampled_servos;
pub(crate) use stepper::{AnalyticStepper, Interruption, Stepper};
