//! Formats tables with columns as wide as their longest cell.

/// Formats rows in columns as wide as their longest cell, separated by two spaces: the first aligned left, the others right.
pub(super) fn table(rows: &[Vec<impl AsRef<str>>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.as_ref().chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    rows.iter().map(|row| line(row, &widths) + "\n").collect()
}

/// Formats one line of cells.
pub(super) fn line(row: &[impl AsRef<str>], widths: &[usize]) -> String {
    let mut line = String::new();
    for (column, (cell, &width)) in row.iter().zip(widths).enumerate() {
        let cell = cell.as_ref();
        let gap = " ".repeat(width.saturating_sub(cell.chars().count()));
        match column {
            0 => line.extend([cell, gap.as_str()]),
            _ => line.extend(["  ", gap.as_str(), cell]),
        }
    }
    line.truncate(line.trim_end().len());
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn aligns_columns_with_non_ascii_units() {
        let cells = |row: [&str; 3]| row.map(String::from).to_vec();
        let text = table(&[cells(["", "µm", "F"]), cells(["distal", "2.5", "100.0"])]);
        assert_eq!(text, "         µm      F\ndistal  2.5  100.0\n");
    }
}
