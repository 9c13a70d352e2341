//! A run as it is shown: the moving bodies, plots and events, for a page.
//!
//! Samples are those of the run (of its log), to the bit. A run of more than [`MOST_SAMPLES`] is thinned out, extremes and the
//! surroundings of events kept.
//!
//! | file | job |
//! |---|---|
//! | `develop` | everything a page knows of a run |
//! | `shown`, `panels`, `panels_fingers` | the bodies, contacts and events of a scene that are shown; its plots |
//! | `reel` | a sink that keeps a run for a film, in bounded memory |
//! | `thin` | which samples stay where there are too many |
//! | `data` | films → JSON, their columns apart |

pub mod data;
mod develop;
mod panels;
mod panels_fingers;
mod reel;
mod shown;
mod thin;

pub use develop::{Body, Film, Mark, Panel, Scale, Series, Touch};
pub use reel::Reel;
pub use shown::film;
pub use thin::MOST_SAMPLES;
