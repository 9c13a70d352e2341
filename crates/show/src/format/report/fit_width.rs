//! Fits tables to a width.
//!
//! Headers and long names in the first column are wrapped first. If that does not suffice, columns are split into
//! groups below each other, and each group repeats the key columns. Numbers are never split.

use super::plain;
use super::wrap::{char_count, longest_word, wrap_line};
use super::{Cell, Table};

/// Spaces between two columns.
const GAP: usize = 2;

/// Indentation of continuation lines of a name.
const HANGING_INDENT: usize = 2;

/// Natural and minimum width of a column.
#[derive(Clone, Copy, Debug)]
struct Column {
    natural_width: usize,
    min_width: usize,
}

pub(super) fn table(table: &Table, width: usize) -> String {
    let plain = plain::table(&table.rows);
    if plain.lines().all(|line| char_count(line) <= width) {
        return plain;
    }
    let columns = measure_columns(table, width);
    let groups = group_columns(table, &columns, width);
    let blocks: Vec<String> = groups.iter().map(|group| format_group(table, &columns, group, width)).collect();
    blocks.join("\n")
}

/// Whether the row is a heading of the rows below it.
fn is_heading(row: &[Cell]) -> bool {
    row.len() == 1
}

fn measure_columns(table: &Table, width: usize) -> Vec<Column> {
    let count = table.columns();
    let cells = |column: usize| {
        let rows = table.rows.iter().enumerate().filter(|(_, row)| !is_heading(row));
        rows.filter_map(move |(index, row)| Some((index < table.header_rows, row.get(column)?.as_ref())))
    };
    let natural_width = |column: usize| cells(column).map(|(_, cell)| char_count(cell)).max().unwrap_or(0);
    let mut columns: Vec<Column> = Vec::with_capacity(count);
    for column in 0..count {
        let natural_width = natural_width(column);
        let wrapped_width = cells(column).map(|(_, cell)| min_cell_width(cell, column == 0)).max().unwrap_or(0);
        let unwrapped_width =
            cells(column).map(|(head, cell)| if head { longest_word(cell) } else { char_count(cell) }).max();
        let min_width = match columns.first() {
            // The first column leaves space for others.
            None => natural_width.min(wrapped_width.max(width * 2 / 5)),
            // Cells other than headers are wrapped only if they would not fit otherwise.
            Some(first) => unwrapped_width
                .filter(|unwrapped_width| first.min_width + GAP + unwrapped_width <= width)
                .unwrap_or(wrapped_width),
        };
        columns.push(Column { natural_width, min_width });
    }
    columns
}

/// Minimum width of a cell.
fn min_cell_width(cell: &str, first: bool) -> usize {
    let trimmed = cell.trim_start();
    let indent = char_count(cell) - char_count(trimmed);
    let hanging_indent = if first && trimmed.contains(' ') { HANGING_INDENT } else { 0 };
    longest_word(trimmed) + indent + hanging_indent
}

/// Splits the columns after the key columns into as few groups as possible, with widths as equal as possible.
fn group_columns(table: &Table, columns: &[Column], width: usize) -> Vec<Vec<usize>> {
    let keys = table.key_columns.min(columns.len());
    let min_width = |columns: &[Column]| columns.iter().map(|column| column.min_width + GAP).sum::<usize>();
    let key_width = min_width(&columns[..keys]).saturating_sub(GAP);
    let pack_columns = |width: usize| {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        let mut used = usize::MAX;
        for (pack, members) in columns[keys..].chunks(table.columns_per_group.max(1)).enumerate() {
            let first = keys + pack * table.columns_per_group.max(1);
            let (pack, needs) = (first..first + members.len(), min_width(members));
            match groups.last_mut() {
                Some(group) if used.saturating_add(needs) <= width => {
                    group.extend(pack);
                    used += needs;
                }
                _ => {
                    groups.push(pack.collect());
                    used = key_width + needs;
                }
            }
        }
        groups
    };
    let mut best = pack_columns(width);
    for narrower in (0..width).rev() {
        let groups = pack_columns(narrower);
        if groups.len() > best.len() {
            break;
        }
        best = groups;
    }
    if best.is_empty() { vec![Vec::new()] } else { best }
}

/// Formats one group of columns with the keys.
fn format_group(table: &Table, columns: &[Column], group: &[usize], width: usize) -> String {
    let columns_shown: Vec<usize> = (0..table.key_columns.min(columns.len())).chain(group.iter().copied()).collect();
    let column_widths = column_widths(table, columns, &columns_shown, width);
    let mut text = String::new();
    for (index, row) in table.rows.iter().enumerate() {
        if is_heading(row) {
            wrap_line(row[0].as_ref(), width, HANGING_INDENT).iter().for_each(|line| text.extend([line, "\n"]));
            continue;
        }
        let cells: Vec<Vec<String>> = columns_shown
            .iter()
            .zip(&column_widths)
            .map(|(&column, &width)| wrap_cell(row.get(column).map_or("", AsRef::as_ref), column == 0, width))
            .collect();
        let height = cells.iter().map(Vec::len).max().unwrap_or(1);
        for line in 0..height {
            // Headers are aligned at the bottom, other cells at the top.
            let cell_line = |cell: &Vec<String>| match index < table.header_rows {
                true => (line + cell.len()).checked_sub(height),
                false => Some(line),
            };
            let cell_text =
                |cell: &Vec<String>| cell_line(cell).and_then(|line| cell.get(line)).cloned().unwrap_or_default();
            let line: Vec<String> = cells.iter().map(cell_text).collect();
            text.push_str(&plain::line(&line, &column_widths));
            text.push('\n');
        }
    }
    text
}

