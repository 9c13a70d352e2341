//! Assembles a page from assets, texts and data; escapes all input.

use super::{Note, Page, Picture, Playback};
use crate::format::{Report, escape_chars, escape_markup, is_unsafe_char};
use crate::plot::theme::variables;
use phalanx_show::playback::json;

/// Texts of the scripts of these names.
macro_rules! scripts {
    ($($name:literal),*) => { [$(include_str!(concat!("assets/", $name, ".js"))),*] };
}
pub(super) use scripts;

const TEMPLATE: &str = include_str!("assets/page.html");
const STYLES: [&str; 2] = [include_str!("assets/texts.css"), include_str!("assets/layout.css")];
/// Scripts of the playback viewer, in order of dependence; all share one scope.
pub(super) const VIEWER_SCRIPTS: [&str; 22] = scripts! {
    "format", "data", "interpolation", "clock", "axis", "canvas", "states", "svg_context", "camera", "shapes", "symbols",
    "stage", "plots", "events", "gif", "animation", "save", "controls", "help", "keys", "viewer", "hooks"
};
const MAIN_SCRIPT: &str = include_str!("assets/main.js");

/// Renders the page. The same contents give the same bytes.
pub fn render_page(page: &Page) -> String {
    let fields = vec![
        ("title", escape_markup(&page.title)),
        ("description", description_html(&page.description)),
        ("style", page_style(&STYLES)),
        ("answers", answers_html(&page.runs)),
        ("summaries", summaries_html(page)),
        ("notes", notes_html(&page.notes)),
        ("pictures", pictures_html(&page.pictures)),
    ];
    let scripts = [&VIEWER_SCRIPTS[..], &[MAIN_SCRIPT]].concat();
    fill_scripted_template(TEMPLATE, &json::to_json(&page.runs), &scripts, fields)
}

/// A page with one picture.
pub(crate) fn picture_page(title: &str, svg: &str) -> String {
    let title = escape_markup(title);
    format!(
        "<!DOCTYPE html>\n<meta charset=\"utf-8\">\n<meta name=\"generator\" content=\"phalanx\">\n<title>{title}</title>\n{svg}"
    )
}

/// Selects light or dark colours: the system's preference at first, then by a button.
const REPORT_SCRIPT: &str = include_str!("assets/report/report.js");

/// Renders the page of a report, such as a reproduction, with light and dark colours. Its content security policy
/// forbids external sources. The same report gives the same bytes.
pub fn report_page(report: &Report) -> String {
    let entry =
        |(index, heading): (usize, &str)| format!("<li><a href=\"#s{index}\">{}</a></li>\n", escape_markup(heading));
    let fields = [
        ("nonce", format!("{:08x}", crc32fast::hash(REPORT_SCRIPT.as_bytes()))),
        ("title", escape_markup(&report.title)),
        ("style", page_style(&[include_str!("assets/report/report.css")])),
        ("contents", report.headings().enumerate().map(entry).collect()),
        ("report", report.html(&report.title)),
        ("script", REPORT_SCRIPT.to_string()),
    ];
    fill_template(include_str!("assets/report/page.html"), &fields)
}

/// Concatenates the colours, the common style sheet and the style sheets of a page.
pub(super) fn page_style(page_sheets: &[&str]) -> String {
    [&variables(), include_str!("assets/theme.css"), &page_sheets.concat()].concat()
}

/// Fills the template of a page that shows `data` (JSON). Its scripts are wrapped in one function scope.
pub(super) fn fill_scripted_template(
    template: &str,
    data: &str,
    scripts: &[&str],
    mut fields: Vec<(&str, String)>,
) -> String {
    let data = escape_for_script(data);
    // Scripts without the nonce do not run, so injected ones are blocked.
    fields.push(("nonce", format!("{:08x}", crc32fast::hash(data.as_bytes()))));
    fields.push(("script", format!("(() => {{\n\"use strict\";\n{}}})();\n", scripts.concat())));
    fields.push(("data", data));
    fill_template(template, &fields)
}

/// Replaces every `{{name}}` in a template. Inserted values are not expanded again.
fn fill_template(template: &str, fields: &[(&str, String)]) -> String {
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
fn escape_for_script(json: &str) -> String {
    // JSON allows other characters above 127 unescaped.
    escape_chars(json, |c| matches!(c, '<' | '>' | '&') || is_unsafe_char(c) || c.is_control()).into_owned()
}

fn description_html(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("<p class=\"description\">{}</p>", escape_markup(text)) }
}

/// The answers of the grasps, each with the label of its run if there are several.
fn answers_html(runs: &[Playback]) -> String {
    let label = |run: &Playback| match runs.len() {
        1 => String::new(),
        _ => format!("<span class=\"soft\">{}:</span> ", escape_markup(&run.label)),
    };
    let answer = |run: &Playback| {
        let answer = escape_markup(&run.grasp.as_ref()?.answer);
        Some(format!("<p class=\"answer\">{}{answer}</p>\n", label(run)))
    };
    runs.iter().filter_map(answer).collect()
}

/// Sections with the summaries of the runs.
fn summaries_html(page: &Page) -> String {
    let runs = page.runs.iter().filter(|playback| !playback.summary.is_empty());
    runs.map(|playback| section(&format!("Summary: {}", playback.label), &playback.summary)).collect()
}

fn notes_html(notes: &[Note]) -> String {
    notes.iter().map(|note| section(&note.title, &note.text)).collect()
}

/// A section of text and tables; wide tables scroll horizontally.
fn section(title: &str, body: &Report) -> String {
    format!("<section class=\"text\"><h2>{}</h2>\n{}</section>\n", escape_markup(title), body.html(title))
}

fn pictures_html(pictures: &[Picture]) -> String {
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
