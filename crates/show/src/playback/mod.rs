//! The playback of a run on a page: moving bodies, plots and events.
//!
//! Samples equal those of the run (of its log) to the bit. A run of more than [`MAX_SAMPLES`] samples is decimated;
//! extremes and the samples around events are retained.
//!
//! | file | job |
//! |---|---|
//! | `build` | data model of a playback, and its evaluation from samples |
//! | `contacts` | the contacts that are shown: the points of a pair of outlines are one |
//! | `panels` | the plots |
//! | `recorder` | a sink that records a run for playback in bounded memory |
//! | `decimate` | selection of samples if there are too many |
//! | `json` | serialisation, with the columns of numbers stored separately |

mod build;
mod contacts;
mod decimate;
pub mod json;
mod panels;
mod recorder;

pub use build::{
    Column, ContactSeries, EventMarker, Panel, Playback, PlayedBody, PlayedGrasp, PlayedState, Series, build_playback,
};
pub use decimate::MAX_SAMPLES;
pub use panels::Scale;
pub use recorder::PlaybackRecorder;
