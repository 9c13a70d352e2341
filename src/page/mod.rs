//! Self-contained HTML file of one run, or of two overlaid runs: moving bodies, plots, events, summaries.
//!
//! The file opens without a network: it contains all styles, scripts and samples, and its content security policy
//! forbids any other source. All text of a scene is escaped or quoted, so it is never read as markup.
//!
//! Samples equal those of the run (of its log) to the bit: each column is a little-endian `Float64Array` in base64. A
//! run of more than [`MAX_SAMPLES`] is decimated; extremes and the samples around events are retained, and the page
//! states this. Between two samples, the page interpolates with a cubic where rates are known, and linearly otherwise.

mod explorer;
mod html;
mod presets;

pub(crate) use explorer::{InitialScene, explorer_page, is_gzip};
pub(crate) use html::picture_page;
pub use html::{render_page, report_page};
pub use phalanx_show::playback::{
    ContactSeries, EventMarker, MAX_SAMPLES, Panel, Playback, PlaybackRecorder, PlayedBody, PlayedGrasp, PlayedState,
    Scale, Series, build_playback,
};
pub(crate) use presets::standalone_text;
pub use presets::{Preset, presets};

use crate::format::Report;

/// Contents of a page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    /// Heading and window title: the name of the scene.
    pub title: String,
    /// The description in the scene file; empty if there is none.
    pub description: String,
    /// The run, or two runs that are overlaid.
    pub runs: Vec<Playback>,
    /// Texts and tables, such as a report.
    pub notes: Vec<Note>,
    pub pictures: Vec<Picture>,
}

/// A text with a heading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Note {
    pub title: String,
    pub text: Report,
}

/// A picture drawn by [`plot`](crate::plot), in the light or dark colours of the page.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    pub title: String,
    /// A complete SVG document.
    pub svg: String,
}
