//! The playback of a run on a page: moving bodies, plots and events.
//!
//! Samples equal those of the run (of its log) to the bit. A run of more than [`MAX_SAMPLES`] samples is decimated;
//! extremes and the samples around events are retained.
//!
//! | file | job |
//! |---|---|
//! | `build` | data model of a playback, and its evaluation from samples |
//! | `from_scene` | selection of the bodies, contacts and events that are shown |
//! | `panels`, `panels_fingers` | plots of scenes of discs and of fingers |
//! | `recorder` | a sink that records a run for playback in bounded memory |
//! | `decimate` | selection of samples if there are too many |
//! | `json` | serialisation, with the columns of numbers stored separately |

mod build;
mod decimate;
mod from_scene;
pub mod json;
mod panels;
mod panels_fingers;
mod recorder;

pub use build::{Body, ContactSeries, EventMarker, Panel, Playback, Scale, Series};
pub use decimate::MAX_SAMPLES;
pub use from_scene::build_playback;
pub use recorder::PlaybackRecorder;
