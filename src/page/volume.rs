//! The page of grasp-state volumes: a self-contained file that shows them in three dimensions.

use super::Note;
use super::html::{PageScript, escape_for_script, fill_template, notes_html, page_style};
use crate::format::escape_markup;

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

/// Renders the page with the volumes as a JSON document ([`page_data`](crate::thesis::volume::page_data)). Equal
/// contents give equal bytes.
pub(crate) fn volume_page(title: &str, description: &str, data: &str, notes: &[Note]) -> String {
    let data = escape_for_script(data);
    let PageScript { nonce, script } = PageScript::new(&data, &SCRIPTS);
    let fields = [
        ("nonce", nonce),
        ("title", escape_markup(title)),
        ("description", escape_markup(description)),
        ("style", page_style(&STYLES)),
        ("notes", notes_html(notes)),
        ("data", data),
        ("script", script),
    ];
    fill_template(TEMPLATE, &fields)
}
