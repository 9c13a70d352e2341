//! What a simulation of discs says, whichever model made it: the counterpart of the finger's samples, events and sinks.

mod analytic;
mod engine;
mod engine_reading;
mod instant;
mod reading;
mod run;
mod sample;

pub use run::{BodiesRunError, run_bodies};
pub use sample::{BodiesEvent, BodiesOutcome, BodiesSample, DiscState};
