//! The page of grasp-state volumes: one self-contained file that turns them in three dimensions.

use super::html::{Script, filled, in_script, notes, pictures, style};
use super::volume_data::{is_thinned, json};
use super::{Note, Picture};
use crate::study::volume::Volume;
use crate::wording::escaped;

const TEMPLATE: &str = include_str!("assets/volume/page.html");
const STYLES: [&str; 2] = [include_str!("assets/texts.css"), include_str!("assets/volume/layout.css")];
/// In the order of their dependence; they share one scope.
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

/// What the page shows.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumePage<'a> {
    pub title: String,
    pub description: String,
    /// As they come from [`volumes`](crate::study::volume::volumes).
    pub volumes: &'a [Volume],
    /// Words and tables.
    pub notes: Vec<Note>,
    pub pictures: Vec<Picture>,
}

/// The whole file. The same page gives the same bytes.
pub fn volume_page(page: &VolumePage) -> String {
    let data = in_script(&json(page.volumes, &note(page.volumes)));
    let Script { nonce, script } = Script::new(&data, &SCRIPTS);
    let fields = [
        ("nonce", nonce),
        ("title", escaped(&page.title)),
        ("description", escaped(&page.description)),
        ("style", style(&STYLES)),
        ("notes", notes(&page.notes)),
        ("pictures", pictures(&page.pictures)),
        ("data", data),
        ("script", script),
    ];
    filled(TEMPLATE, &fields)
}

/// How points became what is seen.
fn note(volumes: &[Volume]) -> String {
    let Some(first) = volumes.first() else { return String::new() };
    let [l21, phi22, arm] = first.resolution();
    let all = format!("{l21} × {phi22} × {arm} points a volume");
    let digits = "Figures here have seven digits; the data file has all.";
    match is_thinned(&first.axes) {
        true => format!(
            "{all}, thinned out to fit a page: some values of each axis, the first and the last among them. Shares here are of \
             the points shown; the tables below count all. {digits}"
        ),
        false => format!("{all}, all of them here. {digits}"),
    }
}
