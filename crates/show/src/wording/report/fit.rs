//! Tables within a width.
//!
//! Heads wrap first, and long names in the first column. Where that is not enough, columns go into groups below each other,
//! each beside the keys of the rows again. Figures are never broken.

use super::plain;
use super::wrap::{length, line_of, longest_word};
use super::{Cell, Table};

/// Between two columns.
const GAP: usize = 2;

/// What the lines of a name after the first stand in by.
const HANG: usize = 2;

/// How wide a column may be and has to be.
#[derive(Clone, Copy, Debug)]
struct Column {
    natural: usize,
    least: usize,
}

pub(super) fn table(table: &Table, width: usize) -> String {
    let plain = plain::table(&table.rows);
    if plain.lines().all(|line| length(line) <= width) {
        return plain;
    }
    let columns = measured(table, width);
    let groups = grouped(table, &columns, width);
    let blocks: Vec<String> = groups.iter().map(|group| block(table, &columns, group, width)).collect();
    blocks.join("\n")
}

/// A heading of the rows below it belongs to no column.
fn is_heading(row: &[Cell]) -> bool {
    row.len() == 1
}

fn measured(table: &Table, width: usize) -> Vec<Column> {
    let count = table.columns();
    let cells = |column: usize| {
        let rows = table.rows.iter().enumerate().filter(|(_, row)| !is_heading(row));
        rows.filter_map(move |(index, row)| Some((index < table.heads, row.get(column)?.as_ref())))
    };
    let natural = |column: usize| cells(column).map(|(_, cell)| length(cell)).max().unwrap_or(0);
    let mut columns: Vec<Column> = Vec::with_capacity(count);
    for column in 0..count {
        let natural = natural(column);
        let words = cells(column).map(|(_, cell)| broken(cell, column == 0)).max().unwrap_or(0);
        let whole = cells(column).map(|(head, cell)| if head { longest_word(cell) } else { length(cell) }).max();
        let least = match columns.first() {
            // The first column leaves room for others.
            None => natural.min(words.max(width * 2 / 5)),
            // Only what would not fit at all is broken between its words.
            Some(first) => whole.filter(|whole| first.least + GAP + whole <= width).unwrap_or(words),
        };
        columns.push(Column { natural, least });
    }
    columns
}

/// How narrow a cell can be.
fn broken(cell: &str, first: bool) -> usize {
    let trimmed = cell.trim_start();
    let indent = length(cell) - length(trimmed);
    let hang = if first && trimmed.contains(' ') { HANG } else { 0 };
    longest_word(trimmed) + indent + hang
}

/// Columns beside the keys, in as few groups as there is room for, and these as even as they can be.
fn grouped(table: &Table, columns: &[Column], width: usize) -> Vec<Vec<usize>> {
    let keys = table.keys.min(columns.len());
    let least = |of: &[Column]| of.iter().map(|column| column.least + GAP).sum::<usize>();
    let beside = least(&columns[..keys]).saturating_sub(GAP);
    let within = |width: usize| {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        let mut used = usize::MAX;
        for (pack, of) in columns[keys..].chunks(table.together.max(1)).enumerate() {
            let first = keys + pack * table.together.max(1);
            let (pack, needs) = (first..first + of.len(), least(of));
            match groups.last_mut() {
                Some(group) if used.saturating_add(needs) <= width => {
                    group.extend(pack);
                    used += needs;
                }
                _ => {
                    groups.push(pack.collect());
                    used = beside + needs;
                }
            }
        }
        groups
    };
    let mut best = within(width);
    for narrower in (0..width).rev() {
        let groups = within(narrower);
        if groups.len() > best.len() {
            break;
        }
        best = groups;
    }
    if best.is_empty() { vec![Vec::new()] } else { best }
}

