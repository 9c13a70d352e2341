//! Small aligned tables and figures of a chosen number of digits.

/// Rows of cells in columns as wide as they need: the first to the left, the others to the right, two spaces between.
pub fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let mut line = String::new();
        for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            let gap = " ".repeat(width - cell.chars().count());
            match column {
                0 => line.extend([cell, gap.as_str()]),
                _ => line.extend(["  ", gap.as_str(), cell]),
            }
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

/// Cells of a row.
pub fn row<const N: usize>(cells: [&str; N]) -> Vec<String> {
    cells.map(String::from).to_vec()
}

/// A number with so many significant digits: plain from 1e-3 to 1e6, with an exponent beyond.
pub fn figure(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".to_string();
    }
    if !value.is_finite() {
        return "–".to_string();
    }
    let decimals = digits.saturating_sub(1);
    // Through the rounded form: 9.9996 with four digits has two digits before the point.
    let scientific = format!("{value:.decimals$e}");
    let exponent: i32 = scientific.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0);
    if !(-3..6).contains(&exponent) {
        return scientific;
    }
    let places = usize::try_from(decimals as i32 - exponent).unwrap_or(0);
    format!("{value:.places$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up_also_with_units_beyond_ascii() {
        let cells = |row: [&str; 3]| row.map(String::from).to_vec();
        let text = table(&[cells(["", "µm", "F"]), cells(["distal", "2.5", "100.0"])]);
        assert_eq!(text, "         µm      F\ndistal  2.5  100.0\n");
    }

    #[test]
    fn figures_keep_their_digits() {
        for (value, expected) in [
            (0.0, "0"),
            (23.60921, "23.609"),
            (9.99996, "10.000"),
            (-0.0012345678, "-0.0012346"),
            (98765.4321, "98765"),
            (1.5e-9, "1.5000e-9"),
            (f64::INFINITY, "–"),
        ] {
            assert_eq!(figure(value, 5), expected);
        }
    }
}
