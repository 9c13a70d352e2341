//! One self-contained HTML file of a run, or of two laid over each other: the moving bodies, plots, events, summaries.
//!
//! The file opens without a network and asks for none: styles, scripts and samples are in it, and its content security
//! policy forbids the rest. Whatever comes from a scene is escaped or quoted, so a name is a name, whatever it looks like.
//!
//! Samples are those of the run (of its log), to the bit: each column is a little-endian `Float64Array` in base64. A run
//! of more than [`MOST_SAMPLES`] is thinned out, extremes and the surroundings of events kept, and the page says so.
//! Between two samples the page draws a straight line.
//!
//! | file | job |
//! |---|---|
//! | `explorer`, `presets`, `base85` | the page that simulates by itself, the scenes it brings along, its module as text |
//! | `volume`, `volume_data` | the page of grasp-state volumes, and its data |
//! | `report` | the page of a report, such as that of a reproduction |
//! | `html` | JSON, texts and pictures → the file, with the `assets` |

mod base85;
mod explorer;
mod html;
mod presets;
mod report;
mod volume;
mod volume_data;

pub use explorer::{Start, explorer_page, is_packed};
pub use html::page;
pub use phalanx_show::film::{Body, Film, MOST_SAMPLES, Mark, Panel, Reel, Scale, Series, Touch, film};
pub use presets::{Preset, presets, whole};
pub use report::report_page;
pub use volume::{VolumePage, volume_page};

use crate::wording::Report;

/// What a page shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    /// Heading, and title of the window: the name of the scene.
    pub title: String,
    /// What the scene is for, in the user's words; empty if nothing was said.
    pub description: String,
    /// One run, or two drawn over each other.
    pub runs: Vec<Film>,
    /// Words and tables, such as a report.
    pub notes: Vec<Note>,
    pub pictures: Vec<Picture>,
}

/// A text with its heading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Note {
    pub title: String,
    pub text: Report,
}

/// A picture of [`plot`](crate::plot): its colours are those of the page, light or dark.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    pub title: String,
    /// A whole SVG document.
    pub svg: String,
}
