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
//! | [`validate`](fn@validate) | compares the engine model with the analytic model |
//! | [`sweep`](mod@sweep) | simulates all designs of a study |

pub use crate::scene::{self, Scene};
pub use crate::study::sweep;
pub use crate::trace::{Event, FingerContact, Model, Outcome, Recording, Sample, Simulation, Sink, record, run};
pub use crate::validate::validate;
