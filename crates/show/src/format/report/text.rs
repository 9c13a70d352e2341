//! A report as plain text, unwrapped or wrapped to a width.

use comfy_table::{Cell as TextCell, CellAlignment, ColumnConstraint, ContentArrangement, TableStyle, Width};
use textwrap::{Options, WordSeparator, WordSplitter, WrapAlgorithm, core::display_width};

use super::{Block, Report, Table};
use crate::scene::one_line;

/// Spaces between two columns.
const GAP: usize = 2;
/// Additional indentation of the continuation of a line.
const HANGING_INDENT: usize = 2;

/// Formats a report; a figure is represented by its file name and caption.
pub(super) fn report(report: &Report, width: Option<usize>) -> String {
    let lines =
        |content: &str| content.split_inclusive('\n').map(|line| wrap_line(line, width, HANGING_INDENT)).collect();
    let render = |block: &Block| match block {
        Block::Heading(heading) => lines(&format!("\n{}\n\n", one_line(heading))),
        Block::Lines(content) => lines(content),
        Block::Paragraph(content) => paragraph(content, width),
        Block::Notes(notes) => notes.iter().map(|note| lines(&format!("- {}\n", one_line(note)))).collect(),
        Block::Table(item) if item.caption.is_empty() => table(item, width),
        Block::Table(item) => lines(&format!("{}\n", one_line(&item.caption))) + &table(item, width),
        Block::Figure(figure) => lines(&format!("{}: {}\n", figure.file, one_line(&figure.caption))),
    };
    report.blocks.iter().map(render).collect()
}

/// Formats a paragraph. If it is wrapped, its lines are joined first.
fn paragraph(content: &str, width: Option<usize>) -> String {
    let text = content.strip_suffix('\n').unwrap_or(content);
    let first = text.len() - text.trim_start_matches('\n').len();
    match width {
        Some(_) => text[..first].to_string() + &wrap_line(&text[first..].replace('\n', " "), width, 0) + "\n",
        None => format!("{text}\n"),
    }
}

/// Wraps a line between words. A number stays with the next word, which may be its unit.
fn wrap_line(line: &str, width: Option<usize>, hanging_indent: usize) -> String {
    let (line, end) = line.strip_suffix('\n').map_or((line, ""), |line| (line, "\n"));
    let Some(width) = width.filter(|width| display_width(line) > *width) else { return format!("{line}{end}") };
    let is_number = |word: &str| word.trim_matches(['(', ',']).parse::<f64>().is_ok();
    let mut unbroken = String::with_capacity(line.len());
    for word in line.split(' ') {
        unbroken.extend([word, if is_number(word) { "\u{a0}" } else { " " }]);
    }
    let indent = " ".repeat(line.len() - line.trim_start_matches(' ').len() + hanging_indent);
    let options = Options::new(width)
        .break_words(false)
        .subsequent_indent(&indent)
        .word_separator(WordSeparator::AsciiSpace)
        .word_splitter(WordSplitter::NoHyphenation)
        .wrap_algorithm(WrapAlgorithm::FirstFit);
    textwrap::wrap(unbroken.trim_end(), options).join("\n").replace('\u{a0}', " ") + end
}

/// Formats a table. If it is too wide, cells are wrapped; if that does not suffice, columns are split into groups below
/// each other, and each group repeats the key columns. Words and numbers are never split.
fn table(table: &Table, width: Option<usize>) -> String {
    let columns: Vec<usize> = (0..table.columns()).collect();
    let natural = grid(table, &columns, None);
    match width {
        Some(width) if natural.lines().any(|line| display_width(line) > width) => {
            let groups = column_groups(table, width);
            groups.iter().map(|group| grid(table, group, Some(width))).collect::<Vec<_>>().join("\n")
        }
        _ => natural,
    }
}

/// Smallest width of a column: its longest word.
fn min_width(table: &Table, column: usize) -> usize {
    let words = table.rows.iter().filter_map(|row| row.get(column)).flat_map(|cell| cell.text.split(' '));
    words.map(display_width).max().unwrap_or(0)
}

