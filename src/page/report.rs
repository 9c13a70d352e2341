//! The page of a report: a self-contained file with light and dark colours.

use super::html::{fill_template, page_style};
use crate::format::{Report, escape_markup};

const TEMPLATE: &str = include_str!("assets/report/page.html");
const STYLE: &str = include_str!("assets/report/report.css");
/// Selects light or dark colours: the system's preference at first, then by a button.
const SCRIPT: &str = include_str!("assets/report/report.js");

/// Renders the page, whose content security policy forbids external sources. Equal reports give equal bytes.
pub fn report_page(report: &Report) -> String {
    let entry =
        |(index, heading): (usize, &str)| format!("<li><a href=\"#s{index}\">{}</a></li>\n", escape_markup(heading));
    let fields = [
        ("nonce", format!("{:08x}", crc32fast::hash(SCRIPT.as_bytes()))),
        ("title", escape_markup(&report.title)),
        ("style", page_style(&[STYLE])),
        ("contents", report.headings().enumerate().map(entry).collect()),
        ("report", report.html(&report.title)),
        ("script", SCRIPT.to_string()),
    ];
    fill_template(TEMPLATE, &fields)
}
