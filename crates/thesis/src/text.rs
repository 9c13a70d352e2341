//! Units of columns, numbers without trailing zeros, and CSV.

use serde::Serialize;

/// Units of figures and columns: name, factor from SI units to the unit, and suffix of the key.
pub const UNITS: [(&str, f64, &str); 8] = [
    ("", 1.0, ""),
    ("%", 1.0, "_percent"),
    ("N·mm", 1e3, "_n_m"),
    ("mm", 1e3, "_m"),
    ("g", 1e3, "_kg"),
    ("ms", 1e3, "_s"),
    ("N", 1.0, "_n"),
    ("°", 180.0 / std::f64::consts::PI, "_rad"),
];

/// Returns the unit of a column of SI values and the factor from SI, according to the longest suffix of its name.
pub(crate) fn column_unit(column: &str) -> (&'static str, f64) {
    let units = UNITS.iter().filter(|(.., suffix)| column.ends_with(suffix));
    units.max_by_key(|(.., suffix)| suffix.len()).map_or(("", 1.0), |&(unit, scale, _)| (unit, scale))
}

/// Formats a number with up to `decimals` decimals, without trailing zeros.
pub fn short(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

/// Returns a length in mm without the rounding error of its conversion.
pub(crate) fn rounded_mm(value_m: f64) -> f64 {
    (1e3 * value_m * 1e6).round() / 1e6
}

/// Formats a count with its share of `total` in percent.
pub(crate) fn count_and_share(count: usize, total: usize) -> String {
    format!("{count} ({:.1} %)", 100.0 * count as f64 / total as f64)
}

/// Returns rows as CSV, with the names of their fields as header. Unknown values are empty.
pub fn csv<T: Serialize>(rows: &[T]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().for_each(|row| writer.serialize(row).expect("a row is plain data"));
    String::from_utf8(writer.into_inner().expect("memory is written")).expect("CSV is text")
}
