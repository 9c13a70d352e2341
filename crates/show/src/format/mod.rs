//! Formats numbers and text for reports, pictures and pages.
//!
//! | file | job |
//! |---|---|
//! | `numbers` | numbers with a given number of digits, durations |
//! | `object` | JSON objects whose keys keep their order |
//! | `report` | paragraphs, tables and figures, rendered as text, Markdown or HTML |

pub mod numbers;
pub mod object;
pub mod report;

pub use numbers::format_duration;
pub use report::{Report, ToReport};

/// Whether a terminal or a viewer interprets a character instead of showing it. Such characters are control characters,
/// line ends other than `\n`, and controls of bidirectional text.
pub fn is_unsafe_char(c: char) -> bool {
    let bidi = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    bidi || matches!(c, '\u{2028}' | '\u{2029}') || c.is_control() && !matches!(c, '\n' | '\t')
}

/// Escapes a text for use between tags or in a quoted attribute.
pub fn escape_markup(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // HTML and XML do not allow these, and parsers replace them differently.
            c if is_unsafe_char(c) || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            other => out.push(other),
        }
    }
    out
}
