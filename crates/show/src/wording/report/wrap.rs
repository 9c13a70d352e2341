//! Lines of words within a width. Words are never broken: a path stays one that can be copied.

/// What the lines after the first stand in by.
const HANG: usize = 2;

/// A label at the beginning of a line is at most so wide; what follows it stays beside it.
const MOST_LABEL: usize = 16;

pub(super) fn length(text: &str) -> usize {
    text.chars().count()
}

pub(super) fn longest_word(text: &str) -> usize {
    words(text).iter().map(|word| length(word)).max().unwrap_or(0)
}

/// Units that stay on the line of their number.
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

/// Whether a line may not end between two words: a number and its unit.
fn inseparable(before: &str, after: &str) -> bool {
    let number = before.trim_matches(['(', ')', ',']);
    let unit = after.trim_end_matches([',', ';', '.', ':', ')']);
    number.parse::<f64>().is_ok() && UNITS.contains(&unit)
}

/// Words that a line may end after.
fn words(line: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut before = "";
    for word in line.split(' ') {
        match words.last_mut() {
            Some(last) if inseparable(before, word) => last.extend([" ", word]),
            _ => words.push(word.to_string()),
        }
        before = word;
    }
    words
}

/// Every line of a text, wrapped by itself.
pub(super) fn lines(text: &str, width: usize) -> String {
    text.split_inclusive('\n')
        .map(|line| {
            let (line, end) = line.strip_suffix('\n').map_or((line, ""), |line| (line, "\n"));
            line_of(line, width, hang(line)).join("\n") + end
        })
        .collect()
}

/// Sentences that run on over the ends of their lines.
pub(super) fn paragraph(text: &str, width: usize) -> String {
    let indent = text.len() - text.trim_start_matches('\n').len();
    let joined = text.trim_matches('\n').replace('\n', " ");
    format!("{}{}\n", &text[..indent], line_of(&joined, width, 0).join("\n"))
}

/// One line as several: those after the first stand in by `hang`.
pub(super) fn line_of(line: &str, width: usize, hang: usize) -> Vec<String> {
    if length(line) <= width {
        return vec![line.to_string()];
    }
    // A narrow column has no room to stand in by much.
    let hang = if hang + longest_word(line) > width { 0 } else { hang };
    let indent = line.len() - line.trim_start_matches(' ').len();
    let mut lines = Vec::new();
    let mut now = line[..indent].to_string();
    let mut empty = true;
    for word in words(&line[indent..]) {
        if !empty && length(&now) + 1 + length(&word) > width {
            lines.push(std::mem::replace(&mut now, " ".repeat(hang)).trim_end().to_string());
            empty = true;
        }
        // Spaces that line something up have nothing to line up at the beginning of a line.
        if word.is_empty() && empty && !lines.is_empty() {
            continue;
        }
        if !empty {
            now.push(' ');
        }
        now.push_str(&word);
        empty = false;
    }
    lines.push(now.trim_end().to_string());
    lines
}

/// Where the lines after the first begin: beside what follows a label, or a little further in than the first.
fn hang(line: &str) -> usize {
    let indent = line.len() - line.trim_start_matches(' ').len();
    let rest = &line[indent..];
    match rest.find("  ") {
        Some(label) if length(&rest[..label]) <= MOST_LABEL => {
            let gap = rest[label..].len() - rest[label..].trim_start_matches(' ').len();
            indent + length(&rest[..label]) + gap
        }
        _ => indent + HANG,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_between_words_and_go_on_below_what_they_say() {
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
