//! The explorer: a self-contained page that simulates while its sliders move.

use base64::prelude::{BASE64_STANDARD, Engine};
use serde::Serialize;
use serde_json::json;

use super::html::{VIEWER_SCRIPTS, fill_scripted_template, page_style, scripts};
use super::presets::presets;
use crate::criteria::{Class, Fate};
use crate::format::escape_markup;
use crate::limits::MAX_SCENE_BYTES;
use crate::plot::theme::VERDICTS;

const TEMPLATE: &str = include_str!("assets/explorer/page.html");
const STYLES: [&str; 3] =
    [include_str!("assets/texts.css"), include_str!("assets/layout.css"), include_str!("assets/explorer/layout.css")];
/// Scripts after [`VIEWER_SCRIPTS`], in order of dependence; all share one scope.
const SCRIPTS: [&str; 18] = scripts! {
    "explorer/worker", "explorer/worker_queue", "explorer/scene_settings", "explorer/range", "explorer/colours",
    "explorer/fields", "explorer/figures", "explorer/verdict", "explorer/variations", "explorer/grid",
    "explorer/map", "explorer/statics", "explorer/tabs", "explorer/address", "explorer/files",
    "explorer/page_controls", "explorer/hooks", "explorer/main"
};
/// First bytes of a gzip file.
const GZIP_MAGIC: [u8; 2] = [0x1f, 0x8b];

/// The scene that the page shows first.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub(crate) struct InitialScene {
    /// Name of the scene in messages.
    pub file: String,
    /// Text of the scene, which does not extend another scene.
    pub text: String,
    /// Overridden fields of the scene, with their values.
    pub set: Vec<(String, String)>,
}

impl InitialScene {
    /// Returns the first preset without overridden fields.
    pub(crate) fn first_preset() -> Self {
        let first = presets().into_iter().next().expect("the list of presets is not empty");
        InitialScene { file: first.file, text: first.text, set: Vec::new() }
    }
}

/// Assigns a colour to each of the names of results, which are ordered from good to bad: the best one has the first colour,
/// the worst one the last. Neighbours share colours if there are more names than colours.
fn result_colours<'a>(names: &[&'a str]) -> Vec<(&'a str, &'a str)> {
    let (last, last_colour) = (names.len() - 1, VERDICTS.len() - 1);
    // Rounded to the nearest.
    let colour = |rank: usize| VERDICTS[(2 * rank * last_colour + last) / (2 * last)];
    names.iter().enumerate().map(|(rank, name)| (*name, colour(rank).variable())).collect()
}

/// Whether the bytes are a gzip file, the format in which [`explorer_page`] takes a module.
pub(crate) fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&GZIP_MAGIC)
}

/// Renders the page with a module of `crates/explorer` that is compressed with gzip. Equal arguments give equal bytes.
pub(crate) fn explorer_page(module: &[u8], start: &InitialScene, version: &str) -> String {
    let presets = presets();
    let initial_preset = presets.iter().find(|preset| preset.file == start.file);
    let title = initial_preset.map_or(&start.file, |preset| &preset.name);
    // Names of results, from good to bad, and the CSS variable of the colour of each.
    let names = [&Class::ALL.map(Class::name)[..], &Fate::NAMES, &["yes", "no"]];
    let data = json!({
        "module": BASE64_STANDARD.encode(module),
        "start": start,
        "presets": presets,
        "inks": names.into_iter().flat_map(result_colours).collect::<Vec<_>>(),
        "largest_scene_bytes": MAX_SCENE_BYTES,
        "version": version,
    });
    let fields =
        vec![("title", escape_markup(title)), ("style", page_style(&STYLES)), ("version", escape_markup(version))];
    let scripts = [&VIEWER_SCRIPTS[..], &SCRIPTS].concat();
    fill_scripted_template(TEMPLATE, &data.to_string(), &scripts, fields)
}
