//! Wraps lines to a width. Words are never split, so that paths can be copied.

/// Indentation of continuation lines.
const HANGING_INDENT: usize = 2;

/// Maximum width of a label at the beginning of a line; the text after a label is indented to its right.
const MAX_LABEL_WIDTH: usize = 16;

pub(super) fn char_count(text: &str) -> usize {
    text.chars().count()
}

pub(super) fn longest_word(text: &str) -> usize {
    split_words(text).iter().map(|word| char_count(word)).max().unwrap_or(0)
}

/// Units that are not separated from their number.
const UNITS: [&str; 29] = [
    "s",
    "ms",
    "µs",
    "ns",
    "m",
    "mm",
    "µm",
    "g",
    "kg",
    "N",
    "mN",
    "N·m",
    "N·mm",
    "mN·s",
    "mN·m·s",
    "N·s/m",
    "N/m^e",
    "J",
    "mJ",
    "rad",
    "µrad",
    "deg",
    "rad/s",
    "mm/s",
    "m/s",
    "m/s²",
    "N·mm/rad",
    "Hz",
    "%",
];

/// Whether two words must be on the same line: a number and its unit.
fn must_stay_together(before: &str, after: &str) -> bool {
    let number = before.trim_matches(['(', ')', ',']);
    let unit = after.trim_end_matches([',', ';', '.', ':', ')']);
    number.parse::<f64>().is_ok() && UNITS.contains(&unit)
}

/// Splits a line where it may be wrapped.
fn split_words(line: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut before = "";
    for word in line.split(' ') {
        match words.last_mut() {
            Some(last) if must_stay_together(before, word) => last.extend([" ", word]),
            _ => words.push(word.to_string()),
        }
        before = word;
    }
    words
}

/// Wraps every line of a text separately.
pub(super) fn lines(text: &str, width: usize) -> String {
    text.split_inclusive('\n')
        .map(|line| {
            let (line, end) = line.strip_suffix('\n').map_or((line, ""), |line| (line, "\n"));
            wrap_line(line, width, hanging_indent(line)).join("\n") + end
        })
        .collect()
}

/// Joins the lines of a paragraph and wraps it.
pub(super) fn paragraph(text: &str, width: usize) -> String {
    let indent = text.len() - text.trim_start_matches('\n').len();
    let joined = text.trim_matches('\n').replace('\n', " ");
    format!("{}{}\n", &text[..indent], wrap_line(&joined, width, 0).join("\n"))
}

/// Wraps one line; continuation lines are indented by `hanging_indent`.
pub(super) fn wrap_line(line: &str, width: usize, hanging_indent: usize) -> Vec<String> {
    if char_count(line) <= width {
        return vec![line.to_string()];
    }
    // No indentation if the column is too narrow for it.
    let hanging_indent = if hanging_indent + longest_word(line) > width { 0 } else { hanging_indent };
    let indent = line.len() - line.trim_start_matches(' ').len();
    let mut lines = Vec::new();
    let mut current = line[..indent].to_string();
    let mut empty = true;
    for word in split_words(&line[indent..]) {
        if !empty && char_count(&current) + 1 + char_count(&word) > width {
            lines.push(std::mem::replace(&mut current, " ".repeat(hanging_indent)).trim_end().to_string());
            empty = true;
        }
        // Spaces for alignment are dropped at the beginning of a continuation line.
        if word.is_empty() && empty && !lines.is_empty() {
            continue;
        }
        if !empty {
            current.push(' ');
        }
        current.push_str(&word);
        empty = false;
    }
    lines.push(current.trim_end().to_string());
    lines
}

/// Indentation of continuation lines: the column of the text after a label, or [`HANGING_INDENT`] more than the first
/// line.
fn hanging_indent(line: &str) -> usize {
    let indent = line.len() - line.trim_start_matches(' ').len();
    let rest = &line[indent..];
    match rest.find("  ") {
        Some(label) if char_count(&rest[..label]) <= MAX_LABEL_WIDTH => {
            let gap = rest[label..].len() - rest[label..].trim_start_matches(' ').len();
            indent + char_count(&rest[..label]) + gap
        }
        _ => indent + HANGING_INDENT,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wraps_between_words_and_indents_continuation_lines() {
        assert_eq!(lines("one two three\nfour\n", 9), "one two\n  three\nfour\n");
        assert_eq!(lines("a b", 80), "a b");
        assert_eq!(
            lines("engine:   fixed steps of 1 µs\n", 20),
            "engine:   fixed\n          steps of\n          1 µs\n"
        );
        assert_eq!(lines("  12 runs, such as one\n", 14), "  12 runs,\n    such as\n    one\n");
        assert_eq!(lines("in: /a/rather/long/path b\n", 8), "in:\n/a/rather/long/path\nb\n");
        assert_eq!(lines("of 20 ms, up\n", 6), "of\n20 ms,\nup\n");
        assert_eq!(paragraph("\none two\nthree\n", 10), "\none two\nthree\n");
        assert_eq!(paragraph("one two\nthree\n", 20), "one two three\n");
    }
}
