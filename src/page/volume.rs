//! The page of grasp-state volumes: a self-contained file that shows them in three dimensions.

use super::html::{PageScript, escape_for_script, fill_template, notes_html, page_style, pictures_html};
use super::volume_data::{is_thinned, to_json};
use super::{Note, Picture};
use crate::format::escape_markup;
use crate::study::volume::Volume;

const TEMPLATE: &str = include_str!("assets/volume/page.html");
const STYLES: [&str; 2] = [include_str!("assets/texts.css"), include_str!("assets/volume/layout.css")];
/// Scripts in order of dependence; all share one scope.
const SCRIPTS: [&str; 11] = [
    include_str!("assets/format.js"),
    include_str!("assets/canvas.js"),
    include_str!("assets/volume/data.js"),
    include_str!("assets/volume/scale.js"),
    include_str!("assets/volume/cube.js"),
    include_str!("assets/volume/stage.js"),
    include_str!("assets/volume/design.js"),
    include_str!("assets/volume/controls.js"),
    include_str!("assets/help.js"),
    include_str!("assets/volume/keys.js"),
    include_str!("assets/volume/main.js"),
];

/// Contents of the page.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumePage<'a> {
    pub title: String,
    pub description: String,
    /// Volumes in the order of [`volumes`](crate::study::volume::volumes).
    pub volumes: &'a [Volume],
    /// Texts and tables.
    pub notes: Vec<Note>,
    pub pictures: Vec<Picture>,
}

/// Renders the page. Equal contents give equal bytes.
pub fn volume_page(page: &VolumePage) -> String {
    let data = escape_for_script(&to_json(page.volumes, &sampling_note(page.volumes)));
    let PageScript { nonce, script } = PageScript::new(&data, &SCRIPTS);
    let fields = [
        ("nonce", nonce),
        ("title", escape_markup(&page.title)),
        ("description", escape_markup(&page.description)),
        ("style", page_style(&STYLES)),
        ("notes", notes_html(&page.notes)),
        ("pictures", pictures_html(&page.pictures)),
        ("data", data),
        ("script", script),
    ];
    fill_template(TEMPLATE, &fields)
}

/// Describes which of the computed points the page contains.
fn sampling_note(volumes: &[Volume]) -> String {
    let Some(first) = volumes.first() else { return String::new() };
    let [l21, phi22, arm] = first.resolution();
    let resolution = format!("{l21} × {phi22} × {arm} points per volume");
    let digits = "Numbers on this page have seven digits; the data file has full precision.";
    match is_thinned(&first.axes) {
        true => format!(
            "{resolution}, reduced for this page: a subset of the values of each axis, including the first and the last. Shares in \
             the viewer refer to the points shown; the tables below count all points. {digits}"
        ),
        false => format!("{resolution}, all on this page. {digits}"),
    }
}
