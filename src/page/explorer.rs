//! The explorer: one self-contained file that simulates while its sliders move.

use serde::Serialize;

use super::base85::base85;
use super::html::{Script, VIEWER, filled, in_script, style};
use super::presets::{Preset, presets};
use crate::criteria::{Class, Fate};
use crate::limits::LARGEST_SCENE_BYTES;
use crate::plot::theme::{VERDICTS, variable};
use crate::study::select::CLASSES;
use crate::wording::escaped;

const TEMPLATE: &str = include_str!("assets/explorer/page.html");
const STYLES: [&str; 3] =
    [include_str!("assets/texts.css"), include_str!("assets/layout.css"), include_str!("assets/explorer/layout.css")];
/// Behind what shows films, in the order of their dependence; they share one scope.
const SCRIPTS: [&str; 19] = [
    include_str!("assets/explorer/worker.js"),
    include_str!("assets/explorer/base85.js"),
    include_str!("assets/explorer/line.js"),
    include_str!("assets/explorer/setting.js"),
    include_str!("assets/explorer/range.js"),
    include_str!("assets/explorer/colours.js"),
    include_str!("assets/explorer/fields.js"),
    include_str!("assets/explorer/figures.js"),
    include_str!("assets/explorer/verdict.js"),
    include_str!("assets/explorer/cloud.js"),
    include_str!("assets/explorer/grid.js"),
    include_str!("assets/explorer/map.js"),
    include_str!("assets/explorer/statics.js"),
    include_str!("assets/explorer/tabs.js"),
    include_str!("assets/explorer/link.js"),
    include_str!("assets/explorer/files.js"),
    include_str!("assets/explorer/panel.js"),
    include_str!("assets/explorer/hooks.js"),
    include_str!("assets/explorer/main.js"),
];
/// How a packed file begins.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// What the page opens with.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Start {
    /// What messages call the scene.
    pub file: String,
    /// The scene by itself: it extends no other.
    pub text: String,
    /// Fields that are set in it, and to what.
    pub set: Vec<(String, String)>,
}

impl Start {
    /// The first scene that the page brings along.
    pub fn shipped() -> Self {
        let first = presets().into_iter().next().expect("there are presets");
        Start { file: first.file, text: first.text, set: Vec::new() }
    }
}

#[derive(Serialize)]
struct Data<'a> {
    module: String,
    module_bytes: usize,
    start: &'a Start,
    presets: Vec<Shown<'a>>,
    /// Words of results, from good to bad, and the variable of the one colour that each has.
    inks: Vec<(&'a str, &'a str)>,
    largest_scene_bytes: u64,
    version: &'a str,
}

#[derive(Serialize)]
struct Shown<'a> {
    name: &'a str,
    file: &'a str,
    group: &'a str,
    title: &'a str,
    text: &'a str,
}

/// The colours of words that go from good to bad.
fn inks<'a>(words: &[&'a str]) -> Vec<(&'a str, &'a str)> {
    let colour = |rank: usize| if rank + 1 == words.len() { VERDICTS[VERDICTS.len() - 1] } else { VERDICTS[rank] };
    words.iter().enumerate().map(|(rank, word)| (*word, variable(colour(rank)))).collect()
}

/// Whether these are the bytes of a packed file, as [`explorer_page`] takes a module.
pub fn is_packed(bytes: &[u8]) -> bool {
    bytes.starts_with(&GZIP)
}

/// The whole file, around a module of `crates/explorer` that gzip has packed. The same page gives the same bytes.
pub fn explorer_page(module: &[u8], start: &Start, version: &str) -> String {
    let presets = presets();
    let own = presets.iter().find(|preset| preset.file == start.file);
    let title = own.map_or(&start.file, |preset| &preset.name);
    let data = Data {
        module: base85(module),
        module_bytes: module.len(),
        start,
        presets: presets
            .iter()
            .map(|Preset { name, file, group, title, text }| Shown { name, file, group, title, text })
            .collect(),
        inks: [&CLASSES.map(Class::name)[..], &Fate::NAMES, &["yes", "no"]].into_iter().flat_map(inks).collect(),
        largest_scene_bytes: LARGEST_SCENE_BYTES,
        version,
    };
    let data = in_script(&serde_json::to_string(&data).expect("texts can be written"));
    let Script { nonce, script } = Script::new(&data, &[&VIEWER[..], &SCRIPTS].concat());
    let fields = [
        ("nonce", nonce),
        ("title", escaped(title)),
        ("style", style(&STYLES)),
        ("data", data),
        ("script", script),
        ("version", escaped(version)),
    ];
    filled(TEMPLATE, &fields)
}
