//! The file: assets, texts and data put together, everything foreign escaped.

use std::fmt::Write;

use super::{Note, Page, Picture};
use crate::plot::theme::variables;
use crate::wording::{Report, acts, escaped};
use phalanx_show::film::data;

const TEMPLATE: &str = include_str!("assets/page.html");
const STYLES: [&str; 2] = [include_str!("assets/texts.css"), include_str!("assets/layout.css")];
/// What shows films, on any page that does. In the order of their dependence; they share one scope.
pub(super) const VIEWER: [&str; 21] = [
    include_str!("assets/format.js"),
    include_str!("assets/data.js"),
    include_str!("assets/reading.js"),
    include_str!("assets/clock.js"),
    include_str!("assets/axis.js"),
    include_str!("assets/canvas.js"),
    include_str!("assets/recorder.js"),
    include_str!("assets/camera.js"),
    include_str!("assets/shapes.js"),
    include_str!("assets/letters.js"),
    include_str!("assets/stage.js"),
    include_str!("assets/plots.js"),
    include_str!("assets/events.js"),
    include_str!("assets/gif.js"),
    include_str!("assets/movie.js"),
    include_str!("assets/save.js"),
    include_str!("assets/controls.js"),
    include_str!("assets/help.js"),
    include_str!("assets/keys.js"),
    include_str!("assets/viewer.js"),
    include_str!("assets/hooks.js"),
];
const MAIN: &str = include_str!("assets/main.js");

/// The whole file. The same page gives the same bytes.
pub fn page(page: &Page) -> String {
    let data = in_script(&data::json(&page.runs));
    let Script { nonce, script } = Script::new(&data, &[&VIEWER[..], &[MAIN]].concat());
    let fields = [
        ("nonce", nonce),
        ("title", escaped(&page.title)),
        ("description", description(&page.description)),
        ("style", style(&STYLES)),
        ("summaries", summaries(page)),
        ("notes", notes(&page.notes)),
        ("pictures", pictures(&page.pictures)),
        ("data", data),
        ("script", script),
    ];
    filled(TEMPLATE, &fields)
}

/// The style sheets of a page behind those of all: colours first.
pub(super) fn style(own: &[&str]) -> String {
    [&variables(), include_str!("assets/theme.css"), &own.concat()].concat()
}

/// The script of a page and the nonce that lets it run.
pub(super) struct Script {
    pub nonce: String,
    pub script: String,
}

impl Script {
    /// Parts in one scope of their own.
    pub fn new(data: &str, parts: &[&str]) -> Self {
        Self {
            // Scripts of the page carry it; what else might pass for one does not, and is not run.
            nonce: format!("{:08x}", crc32fast::hash(data.as_bytes())),
            script: format!("(() => {{\n\"use strict\";\n{}}})();\n", parts.concat()),
        }
    }
}

/// The template with every `{{name}}` in it replaced; what is put in is not looked at again.
pub(super) fn filled(template: &str, fields: &[(&str, String)]) -> String {
    let mut parts = template.split("{{");
    let mut text = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let (name, rest) = part.split_once("}}").expect("every mark of the template is closed");
        let (_, value) = fields.iter().find(|field| field.0 == name).expect("every mark of the template has a field");
        text.push_str(value);
        text.push_str(rest);
    }
    text
}

/// JSON within a script element: nothing in it may look like the end of the element or the start of a comment.
pub(super) fn in_script(json: &str) -> String {
    let mut out = String::with_capacity(json.len());
    for c in json.chars() {
        match c {
            '<' | '>' | '&' => out.push_str(&format!("\\u{:04x}", u32::from(c))),
            // JSON takes those above 127 as they are.
            c if acts(c) || c.is_control() => out.push_str(&format!("\\u{:04x}", u32::from(c))),
            other => out.push(other),
        }
    }
    out
}

fn description(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("<p class=\"description\">{}</p>", escaped(text)) }
}

/// What each run says of itself.
fn summaries(page: &Page) -> String {
    let mut text = String::new();
    for film in page.runs.iter().filter(|film| !film.summary.is_empty()) {
        section(&mut text, &format!("Summary: {}", film.label), &film.summary);
    }
    text
}

pub(super) fn notes(notes: &[Note]) -> String {
    let mut text = String::new();
    for note in notes {
        section(&mut text, &note.title, &note.text);
    }
    text
}

/// Words and tables under a heading; wide tables scroll within boxes of their own.
fn section(out: &mut String, title: &str, body: &Report) {
    let (title, body) = (escaped(title), body.html(title));
    // Writing to a string cannot fail.
    let _ = writeln!(out, "<section class=\"text\"><h2>{title}</h2>\n{body}</section>");
}

pub(super) fn pictures(pictures: &[Picture]) -> String {
    let mut text = String::new();
    for picture in pictures {
        let title = escaped(&picture.title);
        let _ = writeln!(
            text,
            "<section class=\"picture\"><h2>{title}</h2><div class=\"sheet\" tabindex=\"0\" role=\"img\" aria-label=\"{title}\">{}</div></section>",
            picture.svg
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_foreign_is_read_as_markup_or_as_a_mark_of_the_template() {
        assert_eq!(escaped("<b a=\"1\" c='2'>&\0"), "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;\u{fffd}");
        assert_eq!(in_script("</script><!--&"), "\\u003c/script\\u003e\\u003c!--\\u0026");
        let fields = [("a", "{{b}} {{".to_string()), ("b", "2".to_string())];
        assert_eq!(filled("1 {{a}} {{b}}.", &fields), "1 {{b}} {{ 2.");
    }
}