fn wrap_cell(cell: &str, first: bool, width: usize) -> Vec<String> {
    let indent = cell.len() - cell.trim_start().len();
    let lines = wrap_line(cell, width, if first { indent + HANGING_INDENT } else { 0 });
    if first { lines } else { lines.iter().map(|line| line.trim().to_string()).collect() }
}

/// Assigns widths to the columns: spare width goes to the names first, then to the columns with the tallest headers.
fn column_widths(table: &Table, columns: &[Column], columns_shown: &[usize], width: usize) -> Vec<usize> {
    let mut column_widths: Vec<usize> = columns_shown.iter().map(|&column| columns[column].min_width).collect();
    let mut spare_width = width.saturating_sub(column_widths.iter().sum::<usize>() + GAP * (columns_shown.len() - 1));
    let names = spare_width.min(columns[0].natural_width - column_widths[0]);
    column_widths[0] += names;
    spare_width -= names;
    let height = |index: usize, width: usize| {
        let cells = table.rows.iter().filter(|row| !is_heading(row)).filter_map(|row| row.get(columns_shown[index]));
        cells.map(|cell| wrap_line(cell.as_ref(), width, 0).len()).max().unwrap_or(1)
    };
    while spare_width > 0 {
        let tallest = (1..columns_shown.len())
            .max_by_key(|&index| (height(index, column_widths[index]), columns_shown.len() - index));
        match tallest {
            Some(index)
                if height(index, column_widths[index]) > 1
                    && column_widths[index] < columns[columns_shown[index]].natural_width =>
            {
                column_widths[index] += 1;
                spare_width -= 1;
            }
            _ => break,
        }
    }
    column_widths
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::numbers::row;

    fn fitted(heads: usize, rows: &[Vec<String>], width: usize) -> String {
        let text = table(&Table::new(rows).header_rows(heads), width);
        let longest = text.lines().map(char_count).max();
        assert!(longest <= Some(width), "{longest:?} of {width}:\n{text}");
        text
    }

    #[test]
    fn wraps_headers_before_splitting_columns_into_groups() {
        let rows = [row(["", "first touch, ms", "peak, N"]), row(["distal", "4.501317", "100.0"])];
        assert_eq!(fitted(1, &rows, 40), "        first touch, ms  peak, N\ndistal         4.501317    100.0\n");
        assert_eq!(
            fitted(1, &rows, 24),
            "            first  peak,\n        touch, ms      N\ndistal   4.501317  100.0\n"
        );
    }

    #[test]
    fn splits_columns_into_groups_that_repeat_the_names() {
        let rows = [row(["place", "run", "design", "force"]), row(["1", "12345678", "12345678", "12345678"])];
        assert_eq!(
            fitted(1, &rows, 26),
            "place       run    design\n1      12345678  12345678\n\nplace     force\n1      12345678\n"
        );
    }

    #[test]
    fn groups_have_equal_widths_and_repeat_headings() {
        let rows = [
            row(["what", "aaaa", "bbbb", "cccc", "dddd"]),
            row(["a family with a long name"]),
            row(["  one", "1", "2", "3", "4"]),
        ];
        assert_eq!(
            fitted(1, &rows, 25),
            "what   aaaa  bbbb\na family with a long name\n  one     1     2\n\nwhat   cccc  dddd\na family with a long name\n  one     3     4\n"
        );
    }

    #[test]
    fn repeats_all_key_columns_and_does_not_separate_packs() {
        let rows =
            [row(["law", "step", "a", "max", "b", "max"]), row(["step", "1.00", "1111", "2222", "3333", "4444"])];
        let text = table(&Table::new(&rows).key_columns(2).columns_per_group(2), 26);
        assert_eq!(
            text,
            "law   step     a   max\nstep  1.00  1111  2222\n\nlaw   step     b   max\nstep  1.00  3333  4444\n"
        );
    }

    #[test]
    fn aligns_numbers_with_the_first_line_of_wrapped_names() {
        let rows = [row(["bound", "limit"]), row(["a bound of many words", "0.001"])];
        assert_eq!(fitted(1, &rows, 20), "bound          limit\na bound of     0.001\n  many words\n");
    }

    #[test]
    fn never_splits_numbers() {
        let rows = [row(["name", "value"]), row(["a", "1.23456789"])];
        let text = table(&Table::new(&rows), 5);
        assert!(text.contains("1.23456789"), "{text}");
    }
}
