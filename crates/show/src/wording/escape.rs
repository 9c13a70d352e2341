//! Text of others within a page or a picture.

/// Whether a terminal or a reader obeys a character instead of showing it: controls, ends of lines other than `\n`, and those that turn
/// the order of letters around.
pub fn acts(c: char) -> bool {
    let bidi = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    bidi || matches!(c, '\u{2028}' | '\u{2029}') || c.is_control() && !matches!(c, '\n' | '\t')
}

/// Text between tags or in an attribute with quotes.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // HTML knows no controls, and parsers differ in what they put there.
            c if acts(c) => out.push('\u{fffd}'),
            other => out.push(other),
        }
    }
    out
}
