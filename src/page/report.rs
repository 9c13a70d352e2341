//! The page of a report: one self-contained file, light and dark, without a network.

use super::html::{filled, style};
use crate::wording::{Report, escaped};

const TEMPLATE: &str = include_str!("assets/report/page.html");
const STYLE: &str = include_str!("assets/report/report.css");
/// Light or dark, as the reader's system has it, and by a button.
const SCRIPT: &str = include_str!("assets/report/report.js");

/// The whole file; its policy forbids everything that is not in it. The same report gives the same bytes.
pub fn report_page(report: &Report) -> String {
    let entry = |(index, heading): (usize, &str)| format!("<li><a href=\"#s{index}\">{}</a></li>\n", escaped(heading));
    let fields = [
        ("nonce", format!("{:08x}", crc32fast::hash(SCRIPT.as_bytes()))),
        ("title", escaped(&report.title)),
        ("style", style(&[STYLE])),
        ("contents", report.headings().enumerate().map(entry).collect()),
        ("report", report.html(&report.title)),
        ("script", SCRIPT.to_string()),
    ];
    filled(TEMPLATE, &fields)
}
