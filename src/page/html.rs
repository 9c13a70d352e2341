//! Assembles a page from assets, texts and data; escapes all input.

use super::{Note, Page, Picture};
use crate::format::{Report, escape_markup, is_unsafe_char};
use crate::plot::theme::variables;
use phalanx_show::playback::json;

const TEMPLATE: &str = include_str!("assets/page.html");
const STYLES: [&str; 2] = [include_str!("assets/texts.css"), include_str!("assets/layout.css")];
/// Scripts of the playback viewer, in order of dependence; all share one scope.
pub(super) const VIEWER_SCRIPTS: [&str; 21] = [
    include_str!("assets/format.js"),
    include_str!("assets/data.js"),
    include_str!("assets/interpolation.js"),
    include_str!("assets/clock.js"),
    include_str!("assets/axis.js"),
    include_str!("assets/canvas.js"),
    include_str!("assets/svg_context.js"),
    include_str!("assets/camera.js"),
    include_str!("assets/shapes.js"),
    include_str!("assets/symbols.js"),
    include_str!("assets/stage.js"),
    include_str!("assets/plots.js"),
    include_str!("assets/events.js"),
    include_str!("assets/gif.js"),
    include_str!("assets/animation.js"),
    include_str!("assets/save.js"),
    include_str!("assets/controls.js"),
    include_str!("assets/help.js"),
    include_str!("assets/keys.js"),
    include_str!("assets/viewer.js"),
    include_str!("assets/hooks.js"),
];
const MAIN_SCRIPT: &str = include_str!("assets/main.js");

/// Renders the page. Equal contents give equal bytes.
pub fn render_page(page: &Page) -> String {
    let json = escape_for_script(&json::to_json(&page.runs));
    let PageScript { nonce, script } = PageScript::new(&json, &[&VIEWER_SCRIPTS[..], &[MAIN_SCRIPT]].concat());
    let fields = [
        ("nonce", nonce),
        ("title", escape_markup(&page.title)),
        ("description", description_html(&page.description)),
        ("style", page_style(&STYLES)),
        ("summaries", summaries_html(page)),
        ("notes", notes_html(&page.notes)),
        ("pictures", pictures_html(&page.pictures)),
        ("data", json),
        ("script", script),
    ];
    fill_template(TEMPLATE, &fields)
}

/// Concatenates the colours, the common style sheet and the style sheets of a page.
pub(super) fn page_style(page_sheets: &[&str]) -> String {
    [&variables(), include_str!("assets/theme.css"), &page_sheets.concat()].concat()
}

/// The script of a page and the nonce that allows it to run.
pub(super) struct PageScript {
    pub nonce: String,
    pub script: String,
}

impl PageScript {
    /// Wraps the parts in one function scope.
    pub fn new(data: &str, parts: &[&str]) -> Self {
        Self {
            // Scripts without the nonce do not run, so injected ones are blocked.
            nonce: format!("{:08x}", crc32fast::hash(data.as_bytes())),
            script: format!("(() => {{\n\"use strict\";\n{}}})();\n", parts.concat()),
        }
    }
}

/// Replaces every `{{name}}` in a template. Inserted values are not expanded again.
pub(super) fn fill_template(template: &str, fields: &[(&str, String)]) -> String {
    let mut parts = template.split("{{");
    let mut text = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let (name, rest) = part.split_once("}}").expect("every placeholder of the template is closed");
        let (_, value) =
            fields.iter().find(|field| field.0 == name).expect("every placeholder of the template has a field");
        text.push_str(value);
        text.push_str(rest);
    }
    text
}

/// Escapes JSON for a script element: it cannot contain the end of the element or the start of a comment.
pub(super) fn escape_for_script(json: &str) -> String {
    let mut out = String::with_capacity(json.len());
    for c in json.chars() {
        match c {
            '<' | '>' | '&' => out.push_str(&format!("\\u{:04x}", u32::from(c))),
            // JSON allows other characters above 127 unescaped.
            c if is_unsafe_char(c) || c.is_control() => out.push_str(&format!("\\u{:04x}", u32::from(c))),
            other => out.push(other),
        }
    }
    out
}

fn description_html(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("<p class=\"description\">{}</p>", escape_markup(text)) }
}

/// Sections with the summaries of the runs.
fn summaries_html(page: &Page) -> String {
    let runs = page.runs.iter().filter(|playback| !playback.summary.is_empty());
    runs.map(|playback| section(&format!("Summary: {}", playback.label), &playback.summary)).collect()
}

pub(super) fn notes_html(notes: &[Note]) -> String {
    notes.iter().map(|note| section(&note.title, &note.text)).collect()
}

/// A section of text and tables; wide tables scroll horizontally.
fn section(title: &str, body: &Report) -> String {
    format!("<section class=\"text\"><h2>{}</h2>\n{}</section>\n", escape_markup(title), body.html(title))
}

pub(super) fn pictures_html(pictures: &[Picture]) -> String {
    let picture = |picture: &Picture| {
        let title = escape_markup(&picture.title);
        format!(
            "<section class=\"picture\"><h2>{title}</h2><div class=\"sheet\" tabindex=\"0\" role=\"img\" aria-label=\"{title}\">{}</div></section>\n",
            picture.svg
        )
    };
    pictures.iter().map(picture).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn input_is_never_read_as_markup_or_placeholder() {
        assert_eq!(escape_markup("<b a=\"1\" c='2'>&\0"), "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;\u{fffd}");
        assert_eq!(escape_for_script("</script><!--&"), "\\u003c/script\\u003e\\u003c!--\\u0026");
        let fields = [("a", "{{b}} {{".to_string()), ("b", "2".to_string())];
        assert_eq!(fill_template("1 {{a}} {{b}}.", &fields), "1 {{b}} {{ 2.");
    }
}