/// Splits the columns after the key columns into as few groups as possible.
fn column_groups(table: &Table, width: usize) -> Vec<Vec<usize>> {
    let keys: Vec<usize> = (0..table.key_columns.min(table.columns())).collect();
    let others: Vec<usize> = (keys.len()..table.columns()).collect();
    let width_of = |columns: &[usize]| columns.iter().map(|column| min_width(table, *column) + GAP).sum::<usize>();
    let mut groups = vec![keys.clone()];
    for pack in others.chunks(table.columns_per_group.max(1)) {
        let last = &groups[groups.len() - 1];
        if last.len() > keys.len() && width_of(last) + width_of(pack) > width + GAP {
            groups.push(keys.clone());
        }
        groups.last_mut().expect("at least one group").extend(pack);
    }
    groups
}

/// Formats some columns of a table, in their natural width or within a width.
fn grid(table: &Table, columns: &[usize], width: Option<usize>) -> String {
    let mut grid = comfy_table::Table::new();
    let cell =
        |row: &[super::Cell], column: usize| TextCell::new(one_line(row.get(column).map_or("", |cell| &cell.text)));
    grid.load_style(TableStyle::new());
    grid.add_rows(table.rows.iter().map(|row| columns.iter().map(|column| cell(row, *column)).collect::<Vec<_>>()));
    if let Some(width) = width {
        grid.set_content_arrangement(ContentArrangement::Dynamic).set_width(width as u16);
    }
    for (index, column) in columns.iter().enumerate() {
        let gap = if index > 0 { GAP as u16 } else { 0 };
        let is_text = table.is_text_column(*column);
        if let Some(formatted) = grid.column_mut(index) {
            formatted.set_padding((gap, 0));
            formatted.set_cell_alignment(if is_text { CellAlignment::Left } else { CellAlignment::Right });
            let min_width = min_width(table, *column) as u16 + gap;
            formatted.set_constraint(ColumnConstraint::LowerBoundary(Width::Fixed(min_width)));
        }
    }
    if columns.is_empty() { String::new() } else { grid.trim_fmt() + "\n" }
}

#[cfg(test)]
mod tests {
    use crate::format::numbers::row;
    use crate::format::report::{Report, Table, table};

    #[test]
    fn text_is_unwrapped_or_fits_a_width() {
        let mut report = Report::from("a head of several words\n");
        report.push(table(&[row(["", "µm", "state"]), row(["distal", "2.5", "free"]), row(["tip", "12.5", "fixed"])]));
        report.push(Report::paragraph("a sentence that goes on\nand on for 20 ms\n"));
        let table = "          µm  state\ndistal   2.5  free\ntip     12.5  fixed\n";
        let natural = format!("a head of several words\n{table}a sentence that goes on\nand on for 20 ms\n");
        assert_eq!(report.to_string(), natural);
        assert_eq!(report.to_wrapped_text(80), natural.replace("on\nand", "on and"));
        let narrow = format!("a head of several\n  words\n{table}a sentence that goes\non and on for 20 ms\n");
        assert_eq!(report.to_wrapped_text(20), narrow);
        assert_eq!(Report::paragraph("on for 20 ms").to_wrapped_text(9), "on for\n20 ms\n");
        assert_eq!(Report::from("in: /a/long/path b\n").to_wrapped_text(8), "in:\n  /a/long/path\n  b\n");
    }

    #[test]
    fn wide_tables_wrap_headers_then_repeat_key_columns() {
        let rows = [row(["", "first touch, ms", "peak, N"]), row(["distal", "4.501317", "100.0"])];
        let fitted = |width: usize| Report::from(Table::new(&rows)).to_wrapped_text(width);
        assert_eq!(fitted(40), "        first touch, ms  peak, N\ndistal         4.501317    100.0\n");
        assert!(fitted(24).lines().all(|line| line.chars().count() <= 24), "{}", fitted(24));
        assert_eq!(fitted(24).matches("distal").count(), 1, "{}", fitted(24));
        let rows = [row(["law", "step", "a", "max", "b", "max"]), row(["x", "1.00", "1111", "2222", "3333", "4444"])];
        let table = Table::new(&rows).key_columns(2).columns_per_group(2);
        assert_eq!(
            Report::from(table).to_wrapped_text(22),
            "law  step     a   max\nx    1.00  1111  2222\n\nlaw  step     b   max\nx    1.00  3333  4444\n"
        );
        let text = Report::from(Table::new(&[row(["name", "value"]), row(["a", "1.23456789"])])).to_wrapped_text(5);
        assert!(text.contains("1.23456789"), "{text}");
    }
}