/// One group of columns beside the keys.
fn block(table: &Table, columns: &[Column], group: &[usize], width: usize) -> String {
    let shown: Vec<usize> = (0..table.keys.min(columns.len())).chain(group.iter().copied()).collect();
    let widths = widths(table, columns, &shown, width);
    let mut text = String::new();
    for (index, row) in table.rows.iter().enumerate() {
        if is_heading(row) {
            line_of(row[0].as_ref(), width, HANG).iter().for_each(|line| text.extend([line, "\n"]));
            continue;
        }
        let cells: Vec<Vec<String>> = shown
            .iter()
            .zip(&widths)
            .map(|(&column, &width)| wrapped(row.get(column).map_or("", AsRef::as_ref), column == 0, width))
            .collect();
        let height = cells.iter().map(Vec::len).max().unwrap_or(1);
        for line in 0..height {
            // Heads stand on the figures below them; figures stand beside the beginning of their name.
            let at = |cell: &Vec<String>| match index < table.heads {
                true => (line + cell.len()).checked_sub(height),
                false => Some(line),
            };
            let of = |cell: &Vec<String>| at(cell).and_then(|at| cell.get(at)).cloned().unwrap_or_default();
            let line: Vec<String> = cells.iter().map(of).collect();
            text.push_str(&plain::line(&line, &widths));
            text.push('\n');
        }
    }
    text
}

fn wrapped(cell: &str, first: bool, width: usize) -> Vec<String> {
    let indent = cell.len() - cell.trim_start().len();
    let lines = line_of(cell, width, if first { indent + HANG } else { 0 });
    if first { lines } else { lines.iter().map(|line| line.trim().to_string()).collect() }
}

/// Room that is left over goes to the names, and then to the heads that take most lines.
fn widths(table: &Table, columns: &[Column], shown: &[usize], width: usize) -> Vec<usize> {
    let mut widths: Vec<usize> = shown.iter().map(|&column| columns[column].least).collect();
    let mut room = width.saturating_sub(widths.iter().sum::<usize>() + GAP * (shown.len() - 1));
    let names = room.min(columns[0].natural - widths[0]);
    widths[0] += names;
    room -= names;
    let height = |place: usize, width: usize| {
        let cells = table.rows.iter().filter(|row| !is_heading(row)).filter_map(|row| row.get(shown[place]));
        cells.map(|cell| line_of(cell.as_ref(), width, 0).len()).max().unwrap_or(1)
    };
    while room > 0 {
        let tallest = (1..shown.len()).max_by_key(|&place| (height(place, widths[place]), shown.len() - place));
        match tallest {
            Some(place) if height(place, widths[place]) > 1 && widths[place] < columns[shown[place]].natural => {
                widths[place] += 1;
                room -= 1;
            }
            _ => break,
        }
    }
    widths
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wording::figures::row;

    fn fitted(heads: usize, rows: &[Vec<String>], width: usize) -> String {
        let text = table(&Table::new(rows).heads(heads), width);
        let longest = text.lines().map(length).max();
        assert!(longest <= Some(width), "{longest:?} of {width}:\n{text}");
        text
    }

    #[test]
    fn heads_wrap_before_columns_are_parted() {
        let rows = [row(["", "first touch, ms", "peak, N"]), row(["distal", "4.501317", "100.0"])];
        assert_eq!(fitted(1, &rows, 40), "        first touch, ms  peak, N\ndistal         4.501317    100.0\n");
        assert_eq!(
            fitted(1, &rows, 24),
            "            first  peak,\n        touch, ms      N\ndistal   4.501317  100.0\n"
        );
    }

    #[test]
    fn columns_that_find_no_room_go_below_beside_the_names() {
        let rows = [row(["place", "run", "design", "force"]), row(["1", "12345678", "12345678", "12345678"])];
        assert_eq!(
            fitted(1, &rows, 26),
            "place       run    design\n1      12345678  12345678\n\nplace     force\n1      12345678\n"
        );
    }

    #[test]
    fn groups_are_even_and_headings_stand_over_each() {
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
    fn keys_of_several_columns_are_told_again_and_packs_stay_together() {
        let rows =
            [row(["law", "step", "a", "max", "b", "max"]), row(["step", "1.00", "1111", "2222", "3333", "4444"])];
        let text = table(&Table::new(&rows).keys(2).together(2), 26);
        assert_eq!(
            text,
            "law   step     a   max\nstep  1.00  1111  2222\n\nlaw   step     b   max\nstep  1.00  3333  4444\n"
        );
    }

    #[test]
    fn long_names_wrap_and_their_figures_stand_beside_their_first_line() {
        let rows = [row(["bound", "limit"]), row(["a bound of many words", "0.001"])];
        assert_eq!(fitted(1, &rows, 20), "bound          limit\na bound of     0.001\n  many words\n");
    }

    #[test]
    fn what_has_no_room_is_as_wide_as_its_words() {
        let rows = [row(["name", "value"]), row(["a", "1.23456789"])];
        let text = table(&Table::new(&rows), 5);
        assert!(text.contains("1.23456789"), "{text}");
    }
}
